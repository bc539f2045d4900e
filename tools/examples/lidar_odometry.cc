// Lidar odometry: point-to-plane ICP against planes of a voxel map, with Eigen. Each sweep is de-skewed with
// the chest's gyro and a constant velocity, which also take the pose to the stamp of an observation.
//
// clang-format off
//     c++ -std=c++17 -O2 -DGAITSLAM_ESTIMATOR_MAIN -I sim/estimators -I /usr/include/eigen3 -o lidar_odometry tools/examples/lidar_odometry.cc
//     tools/gaitslam run scenarios/office_d435i_mid360.yaml 'estimator={program: ./lidar_odometry}'
// clang-format on
//
// It has neither loop closure nor covariance; its map is not answered.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <vector>

#include "example.h"

namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kVoxel_m = 0.4;
constexpr int kFewestPoints = 20, kMostPoints = 500;  // of a plane
constexpr double kThickness_m = 0.06;                 // standard deviation across a plane, at most
constexpr double kFar_m = 0.3;                        // from a plane: not on it
constexpr double kResidual_m = 0.03;                  // scale of the robust weight
constexpr std::size_t kUsed = 4000;                   // points of a sweep for its alignment
constexpr std::size_t kFewestOnPlanes = 200;
constexpr int64_t kRemembered_ns = 1000000000;

Isometry3d pose_of(const gaitslam_pose& X) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(X.rotation);
  pose.translation() = Eigen::Map<const Vector3d>(X.translation_m);
  return pose;
}

Matrix3d exponential(const Vector3d& turn) {
  const double angle = turn.norm();
  return angle > 1e-12 ? Eigen::AngleAxisd(angle, turn / angle).matrix() : Matrix3d::Identity();
}

/// A voxel: its points' mean and scatter, and the plane through them.
struct Voxel {
  int count = 0;
  Vector3d mean = Vector3d::Zero(), normal = Vector3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();
  bool is_plane = false;

  void add(const Vector3d& p) {
    if (count >= kMostPoints) return;
    const Vector3d off = p - mean;
    mean += off / ++count;
    scatter += off * (p - mean).transpose();
  }
  void fit() {
    if (count < kFewestPoints) return;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter / count);
    const Vector3d variance = eigen.eigenvalues();
    is_plane = variance[0] < kThickness_m * kThickness_m && variance[0] < 0.1 * variance[1];
    normal = eigen.eigenvectors().col(0);
  }
};

class Map {
 public:
  bool empty() const { return voxels_.empty(); }
  const Voxel* plane_at(const Vector3d& p) const {
    const auto found = voxels_.find(key(p));
    return found != voxels_.end() && found->second.is_plane ? &found->second : nullptr;
  }
  void add(const std::vector<Vector3d>& points, const Isometry3d& X_WL) {
    std::vector<Voxel*> changed;
    for (const Vector3d& p : points) {
      changed.push_back(&voxels_[key(X_WL * p)]);
      changed.back()->add(X_WL * p);
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    for (Voxel* const voxel : changed) voxel->fit();
  }

 private:
  /// 21 bits for each axis.
  static uint64_t key(const Vector3d& p) {
    uint64_t bits = 0;
    for (int axis = 0; axis < 3; ++axis)
      bits = bits << 21 | (static_cast<uint64_t>(std::floor(p[axis] / kVoxel_m) + (1 << 20)) & 0x1fffff);
    return bits;
  }
  std::unordered_map<uint64_t, Voxel> voxels_;
};

/// Returns the pose that fits the points best to the map's planes; nothing if too few are on planes.
std::optional<Isometry3d> aligned(const Map& map, const std::vector<Vector3d>& points, Isometry3d X_WL) {
  for (int iteration = 0; iteration < 20; ++iteration) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    std::size_t on_planes = 0;
    for (const Vector3d& p : points) {
      const Vector3d arm = X_WL.linear() * p, p_W = arm + X_WL.translation();
      const Voxel* const plane = map.plane_at(p_W);
      if (!plane) continue;
      const double off = plane->normal.dot(p_W - plane->mean);
      if (std::abs(off) > kFar_m) continue;
      ++on_planes;
      Vector6d J;
      J << arm.cross(plane->normal), plane->normal;
      const double weight = 1 / (1 + off * off / (kResidual_m * kResidual_m));
      H += weight * J * J.transpose();
      b -= weight * off * J;
    }
    if (on_planes < kFewestOnPlanes) return std::nullopt;
    const Vector6d step = H.ldlt().solve(b);
    X_WL.linear() = exponential(step.head<3>()) * X_WL.linear();
    X_WL.translation() += step.tail<3>();
    if (step.norm() < 1e-5) break;
  }
  return X_WL;
}

class LidarOdometry : public Example {
 public:
  LidarOdometry(const gaitslam_start& start, const gaitslam_sensors& sensors)
      : X_CL_(pose_of(sensors.lidars[0].X_CK)),
        R_LG_(X_CL_.linear().transpose() * pose_of(start.X_CG).linear()),
        X_WL_(pose_of(start.X_WC) * X_CL_),
        middle_W_(X_WL_.translation()) {
    const double seconds = sensors.lidars[0].time_offset_s - sensors.imus[0].time_offset_s;
    lidar_ahead_ns_ = std::llround(1e9 * seconds);
    imu_ahead_ns_ = std::llround(1e9 * sensors.imus[0].time_offset_s);
  }

  void process(const gaitslam_observation& observation, const gaitslam_reading* gyro, const uint8_t*,
               const gaitslam_rig& rig) override {
    for (uint32_t i = 0; i < observation.gyro_count; ++i)
      if (gyro_.empty() || gyro[i].end_ns > gyro_.back().end_ns) gyro_.push_back(gyro[i]);
    while (!gyro_.empty() && gyro_.front().end_ns < gyro_.back().end_ns - kRemembered_ns) gyro_.pop_front();
    for (uint32_t i = 0; i < rig.counts.sweeps; ++i)
      if (rig.sweeps[i].lidar == 0 && rig.sweeps[i].point_count > 0) add(rig.sweeps[i], rig.data);
    t_ns_ = std::max(t_ns_, observation.t_ns);
  }

  void write(gaitslam_answer& answer, const gaitslam_landmark**, const char** cause) override {
    answer.t_ns = t_ns_;
    answer.status = map_.empty() ? GAITSLAM_NOT_READY : lost_ ? GAITSLAM_LOST : GAITSLAM_OK;
    if (lost_) *cause = "too few points are on known planes";
    const Isometry3d X_WC = at(t_ns_ + imu_ahead_ns_) * X_CL_.inverse();
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(answer.X_WC.rotation) = X_WC.linear();
    Eigen::Map<Vector3d>(answer.X_WC.translation_m) = X_WC.translation();
  }

 private:
  /// The pose at a time by the IMU's clock, from the last sweep's by gyro and constant velocity.
  Isometry3d at(int64_t t_ns) const {
    Isometry3d X_WL = X_WL_;
    X_WL.linear() *= turns({t_ns})[0];
    X_WL.translation() = middle_W_ + v_W_ * 1e-9 * static_cast<double>(t_ns - middle_ns_);
    return X_WL;
  }

  /// The rotations since the start of the last sweep, for times in ascending order.
  std::vector<Matrix3d> turns(const std::vector<int64_t>& times_ns) const {
    std::vector<Matrix3d> all;
    Matrix3d R = Matrix3d::Identity();
    int64_t t = sweep_ns_;
    auto reading = gyro_.begin();
    for (const int64_t time : times_ns) {
      while (t < time) {
        while (reading != gyro_.end() && reading->end_ns <= t) ++reading;
        if (reading == gyro_.end()) break;
        const int64_t end = std::min(time, reading->end_ns);
        R *= exponential(R_LG_ * Eigen::Map<const Vector3d>(reading->value) * 1e-9 *
                         static_cast<double>(end - t));
        t = end;
      }
      all.push_back(R);
    }
    return all;
  }

  void add(const gaitslam_sweep& sweep, const uint8_t* data) {
    std::vector<gaitslam_point> points(sweep.point_count);
    std::memcpy(points.data(), data + sweep.at_byte, points.size() * sizeof(gaitslam_point));
    std::sort(points.begin(), points.end(),
              [](const gaitslam_point& a, const gaitslam_point& b) { return a.offset_ns < b.offset_ns; });
    const int64_t t_ns = sweep.t_ns - lidar_ahead_ns_;
    const Isometry3d guess = map_.empty() ? X_WL_ : at(t_ns);
    sweep_ns_ = t_ns;
    std::vector<int64_t> times;
    for (const gaitslam_point& point : points) times.push_back(t_ns + point.offset_ns);
    const std::vector<Matrix3d> R = turns(times);
    const Vector3d v_L = guess.linear().transpose() * v_W_;
    std::vector<Vector3d> straight, used;  // in L at the start of the sweep
    for (std::size_t i = 0; i < points.size(); ++i)
      straight.push_back(R[i] * Eigen::Map<const Eigen::Vector3f>(points[i].p_m).cast<double>() +
                         v_L * (1e-9 * points[i].offset_ns));
    for (std::size_t i = 0; i < straight.size(); i += 1 + straight.size() / kUsed)
      used.push_back(straight[i]);
    const bool is_first = map_.empty();
    const auto fitted = is_first ? guess : aligned(map_, used, guess);
    lost_ = !fitted;
    X_WL_ = fitted.value_or(guess);
    // A wrong velocity moves the start of the sweep, but not its middle.
    const int64_t half_ns = points.back().offset_ns / 2, middle_ns = t_ns + half_ns;
    const Vector3d middle_W = X_WL_.translation() + v_W_ * (1e-9 * static_cast<double>(half_ns));
    if (fitted && !is_first)
      v_W_ = (middle_W - middle_W_) / (1e-9 * static_cast<double>(middle_ns - middle_ns_));
    middle_W_ = middle_W;
    middle_ns_ = middle_ns;
    map_.add(straight, X_WL_);
  }

  const Isometry3d X_CL_;
  const Matrix3d R_LG_;
  Map map_;
  std::deque<gaitslam_reading> gyro_;
  Isometry3d X_WL_;                             // at the start of the last sweep
  Vector3d middle_W_, v_W_ = Vector3d::Zero();  // position in the middle of the last sweep; velocity
  int64_t sweep_ns_ = 0, middle_ns_ = 0, t_ns_ = 0, lidar_ahead_ns_ = 0, imu_ahead_ns_ = 0;
  bool lost_ = false;
};

}  // namespace

Example* new_example(const gaitslam_start& start, const gaitslam_sensors& sensors,
                     const std::string& options) {
  if (sensors.counts.lidars == 0 || !options.empty())
    throw std::invalid_argument(options.empty() ? "the rig has no lidar" : "it has no options");
  return new LidarOdometry(start, sensors);
}
