// The robot and the room for viewers: triangles for each body, colors, pictures and poses; and the robot as
// URDF.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "sim/physics/arrangement.h"
#include "sim/physics/robot.h"
#include "walking/kinematics.h"

namespace sim::camera {

/// Triangles that share a body and a picture. Vertices are in the frame of their body, or in W for the room.
struct DrawnPiece {
  int body = -1;                                  ///< index in PosedRobot::bodies(); -1: the room
  int picture = -1;                               ///< index in PosedRobot::pictures(); -1: plain color
  float alpha = 1;                                ///< below 1: glass, without a picture
  std::vector<float> positions, normals, colors;  ///< three per vertex: in m; of unit length; RGB, 0-1
  std::vector<float> uv;  ///< two per vertex; (0, 0) is the picture's upper left; empty without a picture
  std::vector<std::uint32_t> indices;  ///< three per triangle, counter-clockwise seen from outside
};

/// Returns seven numbers for each named body: its position (m, in W) and its quaternion (x, y, z, w). The
/// positions in `data` must have been computed. Throws std::invalid_argument if the model lacks one of the
/// bodies.
std::vector<float> body_poses(const mjModel_& model, const mjData_& data,
                              const std::vector<std::string>& bodies);

/// A robot in its room, posed by the caller from a recording's encoder readings and true waist poses.
class PosedRobot {
 public:
  /// robot: the file that the model was read from.
  PosedRobot(const physics::RobotFile& robot, physics::Model in_room);

  const mjModel_& model() const { return *model_; }
  const walking::Robot& robot() const { return robot_; }
  /// Returns the names of the bodies that move.
  const std::vector<std::string>& bodies() const { return bodies_; }
  /// Returns the shapes to draw, including the robot's head.
  const std::vector<DrawnPiece>& pieces() const { return pieces_; }
  /// Returns the RGB pictures, painted from a seed; sides are powers of two, at most largest_px.
  std::vector<cv::Mat3b> pictures(std::uint64_t seed, int largest_px) const;
  /// Returns the body_poses() of its bodies at a time. The ankles' bushings are at rest.
  std::vector<float> poses(const walking::BodyPose& pose, double t_s = 0);

 private:
  physics::Model model_;
  physics::Data data_;
  walking::Robot robot_;
  std::vector<std::string> bodies_;
  std::vector<DrawnPiece> pieces_;
  std::vector<int> textures_;
};

/// Returns the robot in the Unified Robot Description Format, for viewers of ROS messages: the body with a
/// free joint as the link "waist", the bodies below it, their hinges with axes and limits (m, rad), and the
/// drawn shapes. The ankles' bushings are at rest. URDF has no capsules or ellipsoids: capsules become
/// cylinders with two spheres, ellipsoids become spheres of the same volume.
std::string urdf(const mjModel_& model);

}  // namespace sim::camera
