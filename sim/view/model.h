// Robot and room as the page draws them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

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

}  // namespace sim::view
