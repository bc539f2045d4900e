#include "sim/result/desired_path.h"

#include <chrono>
#include <utility>

#include "walking/hrp2.h"
#include "walking/pattern_generator.h"
#include "walking/timeline.h"

namespace sim::result {
namespace {

/// Feet together below a waist at the origin.
const walking::FootPose kFeet{{walking::hrp2::kAnkleX, 0}, 0};

Eigen::Isometry3d waist_above(const walking::FootPose& feet) {
  const walking::FootPose waist = feet * walking::inverse(kFeet);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(waist.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X.translation() << waist.position, walking::hrp2::kWaistHeight;
  return X;
}

Eigen::Isometry3d between(const walking::Reference& from, const walking::Reference& to, double part) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(from.X_PB.linear())
                   .slerp(part, Eigen::Quaterniond(to.X_PB.linear()))
                   .toRotationMatrix();
  X.translation() = (1 - part) * from.X_PB.translation() + part * to.X_PB.translation();
  return X;
}

/// The uncorrected plan at the stamps of the corrected one.
score::Trajectory uncorrected(walking::WalkOptions walk, const std::vector<files::TimedPose>& waist_plan) {
  walk.arm_motion = walking::ArmMotion::still;  // arms and second stage need a model of the whole body
  walk.second_preview = false;
  walking::PatternGenerator plan(walk);
  walking::Reference from = plan.next(), to = plan.next();
  std::size_t tick = 0;
  score::Trajectory path;
  for (const files::TimedPose& pose : waist_plan) {
    const auto due = static_cast<std::size_t>(pose.t / walking::kTick);
    for (; tick < due; ++tick) from = std::exchange(to, plan.next());
    const std::chrono::duration<double> after = pose.t - static_cast<std::int64_t>(tick) * walking::kTick;
    path.push_back({pose.t, between(from, to, after.count() / walking::kPeriod)});
  }
  return path;
}

}  // namespace

score::DesiredPath desired_path(const walking::WalkOptions& walk,
                                const std::vector<files::TimedPose>& waist_plan) {
  const walking::Timeline timeline(walk, kFeet, Eigen::Vector2d::Zero());
  score::DesiredPath path;
  path.end = waist_above(walking::center_of(timeline.phases().back().to));
  for (const walking::Timeline::Lap& lap : timeline.laps())
    path.laps.emplace_back(static_cast<std::int64_t>(lap.begin) * walking::kTick,
                           static_cast<std::int64_t>(lap.end) * walking::kTick);
  if (walk.steering.by == walking::SteeredBy::plan)
    path.waist = waist_plan;
  else
    path.waist = uncorrected(walk, waist_plan);
  return path;
}

}  // namespace sim::result
