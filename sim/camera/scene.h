// Draws a MuJoCo model, the room with the robot in it, off-screen from any pose. Also the pictures on its
// surfaces (textures.cc), which the model file only names, so that physics loads fast.
#pragma once

#include "sim/camera/gl.h"
#include "sim/camera/lens.h"
#include "sim/camera/shapes.h"

namespace sim::camera {

/// The depth of a picture, as measured by a depth camera.
struct DepthPicture {
  cv::Mat1f buffer;  ///< 0 at the near plane, 1 at the far plane and for pixels without a surface
  cv::Mat marks;     ///< not 0 on surfaces that return no light to depth cameras

  /// Returns 1/z (1/m), z along the axis of each view; 0: nothing, or a surface that returns no light.
  cv::Mat1f inverse_depth() const;
};

/// Draws the geoms of a model's groups 0 and 1, and of group 2 (the head) on request, with textures painted
/// from a seed. Glass (alpha below 1) is blended over the surfaces behind it, and depth passes through. Owns
/// an OpenGL context of its thread. Lighting does not depend on the camera: it is computed once for
/// everything that never moves.
class Scene {
 public:
  /// A picture shows all `views` side by side. shares: a scene with the same model, seed and channels, whose
  /// textures are shared; it may draw on another thread. Throws std::runtime_error without OpenGL.
  Scene(const mjModel& model, std::vector<Pinhole> views, std::uint64_t texture_seed, Channels channels,
        Robot robot = Robot::without_head, const Scene* shares = nullptr);
  /// Returns the views from X_WC (x right, y down, z ahead), CV_8UC1 or RGB. The positions in `data` must
  /// have been computed. `light`: fraction of the room's light that is on; emitters keep their brightness,
  /// except the lamps' ceiling.
  cv::Mat draw(const mjData& data, const Eigen::Isometry3d& X_WC, float light = 1);
  /// Returns the depth of the last draw().
  DepthPicture read_depth();

 private:
  struct Piece {
    int geom;
    unsigned texture;
    bool moves;
    Paint paint;
    GeomMesh mesh;  // its indices count from the buffer's first vertex
    std::size_t first_vertex;
    Eigen::Vector3f half = Eigen::Vector3f::Zero();  // half sizes of a box around the geom
    Eigen::Isometry3f X_WG = Eigen::Isometry3f::Identity();
  };
  struct Seen {
    const Piece* piece;
    float depth;
  };

  void add_piece(int geom, unsigned texture);
  void add_masks();
  void light_piece(const Piece& piece, float light);
  std::vector<Seen> seen_by(const Pinhole& view, const Eigen::Isometry3f& X_VW) const;
  void draw_view(std::size_t view, const Eigen::Isometry3f& X_VW, const std::vector<Seen>& seen);

  const mjModel& model_;
  std::vector<Pinhole> views_;
  Channels channels_;
  std::vector<Piece> pieces_;  // pieces that never move come first
  std::vector<Vertex> vertices_;
  std::vector<std::vector<std::uint32_t>> masks_;  // for each view: the areas that its image does not sample
  std::vector<std::vector<Seen>> seen_;            // by view, in the last picture
  std::vector<Eigen::Isometry3f> X_VW_;            // likewise
  struct {
    std::size_t count = 0;  // number at the start of the buffer
    float lit_by = -1;      // light on them; -1: none yet
  } still_vertices_;
  Renderer renderer_;
  std::vector<unsigned> textures_;  // by their index in the model
  Lamps lamps_;
};

/// Returns the RGB picture of a 2d texture, painted from a seed if paint_texture knows its name. On a floor
/// or a wall it includes soft shadows of the furniture. The positions in `data` must have been computed.
cv::Mat3b texture_picture(const mjModel& model, const mjData& data, int texture, std::uint64_t seed);

/// Loads the model's 2d textures with mipmaps in the current OpenGL context. Returns their OpenGL names.
std::vector<unsigned> load_textures(const mjModel& model, std::uint64_t seed, Channels channels);

}  // namespace sim::camera
