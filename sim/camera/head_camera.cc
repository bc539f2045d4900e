#include "sim/camera/head_camera.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sim::camera {
namespace {

constexpr char kName[] = "head_camera";

}  // namespace

Eigen::Isometry3d camera_pose(const mjModel& model, const mjData& data, const std::string& name) {
  const int id = mj_name2id(&model, mjOBJ_CAMERA, name.c_str());
  if (id < 0) throw std::invalid_argument("the model has no camera \"" + name + "\"");
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.translation() = Eigen::Map<const Eigen::Vector3d>(data.cam_xpos + 3 * id);
  const Eigen::Matrix3d R_WM = Eigen::Map<const RowMajor>(data.cam_xmat + 9 * id);
  X_WC.linear() = R_WM * Eigen::Vector3d(1, -1, -1).asDiagonal();  // MuJoCo's M: y up, looking along -z
  return X_WC;
}

HeadCamera::HeadCamera(physics::Model robot_in_room, const CameraOptions& options, std::uint64_t texture_seed)
    : model_(std::move(robot_in_room)),
      data_(mj_makeData(model_.get())),
      camera_(camera_model(options)),
      lens_(camera_, source_density(options)),
      scene_(*model_, lens_.views(), options.samples, texture_seed, Channels::grey),
      shutter_(options) {
  mj_kinematics(model_.get(), data_.get());
  camera_pose(*model_, *data_, kName);
}

cv::Mat HeadCamera::picture(const double* q, float light) {
  std::copy_n(q, model_->nq, data_->qpos);
  mj_kinematics(model_.get(), data_.get());
  mj_camlight(model_.get(), data_.get());
  const Eigen::Isometry3d X_WC = camera_pose(*model_, *data_, kName);
  return lens_.warp(scene_.draw(*data_, X_WC, light));
}

cv::Mat HeadCamera::render(const mjData& plant) { return picture(plant.qpos, 1); }

cv::Mat HeadCamera::render(const RecentMotion& motion, std::chrono::nanoseconds t,
                           const physics::WorldOptions::LightsOff& off) {
  std::vector<cv::Mat> pictures;
  for (const double moment : shutter_.moments()) {
    const double at = 1e-9 * double(t.count()) + moment;
    const bool dark = at >= off.from_s && at < off.from_s + off.duration_s;
    pictures.push_back(picture(motion.at(at, *model_).data(), dark ? float(off.left_fraction) : 1));
  }
  return shutter_.expose(pictures);
}

}  // namespace sim::camera
