#include "sim/camera/head_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sim::camera {
namespace {

// Integral from -infinity to x of the triangle of height 1 over [-1, 1].
double below_triangle(double x) {
  x = std::clamp(x, -1.0, 1.0);
  return x < 0 ? 0.5 * (1 + x) * (1 + x) : 1 - 0.5 * (1 - x) * (1 - x);
}

// Mean of that triangle over [from, to], in steps: the fraction of that interval's light that comes from one
// moment's picture.
double share(double from, double to) {
  if (to - from < 1e-9) return std::max(0.0, 1 - std::abs(from));
  return (below_triangle(to) - below_triangle(from)) / (to - from);
}

physics::Model mounted(physics::Model model, const rig::Mount& mount) {
  if (!mount.is_default()) physics::mount_camera(*model, mount);
  return model;
}

}  // namespace

Shutter::Shutter(const CameraOptions& options) {
  const double exposure = options.exposure_s, readout = options.readout_s, span = exposure + readout;
  const int count = span > 0 ? std::max(2, options.subframes) : 1;
  const double step = count > 1 ? span / (count - 1) : 1;
  for (int i = 0; i < count; ++i) moments_.push_back(count > 1 ? i * step - span / 2 : 0);
  shares_.create(count, options.height_px);
  for (int v = 0; v < options.height_px; ++v) {
    const double middle = readout * ((v + 0.5) / options.height_px - 0.5);
    for (int i = 0; i < count; ++i)
      shares_(i, v) = float(
          share((middle - exposure / 2 - moments_[i]) / step, (middle + exposure / 2 - moments_[i]) / step));
  }
}

cv::Mat Shutter::expose(const std::vector<cv::Mat>& pictures) const {
  if (pictures.size() == 1) return pictures.front();
  cv::Mat frame(pictures.front().size(), pictures.front().type());
  for (int v = 0; v < frame.rows; ++v) {
    cv::Mat1f light(1, frame.cols * frame.channels(), 0.0f), row;
    for (int i = 0; i < int(pictures.size()); ++i) {
      if (shares_(i, v) <= 0) continue;
      pictures[i].row(v).reshape(1).convertTo(row, CV_32F);
      cv::scaleAdd(row, shares_(i, v), light, light);
    }
    light.convertTo(frame.row(v).reshape(1), CV_8U);
  }
  return frame;
}

void RecentMotion::add(std::chrono::nanoseconds t, const mjModel& model, const mjData& data) {
  const double t_s = 1e-9 * double(t.count());
  poses_.push_back({t_s, Eigen::Map<const Eigen::VectorXd>(data.qpos, model.nq)});
  while (poses_.size() > 2 && poses_[1].t_s < t_s - 1e-9 * double(kept_.count())) poses_.pop_front();
}

Eigen::VectorXd RecentMotion::at(double t_s, const mjModel& model) const {
  const auto after = std::ranges::find_if(poses_, [&](const Pose& p) { return p.t_s >= t_s; });
  if (after == poses_.end()) return poses_.back().q;
  if (after == poses_.begin() || after->t_s == t_s) return after->q;
  const Pose& before = *std::prev(after);
  Eigen::VectorXd change(model.nv), q = before.q;
  mj_differentiatePos(&model, change.data(), 1, before.q.data(), after->q.data());
  mj_integratePos(&model, q.data(), change.data(), (t_s - before.t_s) / (after->t_s - before.t_s));
  return q;
}

HeadCamera::HeadCamera(physics::Model robot_in_room, const CameraOptions& options, std::uint64_t texture_seed,
                       Channels channels, const rig::Mount& mount, const HeadCamera* shares)
    : model_(mounted(std::move(robot_in_room), mount)),
      data_(data_at_rest(*model_)),
      lens_(camera_model(options)),
      scene_(*model_, lens_.views(), texture_seed, channels, Robot::without_head,
             shares ? &shares->scene_ : nullptr),
      shutter_(options),
      id_(physics::part(*model_, mjOBJ_CAMERA, "head_camera")) {}

cv::Mat HeadCamera::picture(const double* q, double t_s, float light) {
  std::copy_n(q, model_->nq, data_->qpos);
  data_->time = t_s;
  physics::pose_bodies(*model_, *data_);
  mj_camlight(model_.get(), data_.get());
  Eigen::Isometry3d X_WC = physics::pose_in(data_->cam_xpos + 3 * id_, data_->cam_xmat + 9 * id_);
  X_WC.linear() *= Eigen::Vector3d(1, -1, -1).asDiagonal();  // MuJoCo's M: y up, looking along -z
  return scene_.draw(*data_, X_WC, light);
}

Exposure HeadCamera::expose(const RecentMotion& motion, std::chrono::nanoseconds t,
                            const physics::WorldOptions& world, bool with_depth) {
  Exposure exposure;
  for (const double moment : shutter_.moments()) {
    const double at = 1e-9 * double(t.count()) + moment;
    exposure.pictures.push_back(picture(motion.at(at, *model_).data(), at, float(world.light_at(at))));
  }
  if (!with_depth) return exposure;
  const double stamp = 1e-9 * double(t.count());
  if (exposure.pictures.size() > 1) picture(motion.at(stamp, *model_).data(), stamp, 1);
  exposure.depth = scene_.read_depth();
  return exposure;
}

cv::Mat HeadCamera::image(const Exposure& exposure) const {
  std::vector<cv::Mat> warped;
  for (const cv::Mat& picture : exposure.pictures) warped.push_back(lens_.warp(picture));
  return shutter_.expose(warped);
}

}  // namespace sim::camera
