// Tests the filter on head motions that no robot of the bench makes, rendered without physics.
#include "sim/camera/head_camera.h"
#include "sim/score/trajectory.h"
#include "slam/filter.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
namespace {

using Eigen::AngleAxisd, Eigen::Isometry3d, Eigen::Vector3d;
using std::chrono::milliseconds;

// Noise of 5 ms readings, as assumed by the filter.
constexpr double kGyroSigma_rad_s = 0.01, kForceSigma_m_s2 = 0.05;

/// X_WC at t (s) of a head that moves along a circle like a G1-like robot's at 0.8 m/s with strides at 1.25
/// Hz: image roll of ±4°, bounce of 13 mm, accelerations up to 7 m/s². It starts at 0.3 m/s.
Isometry3d head_at(double t, double down_rad) {
  const double stride = 2 * std::numbers::pi * 1.25 * t;
  const auto wave = [&](double harmonic, double size) { return size * std::sin(harmonic * stride); };
  const double walked_m = 0.8 * t - 0.25 * (1 - std::exp(-2 * t));
  const AngleAxisd heading(walked_m / 1.2, Vector3d::UnitZ());
  const Vector3d p(0, -1.2 + wave(1, 0.037) + wave(3, 0.006), 1.2 + wave(2, 0.006) + wave(8, 0.0012));
  Eigen::Matrix3d R_LC;  // L: forward, left, up
  R_LC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Vector3d(0.9, 0.15, 0) + heading * p;
  X.linear() = heading * AngleAxisd(wave(1, 0.1), Vector3d::UnitZ()) *
               AngleAxisd(down_rad + wave(2, 0.011), Vector3d::UnitY()) *
               AngleAxisd(wave(1, 0.068), Vector3d::UnitX()) * R_LC;
  return X;
}

/// One motion in the office, rendered and measured: gray frames at 30 Hz, gyro and accelerometer at 200 Hz,
/// no plan.
class Played {
 public:
  Played(double down_deg, double exposure_s)
      : down_rad_(down_deg * std::numbers::pi / 180),
        lead_(options(exposure_s).lead()),
        camera_(physics::load_model(physics::robot_file(), "office", physics::models()), options(exposure_s)),
        data_(mj_makeData(&camera_.model())) {
    mj_kinematics(&camera_.model(), data_.get());
    mj_camlight(&camera_.model(), data_.get());
    const int id = physics::part(camera_.model(), mjOBJ_CAMERA, "head_camera");
    Isometry3d X_WC = physics::pose_in(data_->cam_xpos + 3 * id, data_->cam_xmat + 9 * id);
    X_WC.linear() = X_WC.linear() * Vector3d(1, -1, -1).asDiagonal();  // MuJoCo's cameras look along -z
    X_CB_ = X_WC.inverse() * physics::turned_pose_in(data_->qpos, data_->qpos + 3);
  }

  Isometry3d X_WC(milliseconds t) const { return head_at(1e-3 * t.count(), down_rad_); }

  /// The frame at t and the readings since the last one.
  slam::Observation observe(milliseconds t) {
    slam::Observation observation;
    observation.t = t;
    for (milliseconds at = t - lead_; at <= t + lead_; ++at) {
      const Isometry3d X_WB = X_WC(at) * X_CB_;
      const Eigen::Quaterniond q(X_WB.linear());
      Eigen::Map<Vector3d>(data_->qpos) = X_WB.translation();
      Eigen::Map<Eigen::Vector4d>(data_->qpos + 3) << q.w(), q.x(), q.y(), q.z();
      motion_.add(at, camera_.model(), *data_);
    }
    observation.image = camera_.image(camera_.expose(motion_, t, {}));
    for (milliseconds end; last_ < t; last_ = end) {
      end = std::min(t, milliseconds((last_.count() / 5 + 1) * 5));
      const double dt = 1e-3 * (end - last_).count(), noise = std::sqrt(0.005 / dt);
      const Isometry3d middle = head_at(1e-3 * last_.count() + dt / 2, down_rad_);
      const AngleAxisd turn(X_WC(last_).linear().transpose() * X_WC(end).linear());
      const Vector3d acceleration = (velocity(end) - velocity(last_)) / dt + Vector3d(0, 0, slam::kGravity);
      observation.gyro.push_back(
          {last_, end, turn.angle() / dt * turn.axis() + noise * kGyroSigma_rad_s * random_vector()});
      observation.accelerometer.push_back(
          {last_, end,
           middle.linear().transpose() * acceleration + noise * kForceSigma_m_s2 * random_vector()});
    }
    return observation;
  }

 private:
  static CameraOptions options(double exposure_s) {
    CameraOptions options;
    options.exposure_s = exposure_s;
    return options;
  }
  Vector3d velocity(milliseconds t) const {
    constexpr double h = 1e-4;
    const double t_s = 1e-3 * t.count();
    return (head_at(t_s + h, down_rad_).translation() - head_at(t_s - h, down_rad_).translation()) / (2 * h);
  }
  Vector3d random_vector() {
    return Vector3d::NullaryExpr([&](Eigen::Index) { return normal_(random_); });
  }

  double down_rad_;
  milliseconds lead_;
  HeadCamera camera_;
  physics::Data data_;
  Isometry3d X_CB_;
  RecentMotion motion_{milliseconds(100)};
  milliseconds last_{0};
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

struct Result {
  int bad_frames = 0;  ///< lost, or with a suspect sensor
  double error_m = 0;  ///< error of the position, after 2.5 s and 1.8 m
  double ate_m = 0;    ///< after SE(3) alignment
};

/// Filters a motion; `change` alters the observations. The velocity at the start is unknown to the filter.
template <class Change>
Result track(double down_deg, double exposure_s, Change change) {
  slam::Options options;
  options.start.sigma_velocity_m_s = 0.3;
  options.start.sigma_rate_rad_s = 1;
  options.start.sigma_rest_rad_s = 0;
  Played played(down_deg, exposure_s);
  slam::Filter filter(options, {}, played.X_WC(milliseconds(0)), 1);
  Result result;
  score::Trajectory truth;
  score::Trajectory aligned;
  for (int frame = 0; frame < 75; ++frame) {
    const milliseconds t(frame * 1000 / 30);
    slam::Observation observation = played.observe(t);
    change(observation);
    const slam::FrameReport& report = filter.step(observation);
    result.bad_frames += report.health != slam::Health::ok || report.suspect;
    result.error_m = (played.X_WC(t).translation() - filter.estimate().X_WC.translation()).norm();
    truth.push_back({t, played.X_WC(t)});
    aligned.push_back({t, filter.estimate().X_WC});
  }
  const auto pairs = score::pair_by_stamp(truth, aligned);
  const auto S = std::get<score::Similarity>(score::align(pairs, score::Alignment::se3));
  double squares = 0;
  for (const score::PosePair& pair : pairs)
    squares += ((S * pair.X_estimate).translation() - pair.X_true.translation()).squaredNorm();
  result.ate_m = std::sqrt(squares / double(pairs.size()));
  return result;
}

/// Leg odometry of that motion with errors as caused by loaded contact points on such a robot: distances
/// ahead are 0.9 % too long, heights are too large by 0.6 % of the distance, and the sway is 2 % too small.
slam::LegMotion legs_at(const slam::Observation& observation, double down_deg, std::mt19937& random) {
  std::normal_distribution<double> noise(0, 1e-4);
  const double t = slam::seconds(observation.t);
  slam::LegMotion legs{head_at(t, down_deg * std::numbers::pi / 180), {0, 1.2, 0}};
  const double walked_m = 0.8 * t - 0.25 * (1 - std::exp(-2 * t)), sway_m = 0.037 * std::sin(7.854 * t);
  auto p = legs.X_OC.translation();
  p += AngleAxisd(walked_m / 1.2, Vector3d::UnitZ()) * Vector3d(0, -0.02 * sway_m, 0);
  p.head<2>() = Eigen::Vector2d(0.9, -1.05) + 1.009 * (p.head<2>() - Eigen::Vector2d(0.9, -1.05));
  p.z() += 0.006 * walked_m;
  for (double& x : p) x += noise(random);
  return legs;
}

TEST(AnyMotion, ARollingAndBouncingHeadIsTrackedFromAMovingStartWithoutAPlan) {
  for (const auto& [has_legs, down_deg, exposure_s] :
       {std::tuple(false, 0.0, 0.01), {false, 47.6, 0.0}, {true, 0.0, 0.0}, {true, 47.6, 0.01}}) {
    std::mt19937 random(2);
    const auto with_legs = [&, legs = has_legs, down = down_deg](slam::Observation& observation) {
      if (legs) observation.legs = legs_at(observation, down, random);
    };
    const Result result = track(down_deg, exposure_s, with_legs);
    EXPECT_EQ(result.bad_frames, 0) << has_legs << down_deg;
    EXPECT_LT(has_legs ? result.ate_m : result.error_m, has_legs ? 0.015 : 0.1) << has_legs << down_deg;
  }
}

TEST(AnyMotion, AGyroThatReportsAHeadAtRestIsDetected) {
  const auto at_rest = [](slam::Observation& observation) {
    for (slam::InertialSample& sample : observation.gyro) sample.value.setZero();
  };
  EXPECT_GT(track(0, 0, at_rest).bad_frames, 0);
}

}  // namespace
}  // namespace sim::camera
