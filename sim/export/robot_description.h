// The robot of a run, for viewers that draw it. The simulator's model supplies it, which exports do not see.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

namespace sim::exports {

struct RobotDescription {
  std::string urdf;                ///< its root is the link "waist"
  std::vector<std::string> links;  ///< those that joints move
  /// The poses of these links in the waist's frame, by the angles (rad) of the encoders. Throws
  /// std::runtime_error for another number of angles than the robot has.
  std::function<std::vector<Eigen::Isometry3d>(const Eigen::VectorXd& q)> poses;
};

}  // namespace sim::exports
