// Reads a robot's public model file, MJCF or URDF, into MJCF that the library in use loads beside any room.
#pragma once

#include <map>
#include <set>

#include "sim/model_file/element.h"

namespace sim::model_file {

/// The elements and attributes that the library knows, from the schema that it prints itself.
class Schema {
 public:
  /// printed: by mj_printSchema, as text.
  explicit Schema(std::string_view printed);

  struct Known {
    std::set<std::string, std::less<>> attributes;
    std::map<std::string, Known, std::less<>> children;
    bool recursive = false;  ///< may contain itself
  };
  const Known& root() const { return root_; }

 private:
  Known root_;
};

/// What became of parts of a file that the library or the bench does not take as they are.
enum class Fate { kept_aside, dropped, converted };
struct Note {
  Fate fate;
  std::string what, first;  ///< first: "file:line" of the first one
  int count = 1;
};

/// What a file says of the motor of a joint, in N m, N m/rad and N m s/rad.
struct Motor {
  std::optional<double> effort, kp, kd;
};

struct ModelFile {
  /// MJCF in radians, without defaults: `compiler`, `asset`, `worldbody` with the robot alone, `tendon`,
  /// `equality`. Files are absolute paths, names of assets begin with "robot/": no room interferes.
  Element root;
  std::vector<Note> notes;
  std::map<std::string, Motor> motors;         ///< by joint
  std::optional<double> mass_kg;               ///< sum of the links, if the file gives each of them
  std::vector<std::string> paired_with_floor;  ///< geoms
};

/// What robot.yaml names of a file.
struct Parts {
  std::string base = {};  ///< body at the root; "": of the file's bodies the one with most joints
  /// Geoms that touch the floor; nothing: whatever the file says does.
  std::optional<std::vector<std::string>> contacts = {};
};

/// Reads a file with its includes. Throws FileError "file:line: element attribute: what is wrong, expected
/// ...".
ModelFile read_model(const std::filesystem::path& file, const Schema& schema, const Parts& parts = {});

/// Reads the MJCF of a room in the same way: shapes, lights and `visual`, nothing that moves, with a plane
/// named "floor". Names of assets stay. Throws FileError.
ModelFile read_room(const std::filesystem::path& file, const Schema& schema);

/// Returns a model's file, those that it includes, and those of its assets, as far as they exist. Throws
/// FileError.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& file);

/// Returns the MJCF tree of a URDF tree. Throws FileError.
Element mjcf_of_urdf(const Element& robot, std::vector<Note>& notes);

/// Adds to the note of that fate and text, or makes one.
void add_note(std::vector<Note>& notes, Fate fate, std::string_view what, const Element& where);

}  // namespace sim::model_file
