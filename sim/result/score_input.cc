#include "sim/controllers/path.h"
#include "sim/recording/map_file.h"
#include "sim/result/result.h"
#include "slam/camera.h"
#include "walking/timeline.h"

namespace sim::result {
namespace {

/// Returns each pose once, without poses from answers with the status lost. point: the point to score,
/// in C.
std::vector<files::TumRow> estimate(const tracking::Tracked& tracked,
                                    const std::optional<Eigen::Vector3d>& point) {
  std::vector<files::TumRow> poses;
  for (const tracking::TrackedFrame& frame : tracked.frames)
    if (const auto& e = frame.estimate;
        e && frame.report.health == slam::Health::ok && (poses.empty() || e->t > poses.back().t)) {
      poses.push_back({{e->t, e->X_WC}, e->covariance});
      if (point) poses.back().X.translation() = e->X_WC * *point;
    }
  return poses;
}

/// Adds landmarks and sensors from the frames' reports. with_use: also which sensors were used.
void add_reports(score::Run& run, const tracking::Tracked& tracked, bool with_use) {
  static_assert(score::kUsedSensors == slam::kSensorNames);
  std::map<int, score::LandmarkHistory> histories;
  for (const tracking::TrackedFrame& frame : tracked.frames) {
    const slam::FrameReport& r = frame.report;
    for (const slam::Sighting& s : r.initialized) histories[s.landmark] = {s.landmark, {r.t, s.pixel}, {}};
    for (const slam::Sighting& s : r.matched) {
      const auto seen = histories.find(s.landmark);
      if (seen != histories.end()) seen->second.accepted.push_back({r.t, s.pixel});
      if (!run.loaded_map) continue;
      ++run.loaded_map->matches;
      run.loaded_map->reused += seen == histories.end() ? 1 : 0;
    }
    for (std::size_t i = 0; i < score::kSensors.size(); ++i)
      if (const auto nis = slam::nis_of(r.innovations, score::kSensors[i]))
        run.innovations[i].push_back({r.t, nis->value, nis->dof, nis->lagged, nis->lagged_square});
    if (!with_use) continue;
    score::FrameUse& use = run.use.emplace_back();
    use.t = r.t, use.searched = r.searched.size(), use.found = r.matched.size();
    for (std::size_t i = 0; i < slam::kSensorNames.size(); ++i) {
      use.readings[i] = r.use[i] != slam::SensorUse::none;
      use.accepted[i] = r.use[i] == slam::SensorUse::accepted;
    }
  }
  for (auto& [id, history] : histories) run.landmarks.push_back(std::move(history));
}

/// Returns the health in chronological order, without late observations. An answer without a new pose does
/// not track. by_landmarks: the estimator starts to track when it has its first landmark.
std::vector<score::TimedHealth> health(const tracking::Tracked& tracked, bool by_landmarks) {
  std::vector<score::TimedHealth> all;
  bool tracks = !by_landmarks;
  slam::Stamp newest = slam::Stamp::min();  // newest stamp of the poses
  for (const tracking::TrackedFrame& frame : tracked.frames) {
    const slam::FrameReport& report = frame.report;
    tracks = tracks || report.landmarks > 0;
    const bool moved = frame.estimate && frame.estimate->t > newest;
    if (moved) newest = frame.estimate->t;
    if (all.empty() || report.t > all.back().t)
      all.push_back(
          {report.t, tracks && moved && report.health == slam::Health::ok, report.suspect.has_value()});
  }
  for (const auto* const unanswered : {&tracked.untracked, &tracked.dropped})
    for (const slam::Stamp t : *unanswered) all.push_back({t, false, false});
  std::ranges::stable_sort(all, {}, &score::TimedHealth::t);
  return all;
}

std::optional<score::Timeliness> timeliness(const RunRecord& record) {
  const scenario::Scenario& scenario = record.scenario.scenario;
  if (scenario.estimator_time.model == scenario::TimeModel::none) return std::nullopt;
  score::Timeliness all;
  all.period_ms = 1e3 / record.setup.camera_rate_hz;
  all.dropped = record.tracked->dropped.size();
  for (const tracking::TrackedFrame& frame : record.tracked->frames) {
    const slam::Stamp after = frame.effect - frame.report.t + exposure(scenario);
    all.latency_ms.push_back(1e3 * slam::seconds(after));
    all.took_ms.push_back(1e3 * slam::seconds(frame.took));
  }
  return all;
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
  score::TrueCamera truth{project, bearing, {}};
  constexpr int kCells = 4;  // grid cells along each side
  for (int i = 0; i < (kCells + 1) * (kCells + 1); ++i) {
    const Eigen::Vector2d part(i % (kCells + 1), i / (kCells + 1)),
        last(intrinsics.width_px - 1, intrinsics.height_px - 1);
    if (const auto seen = camera.unproject(part.cwiseProduct(last) / kCells))
      truth.grid.push_back(seen->h.normalized());
  }
  return truth;
}

/// Returns the robot's weight: the median of the load on both feet, N.
double weight(const std::vector<score::TrueFeet>& feet) {
  std::vector<double> loads;
  for (const score::TrueFeet& both : feet) loads.push_back(both.left.load_n + both.right.load_n);
  const auto middle = loads.begin() + std::ssize(loads) / 2;
  std::ranges::nth_element(loads, middle);
  return *middle;
}

std::optional<double> torque_limited(const std::vector<score::TrueFeet>& feet) {
  if (feet.empty() || !feet.front().torque_limited) return std::nullopt;
  const auto limited = std::ranges::count(feet, std::optional(true), &score::TrueFeet::torque_limited);
  return double(limited) / double(feet.size());
}

/// Without a plan, only the slip of the feet is known: each foot is compared with its place at touch-down.
std::vector<score::FootRow> feet(const recording::Truth& truth) {
  if (truth.feet.empty() || truth.waist.empty()) return {};
  const Eigen::Vector3d end = score::ground_pose(truth.waist.back().X);
  if (!truth.waist_plan.empty())
    return score::decompose_drift(truth.feet, weight(truth.feet), end,
                                  score::ground_pose(truth.waist_plan.back().X));
  std::vector<score::TrueFeet> samples = truth.feet;
  for (score::TrueFeet& both : samples)
    for (score::TrueFoot* foot : {&both.left, &both.right})
      foot->plan = foot->truth, foot->planned_down = true;
  std::vector<score::FootRow> rows = score::decompose_drift(samples, weight(samples), end, end);
  using enum score::FootPhase;
  std::erase_if(rows, [](const score::FootRow& row) {
    return row.phase == start || row.phase == put_down || row.phase == body;
  });
  return rows;
}

/// Returns the robot's dimensions as shown by the start of a plan: start posture, P below the waist.
walking::Robot robot_at_start(const recording::Truth& truth) {
  walking::Robot robot;
  robot.base_height = truth.waist_plan.front().X.translation().z();
  if (truth.feet.empty()) return robot;
  const Eigen::Vector3d &left = truth.feet.front().left.plan, &right = truth.feet.front().right.plan;
  robot.foot_spacing = left.y() - right.y();
  robot.sole_ahead = (left.x() + right.x()) / 2;
  return robot;
}

/// Returns the pose of the waist above feet that stand side by side.
Eigen::Isometry3d waist_above(const walking::Robot& robot, const walking::FootPose& feet) {
  const walking::FootPose waist = feet * walking::inverse({{robot.sole_ahead, 0}, 0});
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(waist.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X.translation() << waist.position, robot.base_height;
  return X;
}

/// Returns the commanded path, placed in the world at the start.
score::DesiredPath desired_path(const walking::WalkOptions& walk, const recording::Truth& truth) {
  const walking::Robot robot = robot_at_start(truth);
  const walking::Timeline timeline(robot, walk, {{robot.sole_ahead, 0}, 0}, Eigen::Vector2d::Zero());
  score::DesiredPath path;
  path.end = waist_above(robot, walking::center_of(timeline.phases().back().to));
  for (const walking::Timeline::Lap& lap : timeline.laps())
    path.laps.emplace_back(std::int64_t(lap.begin) * walking::kTick, std::int64_t(lap.end) * walking::kTick);
  path.waist = truth.waist_desired.empty() ? truth.waist_plan : truth.waist_desired;
  return path;
}

/// Returns the path that a robot with an external controller had to follow. The recorded path ends where it
/// waited.
score::DesiredPath desired_path(const walking::WalkOptions& walk, const score::Trajectory& waist) {
  const controllers::Path path(walk.commands, {1, 1, 1});  // speeds do not change its end
  const walking::FootPose end = path.pose(path.duration_s());
  return {waist,
          waist.front().X * Eigen::Translation3d(end.position.x(), end.position.y(), 0) *
              Eigen::AngleAxisd(end.yaw, Eigen::Vector3d::UnitZ()),
          {}};
}

}  // namespace

score::Stamp plan_end(const walking::WalkOptions& walk) {
  const walking::Timeline timeline({}, walk, {}, Eigen::Vector2d::Zero());
  return std::int64_t(timeline.ticks()) * walking::kTick;
}

std::vector<files::TimedPose> planned_camera(const RunRecord& record) {
  std::vector<files::TimedPose> poses = record.truth.waist_plan;
  if (poses.empty()) return record.planned_camera;
  const Eigen::Isometry3d X_BC = poses.front().X.inverse() * record.setup.X_WC_start;
  for (files::TimedPose& pose : poses) pose.X = pose.X * X_BC;
  return poses;
}

score::Run score_input(const RunRecord& record) {
  score::Run run;
  run.truth_camera = record.truth.camera;
  run.plan_camera = planned_camera(record);
  run.no_scale = record.no_scale;
  run.fitted = record.alignment && *record.alignment > score::Alignment::origin;
  run.scaled_by = record.scaled_by;
  run.truth_has_poses = !record.truth.positions_of;
  run.truth_waist = record.truth.waist;
  run.plan_waist = record.truth.waist_plan;
  run.camera = true_camera(record.setup.calibration.camera);
  run.surfaces = record.truth.surfaces;
  if (const auto actors = record.scenario.scenario.world.actors_in_W(); !actors.empty())
    run.actors = [actors](score::Stamp t) { return physics::surfaces_of(actors, slam::seconds(t)); };
  run.feet = feet(record.truth);
  run.forces = record.truth.forces;
  run.torque_limited = torque_limited(record.truth.feet);
  const walking::WalkOptions& walk = record.scenario.scenario.walk;
  if (!record.truth.waist_plan.empty())
    run.desired = desired_path(walk, record.truth);
  else if (const auto& path = record.truth.waist_desired; !path.empty())
    run.desired = desired_path(walk, path);
  run.steered = walk.steering.by != walking::SteeredBy::plan && !record.truth.waist_desired.empty();
  run.corrections = record.truth.corrected_steps;
  if (!record.truth.waist_plan.empty()) run.plan_end = plan_end(walk);
  if (!record.tracked) return run;
  run.estimate = estimate(*record.tracked, record.truth.positions_of);
  for (const estimators::PoseEstimate& pose : record.tracked->smoothed)
    if (std::ranges::binary_search(*run.estimate, pose.t, {}, &files::TumRow::t)) {
      run.smoothed.push_back({pose.t, pose.X_WC});
      if (const auto& point = record.truth.positions_of)
        run.smoothed.back().X.translation() = pose.X_WC * *point;
    }
  for (const estimators::PoseEstimate& pose : record.tracked->odometry)
    run.odometry.push_back({pose.t, pose.X_WC});
  const bool is_filter = uses_filter(record.scenario.scenario);
  run.timeliness = timeliness(record);
  run.health = health(*record.tracked, uses_images(record.scenario.scenario));
  const auto& frames = record.tracked->frames;
  if (!frames.empty() && frames.back().report.map != slam::MapUse::none)
    run.loaded_map = {frames.back().report.map == slam::MapUse::refused};
  if (record.tracked->saved_map) run.map_bytes = recording::map_bytes(*record.tracked->saved_map).size();
  add_reports(run, *record.tracked, is_filter);
  if (run.landmarks.empty() && !is_filter) run.no_matches = "the estimator reports no matches of landmarks";
  for (const slam::MapPoint& point : record.tracked->map) run.map.push_back({point.id, point.p_W});
  run.failed = record.tracked->failed;
  if (!frames.empty() && frames.back().report.health == slam::Health::diverged)
    run.diverged = frames.back().report.cause;
  return run;
}

}  // namespace sim::result
