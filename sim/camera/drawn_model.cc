#include "sim/camera/drawn_model.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <bit>
#include <map>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "sim/camera/shapes.h"
#include "sim/camera/textures.h"
#include "sim/physics/nominal_body.h"

namespace sim::camera {
namespace {

int painted_texture(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  const int texture = material < 0 ? -1 : model.mat_texid[material];
  return texture >= 0 && model.tex_type[texture] == mjTEXTURE_2D ? texture : -1;
}

Eigen::Isometry3f pose_in_body(const mjModel& model, int geom) {
  const mjtNum *p = model.geom_pos + 3 * geom, *q = model.geom_quat + 4 * geom;
  Eigen::Isometry3f X = Eigen::Isometry3f::Identity();
  X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).cast<float>().toRotationMatrix();
  X.translation() = Eigen::Vector3d(p[0], p[1], p[2]).cast<float>();
  return X;
}

Eigen::Isometry3f pose_in_world(const mjData& data, int geom) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Isometry3f X = Eigen::Isometry3f::Identity();
  X.linear() = Eigen::Map<const RowMajor>(data.geom_xmat + 9 * geom).cast<float>();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom).cast<float>();
  return X;
}

void append(std::vector<float>& to, const auto& vector) {
  to.insert(to.end(), vector.data(), vector.data() + vector.size());
}

void add_geom(DrawnPiece& piece, const mjModel& model, int geom, const Eigen::Isometry3f& X) {
  const GeomMesh mesh = geom_mesh(model, geom);
  const Paint paint = paint_of(model, geom);
  const auto first = static_cast<std::uint32_t>(piece.positions.size() / 3);
  for (const GeomMesh::Vertex& vertex : mesh.vertices) {
    append(piece.positions, Eigen::Vector3f(X * vertex.p));
    append(piece.normals, Eigen::Vector3f(X.linear() * vertex.normal));
    append(piece.colours, paint.rgb);
    if (piece.picture >= 0) append(piece.uv, vertex.uv);
  }
  for (const std::uint32_t index : mesh.indices) piece.indices.push_back(first + index);
}

int index_of(std::vector<int>& list, int value) {
  const auto found = std::find(list.begin(), list.end(), value);
  if (found != list.end()) return static_cast<int>(found - list.begin());
  list.push_back(value);
  return static_cast<int>(list.size()) - 1;
}

std::vector<std::string> names_of(const mjModel& model, const std::vector<int>& bodies) {
  std::vector<std::string> names;
  for (const int body : bodies) {
    const char* const name = mj_id2name(&model, mjOBJ_BODY, body);
    names.emplace_back(name ? name : "");
  }
  return names;
}

// The largest that is not above x, which is positive.
int power_of_two(int x) { return static_cast<int>(std::bit_floor(static_cast<unsigned>(x))); }

}  // namespace

DrawnModel drawn_model(const mjModel& model) {
  const physics::Data data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  DrawnModel drawn;
  std::vector<int> bodies;
  std::map<std::pair<int, int>, DrawnPiece> pieces;  // by body and picture
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (!is_drawn(model, geom)) continue;
    const int body = model.geom_bodyid[geom], texture = painted_texture(model, geom);
    const bool moves = model.body_weldid[body] != 0;
    const std::pair key(moves ? index_of(bodies, body) : -1,
                        texture < 0 ? -1 : index_of(drawn.pictures, texture));
    DrawnPiece& piece = pieces[key];
    std::tie(piece.body, piece.picture) = key;
    add_geom(piece, model, geom, moves ? pose_in_body(model, geom) : pose_in_world(*data, geom));
  }
  for (auto& [key, piece] : pieces) drawn.pieces.push_back(std::move(piece));
  drawn.bodies = names_of(model, bodies);
  return drawn;
}

std::vector<cv::Mat3b> drawn_pictures(const mjModel& model, const DrawnModel& drawn, std::uint64_t seed,
                                      int largest_px) {
  const physics::Data data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  std::vector<cv::Mat3b> pictures;
  for (const int texture : drawn.pictures) {
    const cv::Mat3b whole = texture_picture(model, *data, texture, seed);
    const cv::Size size(power_of_two(std::min(whole.cols, largest_px)),
                        power_of_two(std::min(whole.rows, largest_px)));
    cv::resize(whole, pictures.emplace_back(), size, 0, 0, cv::INTER_AREA);
  }
  return pictures;
}

BodyPoses::BodyPoses(const mjModel& model, const std::vector<std::string>& bodies) {
  for (const std::string& body : bodies) {
    ids_.push_back(mj_name2id(&model, mjOBJ_BODY, body.c_str()));
    if (ids_.back() < 0) throw std::invalid_argument("the model has no body " + body);
  }
}

std::vector<float> BodyPoses::of(const mjData& data) const {
  std::vector<float> poses;
  for (const int id : ids_) {
    const mjtNum *p = data.xpos + 3 * id, *q = data.xquat + 4 * id;
    for (const mjtNum value : {p[0], p[1], p[2], q[1], q[2], q[3], q[0]})
      poses.push_back(static_cast<float>(value));
  }
  return poses;
}

PosedRobot::PosedRobot(const std::string& robot, const std::string& room, const std::filesystem::path& models)
    : model_(physics::load_model(robot, room, models)),
      data_(mj_makeData(model_.get())),
      drawn_(drawn_model(*model_)),
      bodies_(*model_, drawn_.bodies) {}

std::vector<float> PosedRobot::poses(const walking::BodyPose& pose) {
  const Eigen::VectorXd q = physics::robot_positions(*model_, pose);
  std::copy(q.begin(), q.end(), data_->qpos);
  mj_kinematics(model_.get(), data_.get());
  return bodies_.of(*data_);
}

}  // namespace sim::camera
