// Off-screen OpenGL (OSMesa, software): a picture of lit, textured triangles.
#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace sim::camera {

/// Returns the address of an OpenGL function. The first call loads OSMesa: its compiler (LLVM) would cost
/// every process 20 ms at startup. Throws std::runtime_error if OSMesa or the function is missing.
void* gl_function(const char* name);

/// A function of OpenGL or OSMesa: GL(glClear)(GL_COLOR_BUFFER_BIT).
#define GL(name)                                                                                    \
  ([] {                                                                                             \
    static const auto found = reinterpret_cast<decltype(&::name)>(sim::camera::gl_function(#name)); \
    return found;                                                                                   \
  }())

/// Channels of a picture: only brightness, as the head camera sees it (cheaper), or colors, for people.
enum class Channels { gray = 1, rgb = 3 };

/// A corner of a triangle. For gray pictures, `light` is (brightness, unused, unused).
struct Vertex {
  Eigen::Vector3f p;
  Eigen::Vector2f uv;
  Eigen::Vector3f light;  ///< 0-1; multiplied by the texture
};

/// An OSMesa context with a picture, its depth, and triangles from one vertex buffer. The nearer surface
/// hides the farther one. Rows are counted downward: a triangle's front is the side from which its corners
/// appear counter-clockwise in a picture whose first row is on top. One core draws (LP_NUM_THREADS=0), so
/// frames and their cost do not depend on the machine's load.
class Renderer {
 public:
  /// Uses the textures of `shares` too, if given. Throws std::runtime_error if OpenGL is not usable.
  Renderer(const cv::Size& size_px, Channels channels, const Renderer* shares = nullptr);
  /// Frees everything created in the context; textures are freed with the last context that shares them.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Makes the context current on this thread. No other thread uses OpenGL until the returned lock is
  /// released, because Mesa 22 crashes: a context that maps a buffer reads the scenes of all others without a
  /// lock (llvmpipe_flush_resource). Must be called before all functions below.
  [[nodiscard]] std::unique_lock<std::mutex> use();
  /// Sets the number of vertices.
  void reserve(std::size_t vertices);
  void set_vertices(std::size_t first, std::span<const Vertex> vertices);
  /// Clears the picture to black and its depth to infinity.
  void clear();
  /// Sets the viewport for the next triangles and the transformation of their points to clip coordinates.
  void set_view(const cv::Rect& viewport, const Eigen::Matrix4f& clip_from_points);
  /// Draws triangles, three indices for each; texture 0: none. With alpha below 1, they are blended into the
  /// existing picture and leave its depth unchanged.
  void draw(std::span<const std::uint32_t> indices, unsigned texture, float alpha = 1);
  /// Returns the picture: CV_8UC1 or CV_8UC3 (RGB).
  cv::Mat read() const;
  /// Returns the depth buffer: 0 at the near plane, 1 at the far plane and for pixels without a surface.
  cv::Mat1f read_depth() const;
  /// Clears the picture to black. The visible parts of triangles drawn before end_marks() become
  /// white.
  void begin_marks();
  void end_marks();

 private:
  void make_current();
  void make_frame();

  std::vector<unsigned char> window_;  ///< OSMesa needs a window buffer; nothing is ever drawn in it
  OSMesaContext context_ = nullptr;
  cv::Size size_;
  Channels channels_;
  unsigned plain_ = 0, textured_ = 0;  ///< shader programs
};

}  // namespace sim::camera
