// A user's robot as MuJoCo compiles its file.
#pragma once

#include <functional>
#include <map>
#include <set>

#include "sim/model_file/model_file.h"
#include "sim/physics/model.h"

namespace sim::physics {

/// The torques that a joint's actuators can exert, N m: all of them together, within `actuatorfrcrange`.
struct Effort {
  double lowest = 0, highest = 0;
};

struct CompiledRobot {
  model_file::ModelFile file;
  Model model;
  int base = 0;  ///< the first body with mass below the world
  std::map<std::string, Effort> efforts;
  /// Geoms with a contact pair whose other geom is not the robot's.
  std::vector<std::string> paired_with_floor;
};

/// Returns the elements and attributes that MuJoCo's parser knows.
const model_file::Schema& schema();

/// base: the base's name, or "". Throws FileError "file:line: ..." if MuJoCo rejects the file, if the base is
/// not free, or if mass, size or moments of inertia are not in kg, m and kg m^2.
CompiledRobot compile_robot(const fs::path& file, const std::string& base,
                            const model_file::Packages& packages);

/// Writes the numbers of a compiled model as MJCF in which each attribute is explicit, so that no default of
/// another file applies.
class Writer {
 public:
  /// file: the text that was compiled. prefix: for names of assets. Both must outlive this object.
  Writer(const mjModel_& model, const model_file::ModelFile& file, std::string prefix);

  std::set<int> rigid;                                        ///< joints that are left out
  std::map<int, std::vector<model_file::Element>> additions;  ///< elements to add to bodies

  /// Returns a body with all bodies below it, moved by X.
  model_file::Element body(int body, const Eigen::Isometry3d* X = nullptr) const;
  /// Adds a body's shapes, sites, lights and child bodies to an element, moved by X.
  void add_content(int body, model_file::Element& to, const Eigen::Isometry3d* X = nullptr) const;
  /// Adds `asset`, `tendon` and `equality`; couplings of left-out joints are left out.
  void add_sections(model_file::Element& root) const;
  /// Returns the body to which the shapes of a body are added: the one around it if it stands for a `frame`.
  int owner(int body) const;
  /// Returns the name of a part (mjtObj), or "".
  std::string name(int type, int id) const;

 private:
  model_file::Element part(const char* kind, int type, int id, const char* attributes) const;
  void add(model_file::Element& element, const char* attributes, int id) const;
  void place(model_file::Element& element, const double* p, const double* q,
             const Eigen::Isometry3d* X) const;
  model_file::Element joint(int joint) const;
  model_file::Element geom(int geom, const Eigen::Isometry3d* X) const;
  model_file::Element material(int material) const;
  model_file::Element tendon(int tendon) const;
  std::string site_name(int site) const;
  bool is_fused(int body) const;

  const mjModel_& m_;
  const model_file::ModelFile& file_;
  std::string prefix_;
  std::map<std::string, std::function<std::string(int)>> texts_;  // texts of the model's arrays, by name
  std::map<int, Eigen::Isometry3d> meshes_;  // motion that the library applied to each mesh
};

/// Returns the base with its free joint and the bodies below it.
model_file::Element written_base(const CompiledRobot& robot, const Writer& writer);

}  // namespace sim::physics
