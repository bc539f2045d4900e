// Draws lit, textured triangles with OpenGL.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "sim/camera/gl.h"

namespace sim::camera {

/// A corner of a triangle. Where only grey is drawn, `light` is (brightness, unused, unused).
struct Vertex {
  Eigen::Vector3f p;
  Eigen::Vector2f uv;
  Eigen::Vector3f light;  ///< 0-1; multiplied with the texture
};

/// Triangles of one buffer of vertices, drawn by their indices into the current frame buffer of the current
/// OpenGL context. The nearer surface hides the farther one. Rows count downwards in what is drawn: the front
/// of a triangle is the side that shows its corners counter-clockwise in a picture with its first row on top.
class Rasterizer {
 public:
  /// Throws std::runtime_error when the renderer cannot compile its shaders.
  Rasterizer(Channels channels, std::size_t vertices);
  ~Rasterizer();
  Rasterizer(const Rasterizer&) = delete;
  Rasterizer& operator=(const Rasterizer&) = delete;

  void set_vertices(std::size_t first, std::span<const Vertex> vertices);
  /// Sets the viewport of the next triangles, and the transformation of their points to clip coordinates.
  void set_view(const cv::Rect& viewport, const Eigen::Matrix4f& clip_from_points);
  /// Three indices for each triangle; texture 0: none.
  void draw(std::span<const std::uint32_t> indices, unsigned texture);

 private:
  struct Program {
    unsigned name = 0;
    int clip_from_points = -1;
  };
  static Program program(Channels channels, bool textured);
  static void set(const Program& program, const Eigen::Matrix4f& clip_from_points);

  Program plain_, textured_;
  unsigned buffer_ = 0;
};

}  // namespace sim::camera
