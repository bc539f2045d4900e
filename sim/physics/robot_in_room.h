// Loads robot and room into one MuJoCo model.
#pragma once

#include "sim/physics/model.h"

namespace sim::physics {

/// The physics' room, a bare floor: the shapes of a furnished room would slow down each step. Whether the
/// robot touches those is checked separately (clearance.h). A room's geoms of class floor are added to the
/// bare floor, or replace it if they include a plane or a height field.
inline constexpr char kPhysicalRoom[] = "floor";

/// Which shapes are kept: all visible ones, or only the room's floor and those of the robot's shapes that can
/// touch something (faster to step).
enum class Shapes { all, floor };

/// Returns an adapted robot in its room as one model. Names of the room that are also the robot's are
/// changed. Throws std::runtime_error "file:line: ..." if a file is rejected.
Model join(const model_file::Element& robot, const std::string& room, const std::filesystem::path& models,
           Shapes shapes);
/// Returns the robot in its room as one model. Throws std::runtime_error "file:line: ..." if a file is
/// rejected.
Model load_model(const RobotFile& robot, const std::string& room, const std::filesystem::path& models,
                 Shapes shapes = Shapes::all);

}  // namespace sim::physics
