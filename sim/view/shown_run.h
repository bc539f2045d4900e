// A run as the page shows it, besides its frames: room and robot, moments, and what is missing.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "slam/options.h"

namespace sim::view {

/// Triangles that share a body and a picture, in the axes of their body, those of the room in W.
struct ModelPiece {
  int body = -1;                                   ///< index of the pose in Frame::bodies; -1: the room
  int picture = -1;                                ///< index in the pictures; -1: plain colour
  std::vector<float> positions, normals, colours;  ///< three of each vertex: m; of unit length; RGB, 0-1
  std::vector<float> uv;  ///< two of each vertex, from the picture's upper left; empty without a picture
  std::vector<std::uint32_t> indices;  ///< three of each triangle
};

struct Model {
  std::vector<ModelPiece> pieces;
  /// RGB; painted when the page asks for them. May be called from another thread, once.
  std::function<std::vector<cv::Mat3b>()> pictures = [] { return std::vector<cv::Mat3b>(); };
};

/// The pieces as the page reads them: the length of a JSON list (little-endian, four bytes), {body, picture,
/// vertices, indices} of each, blanks up to a multiple of four bytes, then for each positions, normals,
/// colours, uv (float32) and indices (uint32).
std::string model_bytes(const Model& model);

/// Width, height (uint32) and RGB rows of each picture.
std::string picture_bytes(const std::vector<cv::Mat3b>& pictures);

/// A time to jump to. kind: "closure", "fault", "lost", "suspect" or "end".
struct Moment {
  double t_s = 0;
  std::string kind, text;
};

struct ShownRun {
  std::string label;  ///< "tangent_circle, seed 1"
  std::optional<slam::CameraIntrinsics> camera = std::nullopt;
  double duration_s = 0;  ///< 0: unknown
  std::vector<Moment> moments = {};
  std::vector<std::string> missing = {};  ///< sentences: what is not shown, and why
  std::optional<Model> model = std::nullopt;
  bool next_follows = false;  ///< another walk follows at the same address
};

/// The faults that a scenario injects.
std::vector<Moment> faults_of(const scenario::Scenario& scenario);

nlohmann::ordered_json to_json(const ShownRun& run);

}  // namespace sim::view
