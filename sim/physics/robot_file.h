// The contents of a robot's robot.yaml: the parts of its model by name, and data that models do not contain.
// sim/scenario reads it, and includes only this header and options.h of this folder.
#pragma once

#include <map>

#include "sim/files/text.h"
#include "sim/rig/rig.h"
#include "walking/robot.h"

namespace sim::physics {

/// A robot is a folder with a model and robot.yaml. Everything below uses one adapted model. It has a free
/// base; position servos named like their joints and in the same order; the sites left_sole and right_sole (x
/// ahead, z up) and imu; the camera head_camera; and the soles' force and torque sensors left_force,
/// left_torque, right_force and right_torque.
struct RobotFile {
  fs::path folder;  ///< its name is the robot's
  std::string model = "robot.xml";
  std::map<std::string, fs::path> packages;  ///< folders of a URDF's packages
  std::string base;                          ///< body with the free joint: the plan's waist
  rig::Mount head_camera, imu;               ///< the camera's mount and the stabilizer IMU's; with links
  std::array<std::vector<std::string>, 2> legs, arms;  ///< by Side; joints, hip to ankle; shoulder, elbow

  struct Foot {
    std::string body;
    Eigen::Vector3d sole_m = Eigen::Vector3d::Zero();  ///< its point below the ankle, in the body's axes
    double sole_roll_rad = 0, sole_pitch_rad = 0, sole_yaw_rad = 0;  ///< fixed axes, in this order
    std::vector<std::string> contacts;  ///< geoms that touch the floor; empty: as in the model
    bool force_sensor = true;
    double pad_roll_nm_rad = 0, pad_pitch_nm_rad = 0, pad_lag_s = 0;

    static void keys(auto&& key) {
      value<&Foot::body>(key, "body whose underside is the sole");
      number<&Foot::sole_m>(key, -1, 1, "point of the sole below the ankle, in the axes of the body");
      degrees<&Foot::sole_roll_rad>(key, -180, 180, "turn of the sole's axes about the body's x axis, first");
      degrees<&Foot::sole_pitch_rad>(key, -180, 180, "turn about the body's y axis, second");
      degrees<&Foot::sole_yaw_rad>(key, -180, 180, "turn about the body's z axis, last");
      value<&Foot::contacts>(key, "geoms that touch the floor; default: the colliding ones in the model");
      value<&Foot::force_sensor>(key, "whether the ankle has a force sensor");
      number<&Foot::pad_roll_nm_rad>(key, 0, 1e9,
                                     "stiffness of the pads against roll of the sole; 0: unknown");
      number<&Foot::pad_pitch_nm_rad>(key, 0, 1e9, "stiffness of the pads against pitch; 0: unknown");
      number<&Foot::pad_lag_s>(key, 0, 1, "time constant of the pads: damping over stiffness");
    }
  };
  std::array<Foot, 2> feet;  ///< by Side

  std::map<std::string, double> posture_rad;  ///< start angles that are not zero

  /// A position servo: torque kp (q_ref - q) + kd (dq_ref - dq), within the effort limit.
  struct Servo {
    std::vector<std::string> joints;
    double kp_nm_rad = 0, kd_nms_rad = 0;
    std::optional<double> armature_kg_m2, effort_nm;  ///< absent: as in the model
  };
  std::vector<Servo> servos;

  walking::StepLimits step;
  std::map<std::string, std::string> places;  ///< "file:line:column" of each key, for messages

  /// Throws std::invalid_argument "file:line:column: key: message".
  template <typename... T>
  [[noreturn]] void fail(const std::string& key, fmt::format_string<T...> message, T&&... values) const {
    const auto place = places.find(key);
    throw std::invalid_argument((place == places.end() ? (folder / "robot.yaml").string() : place->second) +
                                ": " + key + ": " + fmt::format(message, std::forward<T>(values)...));
  }
};

}  // namespace sim::physics
