// A user's robot as MuJoCo compiles its file.
#pragma once

#include "sim/physics/written.h"

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
CompiledRobot compile_robot(const std::filesystem::path& file, const std::string& base,
                            const model_file::Packages& packages);

/// Returns the base with its free joint and the bodies below it.
model_file::Element written_base(const CompiledRobot& robot, const Writer& writer);

}  // namespace sim::physics
