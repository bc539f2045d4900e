// Robot and room as a viewer draws them: triangles by body, colours and pictures, and the poses of the
// bodies.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "sim/physics/model.h"
#include "walking/kinematics.h"

namespace sim::camera {

/// Triangles that share a body and a picture. Vertices are in the axes of their body, those of the room in W.
struct DrawnPiece {
  int body = -1;                                   ///< index in DrawnModel::bodies; -1: the room
  int picture = -1;                                ///< index in DrawnModel::pictures; -1: plain color
  std::vector<float> positions, normals, colours;  ///< three of each vertex: m; of unit length; RGB, 0-1
  std::vector<float> uv;  ///< two of each vertex; (0, 0) is the picture's upper left; empty without a picture
  std::vector<std::uint32_t> indices;  ///< three of each triangle, counter-clockwise from outside
};

/// All that is drawn of a model.
struct DrawnModel {
  std::vector<std::string> bodies;  ///< that move
  std::vector<DrawnPiece> pieces;
  std::vector<int> pictures;  ///< textures of the model
};

/// The shapes of the model that are drawn, those of the robot's head included.
DrawnModel drawn_model(const mjModel_& model);

/// The pictures of a drawn model, painted from a seed, RGB; sides are powers of two, none longer than
/// largest_px.
std::vector<cv::Mat3b> drawn_pictures(const mjModel_& model, const DrawnModel& drawn, std::uint64_t seed,
                                      int largest_px);

/// Poses of named bodies of a model.
class BodyPoses {
 public:
  /// Throws std::invalid_argument for a body that the model does not have.
  BodyPoses(const mjModel_& model, const std::vector<std::string>& bodies);
  /// Position (m, W) and quaternion (x, y, z, w) of each body, seven numbers. data: positions computed.
  std::vector<float> of(const mjData_& data) const;

 private:
  std::vector<int> ids_;
};

/// A robot in its room that is posed by hand: what a recording's encoders and true waist say.
class PosedRobot {
 public:
  /// Throws std::runtime_error when a model does not load.
  PosedRobot(const std::string& robot, const std::string& room, const std::filesystem::path& models);

  const mjModel_& model() const { return *model_; }
  const DrawnModel& drawn() const { return drawn_; }
  /// As BodyPoses::of. The ankles' bushes are at rest.
  std::vector<float> poses(const walking::BodyPose& pose);

 private:
  physics::Model model_;
  physics::Data data_;
  DrawnModel drawn_;
  BodyPoses bodies_;
};

}  // namespace sim::camera
