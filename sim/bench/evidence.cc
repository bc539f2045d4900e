#include "sim/bench/evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "slam/camera.h"
#include "walking/timeline.h"

namespace sim::bench {
namespace {

score::Trajectory trajectory(const std::vector<stream::TimedPose>& poses) {
  score::Trajectory trajectory;
  for (const stream::TimedPose& pose : poses) trajectory.push_back({pose.t, pose.X});
  return trajectory;
}

std::vector<score::EstimatedPose> estimate(const Tracked& tracked) {
  std::vector<score::EstimatedPose> poses;
  for (const slam::Estimate& e : tracked.estimates()) poses.push_back({e.t, e.X_WC, e.covariance});
  return poses;
}

std::vector<score::LandmarkHistory> landmarks(const Tracked& tracked) {
  std::map<int, score::LandmarkHistory> histories;
  for (const TrackedFrame& frame : tracked.frames) {
    const slam::Stamp t = frame.report.t;
    for (const slam::Sighting& s : frame.report.begun) histories[s.landmark] = {s.landmark, {t, s.pixel}, {}};
    for (const slam::Sighting& s : frame.report.matched)
      histories.at(s.landmark).accepted.push_back({t, s.pixel});
  }
  std::vector<score::LandmarkHistory> all;
  for (auto& [id, history] : histories) all.push_back(std::move(history));
  return all;
}

using Innovations = std::array<std::vector<score::StampedInnovation>, score::kSensors.size()>;

Innovations innovations(const Tracked& tracked) {
  Innovations all;
  for (const TrackedFrame& frame : tracked.frames) {
    const slam::FrameReport& r = frame.report;
    const std::array sensors{&r.vision, &r.gyro, &r.plan_velocity, &r.height};  // as score::kSensors
    for (std::size_t i = 0; i < sensors.size(); ++i)
      if (*sensors[i]) all[i].push_back({r.t, {(*sensors[i])->value, (*sensors[i])->dof}});
  }
  return all;
}

std::vector<score::MappedPoint> map(const Tracked& tracked) {
  std::vector<score::MappedPoint> points;
  for (const slam::MapPoint& point : tracked.map) points.push_back({point.id, point.p_W, point.covariance});
  return points;
}

score::Stamp at_tick(std::size_t tick) {
  return std::chrono::nanoseconds(std::llround(1e9 * walking::kPeriod)) * static_cast<std::int64_t>(tick);
}

score::TrueCamera true_camera(const slam::CameraIntrinsics& intrinsics) {
  const slam::Camera camera(intrinsics);
  const auto project = [camera](const Eigen::Isometry3d& X_WC,
                                const Eigen::Vector3d& p_W) -> std::optional<Eigen::Vector2d> {
    const auto seen = camera.project(X_WC.inverse() * p_W);
    if (!seen || !camera.inside(seen->pixel, 0)) return std::nullopt;
    return seen->pixel;
  };
  const auto bearing = [camera](const Eigen::Vector2d& pixel) -> Eigen::Vector3d {
    return camera.unproject(pixel).value().h.normalized();
  };
  return {project, bearing};
}

score::Planar planar(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::vector<score::FootRow> feet(const stream::Truth& truth) {
  if (truth.feet.empty() || truth.waist.empty()) return {};
  constexpr double kWeight = 56.867992 * 9.81;  // N, of the nominal robot
  std::vector<score::FeetSample> samples;
  for (const stream::TrueFeet& both : truth.feet) {
    const auto sample = [&](const stream::TrueFoot& foot) -> score::FootSample {
      return {planar(foot.truth), planar(foot.plan), foot.planned_down, foot.load_n / kWeight,
              planar(foot.creep)};
    };
    samples.push_back({both.t, {sample(both.left), sample(both.right)}});
  }
  return score::account(samples, score::planar(truth.waist.back().X),
                        score::planar(truth.waist_plan.back().X));
}

}  // namespace

score::Surface surface(const stream::RecordedSurface& recorded) {
  using Kind = score::Surface::Kind;
  static const std::map<std::string, Kind> kinds{{"plane", Kind::plane},         {"box", Kind::box},
                                                 {"sphere", Kind::sphere},       {"cylinder", Kind::cylinder},
                                                 {"ellipsoid", Kind::ellipsoid}, {"capsule", Kind::capsule}};
  return {kinds.at(recorded.kind), recorded.X_WS, recorded.size};
}

score::PlannedTimes planned_times(const walking::WalkOptions& walk) {
  const walking::Timeline timeline(walk, {}, Eigen::Vector2d::Zero());
  score::PlannedTimes planned{at_tick(timeline.ticks()), {}};
  std::size_t tick = 0;
  for (const walking::Phase& phase : timeline.phases()) {
    tick += static_cast<std::size_t>(phase.ticks);
    if (phase.support != walking::Support::both) planned.footsteps.push_back(at_tick(tick));
  }
  return planned;
}

std::vector<stream::TimedPose> planned_camera(const Remains& remains) {
  std::vector<stream::TimedPose> poses = remains.truth.waist_plan;
  if (poses.empty()) return remains.planned_camera;
  const Eigen::Isometry3d X_BC = poses.front().X.inverse() * remains.setup.X_WC_start;
  for (stream::TimedPose& pose : poses) pose.X = pose.X * X_BC;
  return poses;
}

score::Run evidence(const Remains& remains) {
  score::Run run;
  run.truth_camera = trajectory(remains.truth.camera);
  run.plan_camera = trajectory(planned_camera(remains));
  run.no_scale = remains.no_scale;
  run.truth_waist = trajectory(remains.truth.waist);
  run.plan_waist = trajectory(remains.truth.waist_plan);
  run.camera = true_camera(remains.setup.calibration.camera);
  for (const stream::RecordedSurface& recorded : remains.truth.surfaces)
    run.surfaces.push_back(surface(recorded));
  run.feet = feet(remains.truth);
  run.planned = planned_times(remains.scenario.scenario.walk);
  if (!remains.tracked) return run;
  run.estimate = estimate(*remains.tracked);
  run.landmarks = landmarks(*remains.tracked);
  run.innovations = innovations(*remains.tracked);
  run.map = map(*remains.tracked);
  if (remains.tracked->diverged()) run.diverged = remains.tracked->cause();
  return run;
}

}  // namespace sim::bench
