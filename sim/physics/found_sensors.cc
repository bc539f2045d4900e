#include "sim/physics/found_sensors.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "sim/files/yaml.h"

namespace sim::physics {
namespace {

constexpr double kToTheRight = 0.7, kAhead = 0.99;  // cosines
constexpr double kSame = 1e-3;                      // relative difference of positions
constexpr std::array kCameras{"d435", "realsense", "zed", "oak", "camera"};
constexpr std::array kLidars{"mid360", "livox", "lidar"};
constexpr std::array kImus{"imu"};

/// Returns the index of the first of these words in a name, or their number.
std::size_t first_word(std::string name, const auto& words) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return std::size_t(
      std::ranges::find_if(words, [&](const char* word) { return name.find(word) != std::string::npos; }) -
      words.begin());
}

class Finder {
 public:
  Finder(const CompiledRobot& robot, const std::vector<std::string>& links)
      : robot_(robot), m_(*robot.model), data_(mj_makeData(&m_)), links_(links) {
    mj_kinematics(&m_, data_.get());
    mj_camlight(&m_, data_.get());
    for (int body = robot.base; body < m_.nbody; ++body)
      add(name_of(m_, mjOBJ_BODY, body), body, data_->xpos + 3 * body, data_->xmat + 9 * body);
    for (int camera = 0; camera < m_.ncam; ++camera)
      if (m_.cam_mode[camera] == mjCAMLIGHT_FIXED)
        add(name_of(m_, mjOBJ_CAMERA, camera), m_.cam_bodyid[camera], data_->cam_xpos + 3 * camera,
            data_->cam_xmat + 9 * camera, true);
    for (int site = 0; site < m_.nsite; ++site)
      add(name_of(m_, mjOBJ_SITE, site), m_.site_bodyid[site], data_->site_xpos + 3 * site,
          data_->site_xmat + 9 * site);
  }

  std::vector<rig::Mount> all(const auto& words, bool looks) const {
    std::vector<std::tuple<std::size_t, std::ptrdiff_t, rig::Mount>> ranked;
    for (const Frame& frame : frames_) {
      const std::size_t word = first_word(frame.name, words);
      const auto link = std::ranges::find(links_, frame.link);
      const bool other = !looks && first_word(frame.name, kCameras) < kCameras.size();
      if (word == words.size() || link == links_.end() || other || (frame.is_camera && !looks)) continue;
      const Eigen::Isometry3d X_LS = looks ? frame.X_LS * looking(frame) : frame.X_LS;
      if (looks && !((frame.R_BL * X_LS.linear())(0, 0) > 0)) continue;
      ranked.emplace_back(word, link - links_.begin(), mount_on(frame.link, X_LS));
    }
    std::ranges::stable_sort(
        ranked, {}, [](const auto& each) { return std::pair(std::get<0>(each), std::get<1>(each)); });
    std::vector<rig::Mount> mounts;
    for (const auto& each : ranked) {  // a link and a site on it can be the same sensor
      const rig::Mount& next = std::get<2>(each);
      if (std::ranges::none_of(mounts, [&](const rig::Mount& other) {
            return other.link == next.link && other.position_m.isApprox(next.position_m, kSame);
          }))
        mounts.push_back(next);
    }
    return mounts;
  }

 private:
  struct Frame {
    std::string name, link;
    bool is_camera = false;                                  // of MuJoCo: x right, y up
    Eigen::Isometry3d X_LS = Eigen::Isometry3d::Identity();  // the sensor on the link
    Eigen::Matrix3d R_BL = Eigen::Matrix3d::Identity();
  };

  void add(const std::string& name, int body, const mjtNum* p, const mjtNum* R, bool is_camera = false) {
    const int* const weld = m_.body_weldid;
    const int link = weld[body] == weld[robot_.base] ? robot_.base : weld[body];
    const auto pose = [&](int of) { return pose_in(data_->xpos + 3 * of, data_->xmat + 9 * of); };
    frames_.push_back({name, name_of(m_, mjOBJ_BODY, link), is_camera, pose(link).inverse() * pose_in(p, R),
                       pose(robot_.base).linear().transpose() * pose(link).linear()});
  }

  // The axes forward, left, up in the frame's axes.
  static Eigen::Isometry3d looking(const Frame& frame) {
    const Eigen::Isometry3d X_CL = rig::camera_from_forward_left_up();
    if (frame.is_camera) return Eigen::Isometry3d(Eigen::DiagonalMatrix<double, 3>(1, -1, -1)) * X_CL;
    const Eigen::Matrix3d R = frame.R_BL * frame.X_LS.linear();
    if (R(1, 0) < -kToTheRight) return X_CL;
    return Eigen::Isometry3d(R(0, 2) > kAhead ? Eigen::Matrix3d(R.transpose()) : Eigen::Matrix3d::Identity());
  }

  const CompiledRobot& robot_;
  const mjModel& m_;
  Data data_;
  const std::vector<std::string>& links_;
  std::vector<Frame> frames_;
};

}  // namespace

FoundSensors find_sensors(const CompiledRobot& robot, const std::vector<std::string>& links) {
  const Finder finder(robot, links);
  return {finder.all(kCameras, true), finder.all(kImus, false), finder.all(kLidars, false)};
}

rig::Mount mount_on(const std::string& link, const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();  // Rz(yaw) Ry(tilt) Rx(roll)
  const double tilt = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  if (std::abs(R(2, 0)) > 1 - 1e-9)  // only the difference or sum of yaw and roll is known
    return {link, X.translation(), std::atan2(-R(0, 1), R(1, 1)), tilt, 0};
  return {link, X.translation(), std::atan2(R(1, 0), R(0, 0)), tilt, std::atan2(R(2, 1), R(2, 2))};
}

std::string text_of(const rig::Mount& mount) {
  const Eigen::Vector3d& p = mount.position_m;
  std::string text = fmt::format("link: {}, position_m: [{:.6g}, {:.6g}, {:.6g}]",
                                 files::quote_if_needed(mount.link), p.x() + 0.0, p.y() + 0.0, p.z() + 0.0);
  for (const auto& [key, angle] :
       {std::pair("yaw", mount.yaw_rad), {"tilt", mount.tilt_rad}, {"roll", mount.roll_rad}})
    if (std::abs(angle) > 1e-4) text += fmt::format(", {}_deg: {:.6g}", key, angle * 180 / std::numbers::pi);
  return text;
}

}  // namespace sim::physics
