// The sensors of the body that are recorded for other readers: the filter is not given them, nothing reads
// them back.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slam/observation.h"

namespace sim::recording {

/// What the sensors of the body give at one instant.
struct BodyReading {
  struct Wrench {
    Eigen::Vector3d force = Eigen::Vector3d::Zero(),  ///< N
        torque = Eigen::Vector3d::Zero();             ///< N·m about the point of the sole below the ankle
  };
  slam::Stamp t{0};
  Eigen::VectorXd q;   ///< rad, one for each joint of the setup
  Wrench left, right;  ///< of the ground on each foot, axes of the sole
};

/// One folder mav0/<name> of a recording: what its files say.
struct BodySensor {
  std::string name;
  std::string type, comment;                                       ///< of sensor.yaml
  std::string (*yaml)(const std::vector<std::string>& joints);     ///< further lines of sensor.yaml
  std::string (*columns)(const std::vector<std::string>& joints);  ///< titles of data.csv, each after a comma
  std::string (*values)(const BodyReading& reading);               ///< fields of a row, each after a comma
};

/// All of them, in the order of the manifest.
const std::vector<BodySensor>& body_sensors();

}  // namespace sim::recording
