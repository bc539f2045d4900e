// Reads a robot's public model file, MJCF or URDF, into MJCF that the library in use can load with any room.
#pragma once

#include <map>
#include <set>

#include "sim/model_file/element.h"

namespace sim::model_file {

/// The elements and attributes that the library knows, from the schema that it prints.
class Schema {
 public:
  /// printed: the output of mj_printSchema as text.
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

/// What happened to parts of a file that the library or the bench cannot use unchanged.
enum class Fate { kept_aside, dropped, converted };
struct Note {
  Fate fate;
  std::string what, first;  ///< first: "file:line" of the first occurrence
  int count = 1;
};

struct ModelFile {
  /// MJCF in radians, without defaults: `compiler`, `asset`, `worldbody` with only the robot, `tendon` and
  /// `equality`. Paths are absolute. Names of assets start with "robot/", so that they cannot clash with a
  /// room's.
  Element root;
  std::vector<Note> notes;
  std::map<std::string, double> efforts;       ///< torque limits by joint, N m
  std::optional<double> mass_kg;               ///< sum of the links' masses, if the file gives them all
  std::vector<std::string> paired_with_floor;  ///< geoms
};

/// The parts of a model file that robot.yaml names.
struct Parts {
  std::string base = {};  ///< root body; "": the body in the file with the most joints
  /// Geoms that touch the floor; absent: those that may collide according to the file.
  std::optional<std::vector<std::string>> contacts = {};
};

/// Reads a file with its includes. Throws FileError "file:line: element attribute: what is wrong, expected
/// ...".
ModelFile read_model(const std::filesystem::path& file, const Schema& schema, const Parts& parts = {});

/// Reads the MJCF of a room in the same way: shapes, lights and `visual`, nothing that moves, and a plane
/// named "floor". Asset names stay unchanged. Throws FileError.
ModelFile read_room(const std::filesystem::path& file, const Schema& schema);

/// Contact bits of a room's geoms of class floor: the soles' bit, and a bit that only these geoms have.
inline constexpr int kSteppedBits = 9;
/// Returns whether a geom of a room read by read_room() is of class floor.
bool is_floor(const Element& geom);

/// Returns a model's file, the existing files that it includes, and the files of its assets. Throws
/// FileError.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& file);

/// Returns the MJCF tree of a URDF tree. Throws FileError.
Element mjcf_of_urdf(const Element& robot, std::vector<Note>& notes);

/// Counts another case in the note with that fate and text, or adds such a note.
void add_note(std::vector<Note>& notes, Fate fate, std::string_view what, const Element& where);

}  // namespace sim::model_file
