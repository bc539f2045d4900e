// Robot and room as viewers draw them: triangles by body, colors, pictures, poses; the robot as URDF.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "sim/physics/robot.h"
#include "walking/kinematics.h"

namespace sim::camera {

/// Triangles that share a body and a picture. Vertices are in the axes of their body, those of the room in W.
struct DrawnPiece {
  int body = -1;                                  ///< index in PosedRobot::bodies(); -1: the room
  int picture = -1;                               ///< index in PosedRobot::pictures(); -1: plain color
  std::vector<float> positions, normals, colors;  ///< three of each vertex: m; of unit length; RGB, 0-1
  std::vector<float> uv;  ///< two of each vertex; (0, 0) is the picture's upper left; empty without a picture
  std::vector<std::uint32_t> indices;  ///< three of each triangle, counter-clockwise from outside
};

/// Returns position (m, W) and quaternion (x, y, z, w) of each named body, seven numbers. data: positions
/// computed. Throws std::invalid_argument if the model does not have a body.
std::vector<float> body_poses(const mjModel_& model, const mjData_& data,
                              const std::vector<std::string>& bodies);

/// A robot in its room that is posed by hand: what a recording's encoders and true waist say.
class PosedRobot {
 public:
  /// Throws std::runtime_error when a model does not load.
  PosedRobot(const physics::RobotFile& robot, const std::string& room, const std::filesystem::path& models);

  const mjModel_& model() const { return *model_; }
  const walking::Robot& robot() const { return robot_; }
  /// Returns the names of the bodies that move.
  const std::vector<std::string>& bodies() const { return bodies_; }
  /// Returns the shapes to draw, including those of the robot's head.
  const std::vector<DrawnPiece>& pieces() const { return pieces_; }
  /// Returns the RGB pictures, painted from a seed; sides are powers of two, at most largest_px.
  std::vector<cv::Mat3b> pictures(std::uint64_t seed, int largest_px) const;
  /// Returns the body_poses() of its bodies. The ankles' bushes are at rest.
  std::vector<float> poses(const walking::BodyPose& pose);

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
/// drawn shapes. The ankles' bushes are at rest. URDF has no capsules and ellipsoids: they become cylinders
/// with two spheres, and spheres of the same volume.
std::string urdf(const mjModel_& model);

}  // namespace sim::camera
