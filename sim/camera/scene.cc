#include "sim/camera/scene.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace sim::camera {
namespace {

constexpr float kNear = 0.05f, kFar = 40.0f;

// Inward normals of the planes through the camera's center and the view's sides.
std::array<Eigen::Vector3f, 4> view_sides(const Pinhole& view) {
  const float l = float(view.left), t = float(view.top);
  const float r = l + float(view.width_px / view.focal_px), b = t + float(view.height_px / view.focal_px);
  return {Eigen::Vector3f(1, 0, -l).normalized(), Eigen::Vector3f(-1, 0, r).normalized(),
          Eigen::Vector3f(0, 1, -t).normalized(), Eigen::Vector3f(0, -1, b).normalized()};
}

// Maps a point of the view to OpenGL's clip coordinates: the picture's left and top to -1, z from near to
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

cv::Size joint_size(const std::vector<Pinhole>& views) {
  cv::Size size(0, 0);
  for (const Pinhole& view : views) {
    size.width = std::max(size.width, view.first_column + view.width_px);
    size.height = std::max(size.height, view.height_px);
  }
  return size;
}

}  // namespace

Scene::Scene(const mjModel& model, std::vector<Pinhole> views, std::uint64_t texture_seed, Channels channels,
             Robot robot, const Scene* shares)
    : model_(model),
      views_(std::move(views)),
      channels_(channels),
      renderer_(joint_size(views_), channels, shares ? &shares->renderer_ : nullptr),
      lamps_(model) {
  const auto lock = renderer_.use();
  textures_ = shares ? shares->textures_ : load_textures(model, texture_seed, channels);
  for (const bool moving : {false, true}) {
    if (moving) still_vertices_.count = vertices_.size();
    for (int geom = 0; geom < model.ngeom; ++geom)
      if (const int texture = texture_of(model, geom);
          is_drawn(model, geom, robot) && moves(model, geom) == moving)
        add_piece(geom, texture < 0 ? 0 : textures_[std::size_t(texture)]);
  }
  add_masks();
  renderer_.reserve(vertices_.size());
  renderer_.set_vertices(0, vertices_);
}

void Scene::add_piece(int geom, unsigned texture) {
  Piece piece{.geom = geom,
              .texture = texture,
              .moves = moves(model_, geom),
              .paint = paint_of(model_, geom),
              .mesh = geom_mesh(model_, geom),
              .first_vertex = vertices_.size()};
  for (const GeomMesh::Vertex& vertex : piece.mesh.vertices)
    piece.half = piece.half.cwiseMax(vertex.p.cwiseAbs());
  for (std::uint32_t& index : piece.mesh.indices) index += std::uint32_t(piece.first_vertex);
  vertices_.resize(piece.first_vertex + piece.mesh.vertices.size());
  pieces_.push_back(std::move(piece));
}

// Puts rectangles on the near plane, in clip coordinates: surfaces hidden by them need not be drawn.
void Scene::add_masks() {
  for (const Pinhole& view : views_) {
    std::vector<std::uint32_t> mask;
    for (const cv::Rect& area : view.unsampled) {
      const auto first = std::uint32_t(vertices_.size());
      const cv::Point low = area.tl(), high = area.br();
      for (const cv::Point& corner : {low, cv::Point(low.x, high.y), high, cv::Point(high.x, low.y)}) {
        const float x = 2.0f * float(corner.x) / float(view.width_px) - 1,
                    y = 2.0f * float(corner.y) / float(view.height_px) - 1;
        vertices_.push_back({{x, y, -1}, {0, 0}, {0, 0, 0}});
      }
      for (const std::uint32_t i : {0, 1, 2, 0, 2, 3}) mask.push_back(first + i);
    }
    masks_.push_back(std::move(mask));
  }
}

// Brightness uses OpenCV's weights, as its conversion of pictures does.
void Scene::light_piece(const Piece& piece, float light) {
  Paint paint = piece.paint;
  const bool ceiling = model_.geom_type[piece.geom] == mjGEOM_PLANE && piece.X_WG.linear()(2, 2) < -0.9f;
  if (ceiling) paint.emission *= light;
  Vertex* vertex = vertices_.data() + piece.first_vertex;
  for (const GeomMesh::Vertex& corner : piece.mesh.vertices) {
    Eigen::Vector3f lit = lamps_.lit(paint, piece.X_WG.linear() * corner.normal, light);
    if (channels_ == Channels::gray) lit = {lit.dot(Eigen::Vector3f(0.299f, 0.587f, 0.114f)), 0, 0};
    *vertex++ = {piece.X_WG * corner.p, corner.uv, lit};
  }
}

// Sorted from near to far, so that hidden surfaces cost no texturing.
std::vector<Scene::Seen> Scene::seen_by(const Pinhole& view, const Eigen::Isometry3f& X_VW) const {
  const auto sides = view_sides(view);
  std::vector<Seen> seen;
  for (const Piece& piece : pieces_) {
    const Eigen::Isometry3f X_VG = X_VW * piece.X_WG;
    if (model_.geom_type[piece.geom] == mjGEOM_PLANE && X_VG.translation().dot(X_VG.linear().col(2)) > 0)
      continue;  // seen from behind
    const auto reach = [&](const Eigen::Vector3f& axis_V) {
      return axis_V.dot(X_VG.translation()) + (X_VG.linear().transpose() * axis_V).cwiseAbs().dot(piece.half);
    };
    if (std::ranges::all_of(sides, [&](const auto& side) { return reach(side) > 0; }))
      seen.push_back({&piece, reach(Eigen::Vector3f::UnitZ())});
  }
  std::ranges::stable_sort(seen, [](const Seen& a, const Seen& b) { return a.depth < b.depth; });
  return seen;
}

// Draws plain surfaces in one call: most near surfaces are plain, and hidden ones cost little. As in MuJoCo,
// glass comes last, from far to near by the nearest points of boxes around it.
void Scene::draw_view(std::size_t view, const Eigen::Isometry3f& X_VW, const std::vector<Seen>& seen) {
  const Pinhole& pinhole = views_[view];
  const cv::Rect viewport(pinhole.first_column, 0, pinhole.width_px, pinhole.height_px);
  renderer_.set_view(viewport, Eigen::Matrix4f::Identity());
  renderer_.draw(masks_[view], 0);
  renderer_.set_view(viewport, clip_from_view(pinhole) * X_VW.matrix());
  std::vector<std::uint32_t> plain;
  std::vector<const Piece*> glass;
  for (const auto& [piece, depth] : seen)
    if (piece->paint.alpha < 1)
      glass.push_back(piece);
    else if (!piece->texture)
      plain.insert(plain.end(), piece->mesh.indices.begin(), piece->mesh.indices.end());
  renderer_.draw(plain, 0);
  for (const auto& [piece, depth] : seen)
    if (piece->texture && piece->paint.alpha >= 1) renderer_.draw(piece->mesh.indices, piece->texture);
  std::ranges::stable_sort(glass, std::ranges::greater{}, [&](const Piece* piece) {
    const Eigen::Vector3f p_GV = (X_VW * piece->X_WG).inverse().translation();
    return (p_GV.cwiseAbs() - piece->half).cwiseMax(0).norm();
  });
  for (const Piece* piece : glass) renderer_.draw(piece->mesh.indices, piece->texture, piece->paint.alpha);
}

cv::Mat Scene::draw(const mjData& data, const Eigen::Isometry3d& X_WC, float light) {
  const auto lock = renderer_.use();
  for (Piece& piece : pieces_)
    if (piece.moves || still_vertices_.lit_by < 0) piece.X_WG = geom_pose(data, piece.geom).cast<float>();
  if (light != still_vertices_.lit_by) {
    for (const Piece& piece : pieces_)
      if (!piece.moves) light_piece(piece, light);
    renderer_.set_vertices(0, std::span(vertices_).first(still_vertices_.count));
    still_vertices_.lit_by = light;
  }
  X_VW_.clear(), seen_.clear();
  bool any_moves = false;
  for (const Pinhole& view : views_) {
    const Eigen::AngleAxisd turn(view.yaw, Eigen::Vector3d::UnitY());
    X_VW_.push_back((X_WC * turn).inverse().cast<float>());
    for (const auto& [piece, depth] : seen_.emplace_back(seen_by(view, X_VW_.back())))
      if (piece->moves) light_piece(*piece, light), any_moves = true;
  }
  if (any_moves)
    renderer_.set_vertices(still_vertices_.count, std::span(vertices_).subspan(still_vertices_.count));
  renderer_.clear();
  for (std::size_t view = 0; view < views_.size(); ++view) draw_view(view, X_VW_[view], seen_[view]);
  return renderer_.read();
}

DepthPicture Scene::read_depth() {
  const auto lock = renderer_.use();
  DepthPicture depth{renderer_.read_depth(), {}};
  renderer_.begin_marks();
  for (std::size_t view = 0; view < views_.size(); ++view) {
    const Pinhole& pinhole = views_[view];
    renderer_.set_view({pinhole.first_column, 0, pinhole.width_px, pinhole.height_px},
                       clip_from_view(pinhole) * X_VW_[view].matrix());
    for (const auto& [piece, unused] : seen_[view])
      if (piece->paint.alpha >= 1 && !returns_light(model_, piece->geom))
        renderer_.draw(piece->mesh.indices, 0);
  }
  depth.marks = renderer_.read();
  renderer_.end_marks();
  return depth;
}

cv::Mat1f DepthPicture::inverse_depth() const {
  cv::Mat marked = marks;
  if (marks.channels() > 1) cv::extractChannel(marks, marked, 0);
  cv::Mat1f inverse(buffer.size());
  for (int row = 0; row < buffer.rows; ++row)
    for (int column = 0; column < buffer.cols; ++column) {
      const float d = buffer(row, column);
      const bool none = d >= 1 || marked.at<unsigned char>(row, column) > 0;
      inverse(row, column) = none ? 0 : float(1.0 / kNear - double(d) * (1.0 / kNear - 1.0 / kFar));
    }
  return inverse;
}

}  // namespace sim::camera
