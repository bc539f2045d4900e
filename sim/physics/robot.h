// The models of a run and its robot, which is read once from the compiled model and robot.yaml.
#pragma once

#include "sim/controllers/controller.h"
#include "sim/physics/actors.h"
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
/// changed. Actors are bodies that MuJoCo does not move (pose_bodies() does). Throws std::runtime_error
/// "file:line: ..." if a file is rejected.
Model join(const model_file::Element& robot, const std::string& room, const fs::path& models, Shapes shapes,
           const std::vector<Actor>& actors = {});
/// Returns the robot in its room as one model. Throws std::runtime_error "file:line: ..." if a file is
/// rejected.
Model load_model(const RobotFile& robot, const std::string& room, const fs::path& models,
                 Shapes shapes = Shapes::all, const std::vector<Actor>& actors = {});

/// Throws std::invalid_argument with one line: "file:line:column: key: what is wrong, expected ..." for names
/// in robot.yaml, otherwise with the element of the model.
walking::Robot read_robot(const mjModel_& model, const RobotFile& file);

/// The models of a run. Each file is opened once; users copy these models.
struct Models {
  /// Throws std::runtime_error if a model does not load, and whatever read_robot() throws.
  Models(const RobotFile& robot, const std::string& room, const fs::path& folder,
         const std::vector<Actor>& actors = {});
  Models(const model_file::Element& adapted, const RobotFile& robot, const std::string& room,
         const fs::path& folder, const std::vector<Actor>& actors = {});
  /// Moves head camera and chest IMU in both models. In `robot`, the IMU moves to where it is in the start
  /// posture, but keeps its link and its axes. Throws std::invalid_argument as place_of().
  void mount(const rig::Mount& camera, const rig::Mount& imu);

  Model on_floor;  ///< the model to step: the robot on kPhysicalRoom, only colliding shapes
  Model in_room;   ///< the robot in its furnished room, all shapes
  walking::Robot robot;
  bool imu_is_moved = false;
  bool has_force_sensors = true;  ///< at both ankles
};

/// Returns the data about the robot that an external controller receives. file: the file that the models were
/// read from.
controllers::RobotDescription describe(const Models& models, const RobotFile& file);

}  // namespace sim::physics
