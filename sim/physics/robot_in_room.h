// Loads robot and room into one MuJoCo model.
#pragma once

#include "sim/physics/model.h"

namespace sim::physics {

/// The physics' room, a bare floor: the shapes of a furnished room would slow down each step. Collisions
/// with them are checked separately (clearance.h). A room's geoms of class floor are added to the
/// bare floor, or replace it if they include a plane or a height field.
inline constexpr char kPhysicalRoom[] = "floor";

/// The shapes to keep: all visible ones, or only the room's floor and the robot shapes that can touch
/// something (faster to step).
enum class Shapes { all, floor };

/// Returns an adapted robot in its room as one model. Names in the room that the robot also uses are
/// changed. Throws std::runtime_error "file:line: ..." if a file is rejected.
Model join(const model_file::Element& robot, const std::string& room, const std::filesystem::path& models,
           Shapes shapes);
/// Returns the robot in its room as one model. Throws std::runtime_error "file:line: ..." if a file is
/// rejected.
Model load_model(const RobotFile& robot, const std::string& room, const std::filesystem::path& models,
                 Shapes shapes = Shapes::all);

}  // namespace sim::physics
