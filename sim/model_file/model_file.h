// Prepares a user's model, MJCF or URDF, for the library in use: only text is changed, and the library reads
// the numbers.
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

/// The treatment of parts of a file that the library or the bench cannot use unchanged.
enum class Fate { kept_aside, dropped, converted, doubtful };
struct Note {
  Fate fate;
  std::string what, first;  ///< first: "file:line" of the first occurrence
  int count = 1;
};

/// The folders of a URDF's packages, by name.
using Packages = std::map<std::string, fs::path>;

struct ModelFile {
  /// MJCF or URDF that the library loads, with absolute paths and only known elements and attributes. It
  /// contains only the robot, or all shapes of a room. The marks below stand for unknown parts.
  Element root;
  std::vector<Element> assets;  ///< meshes, textures and height fields in MJCF: named, scaled, absolute paths
  std::vector<Note> notes;
  std::vector<Element> pairs;                           ///< contact pairs, which are not in `root`
  std::map<std::string, double> efforts;                ///< torque limits of a URDF's joints, N m
  std::vector<std::pair<std::string, fs::path>> files;  ///< meshes of a URDF, by name in `root`

  /// Returns the element for a body (or link), joint or geom, or the root if there is none.
  const Element& named(std::string_view kind, std::string_view name) const;
};

/// Marks in `root`. A joint's `actuatorfrcrange` is its `user`, so that the library's classes apply; its
/// `actuatorfrclimited` is its `group`. A `frame` is a fixed body, with mass only if its geoms give mass.
inline constexpr int kForceUnlimited = 2;
inline constexpr std::string_view kFrame = "frame/";
/// A body with a shape for each mesh at the origin: it shows how the library moves and turns the mesh.
inline constexpr char kMeshes[] = "mesh/";
/// Contact bits of a room's geoms of class floor: the soles' bit, and a bit that only these geoms have. Such
/// a geom's first `user` number is 1.
inline constexpr int kSteppedBits = 9;

/// Reads a robot's file with its includes. base: the root body; "": the body in the file with the most
/// joints. Throws FileError "file:line: element attribute: what is wrong, expected ...".
ModelFile read_model(const fs::path& file, const Schema& schema, std::string_view base = {},
                     const Packages& packages = {});

/// Reads the MJCF of a room in the same way: shapes, lights and `visual`. Throws FileError.
ModelFile read_room(const fs::path& file, const Schema& schema);

/// Returns a model's file, the existing files that it includes, and the files of its assets. Throws
/// FileError.
std::vector<fs::path> files_of(const fs::path& file, const Packages& packages = {});

/// Prepares a URDF in model.root. Throws FileError.
void prepare_urdf(ModelFile& model, const Packages& packages);
/// Throws FileError unless the library can read an asset's file.
void require_readable(const Element& asset, std::string_view attribute, const fs::path& file);

/// Counts another case in the note with that fate and text, or adds such a note.
void add_note(std::vector<Note>& notes, Fate fate, std::string_view what, const Element& where);

}  // namespace sim::model_file
