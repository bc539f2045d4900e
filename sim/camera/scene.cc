#include "sim/camera/scene.h"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <utility>

#include "sim/physics/model.h"

namespace sim::camera {
namespace {

constexpr float kNear = 0.05f, kFar = 40.0f;

// Planes through the camera's center along the four sides of the view: normals in the view's frame,
// pointing inside.
std::array<Eigen::Vector3f, 4> view_sides(const Pinhole& view) {
  const float l = float(view.left), t = float(view.top);
  const float r = l + float(view.width_px / view.focal_px), b = t + float(view.height_px / view.focal_px);
  return {Eigen::Vector3f(1, 0, -l).normalized(), Eigen::Vector3f(-1, 0, r).normalized(),
          Eigen::Vector3f(0, 1, -t).normalized(), Eigen::Vector3f(0, -1, b).normalized()};
}

// OpenGL's clip coordinates of a point of the view: the picture's left and top sides at -1, z from near to
// far.
Eigen::Matrix4f clip_from_view(const Pinhole& view) {
  const double x = 2 * view.focal_px / view.width_px, y = 2 * view.focal_px / view.height_px;
  Eigen::Matrix4f clip;
  clip << float(x), 0, float(-x * view.left - 1), 0,                              //
      0, float(y), float(-y * view.top - 1), 0,                                   //
      0, 0, (kFar + kNear) / (kFar - kNear), -2 * kFar * kNear / (kFar - kNear),  //
      0, 0, 1, 0;
  return clip;
}

Eigen::Isometry3f pose_of(const mjData& data, int geom) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Isometry3f X_WG = Eigen::Isometry3f::Identity();
  X_WG.translation() = Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom).cast<float>();
  X_WG.linear() = Eigen::Map<const RowMajor>(data.geom_xmat + 9 * geom).cast<float>();
  return X_WG;
}

Eigen::Vector3f mesh_half_extents(const GeomMesh& mesh) {
  Eigen::Vector3f half = Eigen::Vector3f::Zero();
  for (const GeomMesh::Vertex& vertex : mesh.vertices) half = half.cwiseMax(vertex.p.cwiseAbs());
  return half;
}

bool moves(const mjModel& model, int geom) { return model.body_weldid[model.geom_bodyid[geom]] != 0; }

cv::Size joint_size(const std::vector<Pinhole>& views) {
  cv::Size size(0, 0);
  for (const Pinhole& view : views) {
    size.width = std::max(size.width, view.first_column + view.width_px);
    size.height = std::max(size.height, view.height_px);
  }
  return size;
}

Lamps lamps_of(const mjModel& model) {
  const physics::Data data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  mj_camlight(&model, data.get());
  return Lamps(model, *data);
}

// OpenCV's weights, as in its conversion of pictures.
Eigen::Vector3f in_channels(const Eigen::Vector3f& rgb, Channels channels) {
  return channels == Channels::rgb ? rgb
                                   : Eigen::Vector3f(rgb.dot(Eigen::Vector3f(0.299f, 0.587f, 0.114f)), 0, 0);
}

}  // namespace

Scene::Scene(const mjModel& model, std::vector<Pinhole> views, int samples, std::uint64_t texture_seed,
             Channels channels, Robot robot)
    : model_(model),
      views_(std::move(views)),
      channels_(channels),
      frame_(joint_size(views_).width, joint_size(views_).height, samples, channels),
      textures_(model, texture_seed, channels),
      lamps_(lamps_of(model)) {
  for (const bool moving : {false, true}) {
    if (moving) still_vertices_ = vertices_.size();
    for (int geom = 0; geom < model.ngeom; ++geom)
      if (is_drawn(model, geom, robot) && moves(model, geom) == moving)
        add_piece(geom, textures_.on(model, geom));
  }
  add_masks();
  rasterizer_ = std::make_unique<Rasterizer>(channels, vertices_.size());
  rasterizer_->set_vertices(0, vertices_);
}

Scene::~Scene() { gl_.make_current(); }  // for its buffers and textures to be freed there

void Scene::add_piece(int geom, unsigned texture) {
  const std::size_t first = vertices_.size();
  Piece piece{geom, texture, moves(model_, geom), paint_of(model_, geom), geom_mesh(model_, geom), first,
              {},   {}};
  piece.half = mesh_half_extents(piece.mesh);
  for (std::uint32_t& index : piece.mesh.indices) index += std::uint32_t(first);
  vertices_.resize(first + piece.mesh.vertices.size());
  pieces_.push_back(std::move(piece));
}

// Nothing is nearer than these rectangles in clip coordinates: what they cover costs no drawing.
void Scene::add_masks() {
  for (const Pinhole& view : views_) {
    std::vector<std::uint32_t> mask;
    for (const cv::Rect& area : view.unsampled) {
      const auto first = std::uint32_t(vertices_.size());
      for (const auto& [x, y] :
           {std::pair(area.x, area.y), std::pair(area.x, area.y + area.height),
            std::pair(area.x + area.width, area.y + area.height), std::pair(area.x + area.width, area.y)})
        vertices_.push_back(
            {{2.0f * float(x) / float(view.width_px) - 1, 2.0f * float(y) / float(view.height_px) - 1, -1},
             {0, 0},
             {0, 0, 0}});
      for (const std::uint32_t i : {0, 1, 2, 0, 2, 3}) mask.push_back(first + i);
    }
    masks_.push_back(std::move(mask));
  }
}

void Scene::place(const Piece& piece, float light) {
  Paint paint = piece.paint;
  const bool ceiling = model_.geom_type[piece.geom] == mjGEOM_PLANE && piece.X_WG.linear()(2, 2) < -0.9f;
  if (ceiling) paint.emission *= light;
  Vertex* vertex = vertices_.data() + piece.first_vertex;
  for (const GeomMesh::Vertex& corner : piece.mesh.vertices)
    *vertex++ = {piece.X_WG * corner.p, corner.uv,
                 in_channels(lamps_.lit(paint, piece.X_WG.linear() * corner.normal, light), channels_)};
}

void Scene::place_still(const mjData& data, float light) {
  if (light == placed_light_) return;
  placed_light_ = light;
  for (Piece& piece : pieces_) {
    if (piece.moves) continue;
    piece.X_WG = pose_of(data, piece.geom);
    place(piece, light);
  }
  rasterizer_->set_vertices(0, std::span(vertices_).first(still_vertices_));
}

void Scene::place_moving(float light, const std::vector<std::vector<Seen>>& seen) {
  bool any = false;
  for (const std::vector<Seen>& view : seen)
    for (const auto& [piece, depth] : view)
      if (piece->moves) place(*piece, light), any = true;
  if (any) rasterizer_->set_vertices(still_vertices_, std::span(vertices_).subspan(still_vertices_));
}

// From near to far, so that hidden surfaces cost no texturing.
std::vector<Scene::Seen> Scene::seen_by(const Pinhole& view, const Eigen::Isometry3f& X_VW) const {
  const auto sides = view_sides(view);
  std::vector<Seen> seen;
  for (const Piece& piece : pieces_) {
    const Eigen::Isometry3f X_VG = X_VW * piece.X_WG;
    if (model_.geom_type[piece.geom] == mjGEOM_PLANE && X_VG.translation().dot(X_VG.linear().col(2)) > 0)
      continue;  // seen from behind
    const auto reach = [&](const Eigen::Vector3f& along_V) {
      return along_V.dot(X_VG.translation()) +
             (X_VG.linear().transpose() * along_V).cwiseAbs().dot(piece.half);
    };
    if (std::all_of(sides.begin(), sides.end(), [&](const auto& side) { return reach(side) > 0; }))
      seen.push_back({&piece, reach(Eigen::Vector3f::UnitZ())});
  }
  std::stable_sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.depth < b.depth; });
  return seen;
}

// Plain surfaces in one call; most near surfaces are plain, and hidden ones cost little.
void Scene::draw_view(std::size_t view, const Eigen::Isometry3f& X_VW, const std::vector<Seen>& seen) {
  const Pinhole& pinhole = views_[view];
  const cv::Rect viewport(pinhole.first_column, 0, pinhole.width_px, pinhole.height_px);
  rasterizer_->set_view(viewport, Eigen::Matrix4f::Identity());
  rasterizer_->draw(masks_[view], 0);
  rasterizer_->set_view(viewport, clip_from_view(pinhole) * X_VW.matrix());
  std::vector<std::uint32_t> plain;
  for (const auto& [piece, depth] : seen)
    if (!piece->texture) plain.insert(plain.end(), piece->mesh.indices.begin(), piece->mesh.indices.end());
  rasterizer_->draw(plain, 0);
  for (const auto& [piece, depth] : seen)
    if (piece->texture) rasterizer_->draw(piece->mesh.indices, piece->texture);
}

cv::Mat Scene::draw(const mjData& data, const Eigen::Isometry3d& X_WC, float light) {
  gl_.make_current();
  place_still(data, light);
  for (Piece& piece : pieces_)
    if (piece.moves) piece.X_WG = pose_of(data, piece.geom);
  std::vector<Eigen::Isometry3f> X_VW;
  std::vector<std::vector<Seen>> seen;
  for (const Pinhole& view : views_) {
    const Eigen::AngleAxisd turn(view.yaw, Eigen::Vector3d::UnitY());
    X_VW.push_back((X_WC * turn).inverse().cast<float>());
    seen.push_back(seen_by(view, X_VW.back()));
  }
  place_moving(light, seen);
  frame_.clear();
  for (std::size_t view = 0; view < views_.size(); ++view) draw_view(view, X_VW[view], seen[view]);
  return frame_.read();
}

}  // namespace sim::camera
