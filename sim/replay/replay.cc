#include "sim/replay/replay.h"

#include <fmt/format.h>

#include <cctype>

#include "sim/result/score_file.h"

namespace sim::replay {
namespace {

constexpr double kLongest_s = 3600;  // longest duration of a stand command

// Adds no noise to the sensors' own. The walk is required, but only its length is used, as a bound on faults.
std::string text_of(double duration_s) {
  return fmt::format("walk: {{commands: [stand: {{duration_s: {}}}]}}", std::min(duration_s, kLongest_s)) +
         R"(
errors:
  gyro: {sigma_rad_s: 0}
  accelerometer: {sigma_m_s2: 0}
  image: {read_sigma_gray: 0, shot_sigma_gray: 0}
camera: {}
slam: {}
)";
}

std::string name_of(const fs::path& folder) {
  std::string name = fs::absolute(folder / "x").lexically_normal().parent_path().filename().string();
  for (char& letter : name)
    if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '_';
  return name.empty() ? "recording" : name;
}

// The IMU noise stated in the folder.
std::vector<std::string> settings_of(const recording::AslSensors& sensors) {
  std::vector<std::string> settings;
  const auto set = [&](const char* key, double value) {
    if (value > 0) settings.push_back(fmt::format("{}={}", key, value));
  };
  const double readings = std::sqrt(slam::kReadingPeriod_s);
  set("slam.gyro.sigma_rad_s", sensors.noise.gyro_density / readings);
  set("slam.accelerometer.sigma_m_s2", sensors.noise.accelerometer_density / readings);
  if (sensors.has_motion) return settings;
  for (const char* sensor : {"accelerometer", "plan_velocity", "height"})
    settings.push_back(fmt::format("slam.{}.enabled=false", sensor));
  set("slam.gyro.sigma_bias_rad_s", 0.1);
  set("slam.gyro.sigma_bias_walk_rad_s2", sensors.noise.gyro_walk);
  return settings;
}

// Images and angular rates do not determine the scale.
std::optional<std::string> why_no_scale(const slam::Options& options, bool has_motion) {
  if (options.accelerometer.enabled || (has_motion && options.plan_velocity.enabled)) return std::nullopt;
  return "camera and gyroscope do not determine the scale: see ate_sim3_rmse_m";
}

// The first image defines W. A truth that starts later is moved so that its first pose equals the estimate at
// that time.
void begin_at_estimate(std::vector<files::TimedPose>& truth,
                       const std::vector<estimators::PoseEstimate>& estimates) {
  for (const files::TimedPose& first : truth) {
    const auto estimate = std::ranges::find(estimates, first.t, &estimators::PoseEstimate::t);
    if (estimate == estimates.end()) continue;
    const Eigen::Isometry3d X_WT = estimate->X_WC * first.X.inverse();
    for (files::TimedPose& pose : truth) pose.X = X_WT * pose.X;
    return;
  }
}

// Processes all observations returned by next(). Returns the stamp of the last one.
template <class Reader>
slam::Stamp track(const Reader& reader, const std::function<std::optional<slam::Observation>()>& next,
                  std::optional<tracking::Tracking>& tracking, result::Timing& timing,
                  const result::Progress& progress, std::vector<files::TimedPose>* plan = nullptr) {
  slam::Stamp last{0};
  while (auto observation = next()) {
    result::FrameTiming frame{.t = observation->t};
    last = observation->t;
    if (plan && observation->plan) plan->push_back({last, observation->plan->X_PC});
    if (tracking) {
      tracking->process(std::move(*observation));
      frame.filter_ms = tracking->cpu_ms();
      frame.answered = tracking->has_answered();
      frame.landmarks = tracking->landmarks();
    }
    timing.frames.push_back(frame);
    progress(reader.part());
  }
  return last;
}

constexpr slam::Stamp kSameFrame =
    std::chrono::milliseconds(2);  // external stamps are rounded, some to 1e-3 s

/// The frames of the recording: their stamps, and the stamp of the first image.
struct Frames {
  std::vector<slam::Stamp> stamps;
  slam::Stamp first_image{0};
};

Frames frames_of(recording::RecordingReader& reader) {
  Frames frames;
  bool seen = false;
  while (const auto observation = reader.next()) {
    if (!seen && !observation->image.empty()) frames.first_image = observation->t, seen = true;
    frames.stamps.push_back(observation->t);
  }
  return frames;
}

using Poses = std::vector<estimators::PoseEstimate>;

/// Returns the covariance of the camera's pose from the body's; see slam::Estimate.
slam::Matrix6d moved_covariance(const slam::Matrix6d& P, const Eigen::Isometry3d& X_WBody,
                                const Eigen::Isometry3d& X_BodyC) {
  const Eigen::Vector3d arm = X_BodyC.translation();
  Eigen::Matrix3d cross;
  cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
  slam::Matrix6d J = slam::Matrix6d::Identity();
  J.topLeftCorner<3, 3>() = X_BodyC.linear().transpose();
  J.bottomLeftCorner<3, 3>() = -X_WBody.linear() * cross;
  return J * P * J.transpose();
}

/// Returns the camera's poses at the stamps of the frames, in the program's own world.
Poses poses_at_frames(const files::TrajectoryFile& file, const Frames& frames, PosedBody body,
                      const slam::Calibration& calibration) {
  slam::Stamp shift{0};      // offset from the file's stamps to the run's
  if (file.columns.empty())  // KITTI
    shift = frames.first_image;
  else if (file.rows.front().t > recording::kEpoch / 2)
    shift = -recording::kEpoch;
  const Eigen::Isometry3d X_BodyC =
      body == PosedBody::imu ? calibration.X_CG.inverse() : Eigen::Isometry3d::Identity();
  Poses raw, poses;
  for (const files::TumRow& row : file.rows) {
    raw.push_back({row.t + shift, row.X * X_BodyC, std::nullopt});
    if (row.covariance) raw.back().covariance = moved_covariance(*row.covariance, row.X, X_BodyC);
  }
  auto pose = raw.begin();
  for (const slam::Stamp t : frames.stamps) {
    while (pose != raw.end() && std::next(pose) != raw.end() &&
           std::chrono::abs(std::next(pose)->t - t) <= std::chrono::abs(pose->t - t))
      ++pose;
    if (pose != raw.end() && std::chrono::abs(pose->t - t) <= kSameFrame)
      poses.push_back({t, pose->X_WC, pose->covariance});
  }
  return poses;
}

score::Similarity operator*(const Eigen::Isometry3d& X, const score::Similarity& S) {
  return {S.scale, X.linear() * S.R, X * S.translation};
}

/// Returns the alignment of the poses with the truth. Throws estimators::EstimatorFailed if there is none.
score::Similarity aligned(const Poses& poses, const std::vector<files::TimedPose>& truth,
                          score::Alignment alignment) {
  score::Trajectory unaligned;
  for (const estimators::PoseEstimate& pose : poses) unaligned.push_back({pose.t, pose.X_WC});
  const auto found = score::align(score::pair_by_stamp(truth, unaligned), alignment);
  if (const auto* const none = std::get_if<score::Absent>(&found))
    throw estimators::EstimatorFailed("its trajectory cannot be aligned with the truth: " + none->reason);
  return std::get<score::Similarity>(found);
}

/// Moves the poses into W and returns the scale factor.
double place_in_world(Poses& poses, const ExternalRun& run, const result::RunRecord& record) {
  const Eigen::Isometry3d X_RW = record.scenario.scenario.world.start.X_RW();
  std::optional<score::Similarity> own, &in_room = run.in_room ? *run.in_room : own;
  if (!in_room) in_room = X_RW * aligned(poses, record.truth.camera, run.alignment);
  const score::Similarity S = X_RW.inverse() * *in_room;
  slam::Matrix6d J = slam::Matrix6d::Identity();
  J.bottomRightCorner<3, 3>() = S.scale * S.R;
  for (estimators::PoseEstimate& pose : poses) {
    pose.X_WC = S * pose.X_WC;
    if (pose.covariance) pose.covariance = J * *pose.covariance * J.transpose();
  }
  return S.scale;
}

/// Frames with a pose are tracked, the others are not.
void read_run(const ExternalRun& run, const Frames& frames, result::RunRecord& record,
              tracking::Tracked& tracked) {
  const files::TrajectoryFile file = files::read_trajectory(run.trajectory, run.columns);
  if (!file.has_orientation)
    throw estimators::EstimatorFailed("its trajectory has positions only, expected poses");
  if (file.counts_frames)
    throw estimators::EstimatorFailed(
        "its trajectory has frame numbers for stamps: write times.txt next to it");
  if (file.warning) run.warn("its trajectory: " + *file.warning);
  Poses poses = poses_at_frames(file, frames, run.body, record.setup.calibration);
  const bool whole = std::ranges::all_of(
      file.rows, [](const files::TumRow& row) { return row.t % std::chrono::seconds(1) == slam::Stamp(0); });
  if (poses.empty() || (whole && poses.size() < file.rows.size()))
    throw estimators::EstimatorFailed(
        fmt::format("{} of its {} poses are within 2 ms of a frame's stamp{}", poses.size(), file.rows.size(),
                    whole ? ": its stamps are whole numbers, like frame numbers" : ""));
  const bool in_map = run.in_room && *run.in_room;
  record.scaled_by = place_in_world(poses, run, record);
  auto pose = poses.begin();
  for (const slam::Stamp t : frames.stamps) {
    if (pose == poses.end() || pose->t != t) {
      tracked.untracked.push_back(t);
      continue;
    }
    tracking::TrackedFrame& frame = tracked.frames.emplace_back();
    frame.estimate = *pose++;
    frame.report.t = t;
    if (in_map) frame.report.map = slam::MapUse::found;
  }
}

}  // namespace

WalkEnd read_walk_end(const fs::path& result_folder) {
  const result::About about = result::read_about_of_walk(result_folder / "about.json");
  return {*about.walk, std::nullopt, about.models};
}

result::Outcome replay(const scenario::ReadScenario& scenario, const fs::path& recording, const WalkEnd& walk,
                       const result::ResultPlace& place, const result::Progress& progress, Recorded recorded,
                       const std::vector<fs::path>& sessions) {
  return result::make_sessions(
      scenario, place, progress,
      [&](const scenario::ReadScenario& read, const estimators::Session& before,
          const result::ResultPlace& to, const fs::path& into, const result::Progress& part) {
        const bool is_last = &read == &scenario;
        const fs::path walked = is_last            ? fs::path()
                                : sessions.empty() ? recording.parent_path() / to.folder.filename()
                                                   : sessions.at(std::size_t(before.index) - 1),
                       from = is_last ? recording : walked / "recording";
        result::Timing timing;
        recording::RecordingReader reader(from);
        std::optional<tracking::Tracking> tracking;
        const recording::RecordingSetup& setup = reader.setup();
        if (read.scenario.slam)
          tracking.emplace(read.scenario, setup.calibration, setup.X_WC_start, setup.camera_rate_hz,
                           setup.rig, setup.joints, before);
        const std::function<bool(int)> wants = [&](int sensor) { return tracking && tracking->uses(sensor); };
        const slam::Stamp last = track(
            reader, [&] { return reader.next(wants); }, tracking, timing, part);
        const WalkEnd end = is_last ? walk : read_walk_end(walked);
        result::RunRecord record{read,         end.ended,    reader.setup(), recording::read_truth(from),
                                 std::nullopt, reader.hash()};
        record.counterfactual = end.counterfactual;
        if (tracking) record.tracked = tracking->finish();
        const result::Outcome outcome =
            result::write_result(into, record, to, timing, 1e-9 * double(last.count()));
        if (recorded == Recorded::copied) fs::copy(from, into / "recording", fs::copy_options::recursive);
        return outcome;
      });
}

scenario::ReadScenario external_scenario(const recording::AslFolder& folder,
                                         const scenario::Changes& changes) {
  const std::string text = text_of(slam::seconds(folder.times().back())), place = folder.folder().string();
  scenario::ReadScenario plain =
      scenario::read_scenario_text(text, place, changes);  // reports errors in `changes`
  scenario::Changes all = changes;
  std::vector<std::string> settings{"name=" + name_of(folder.folder())};
  for (const std::string& stated : settings_of(folder.sensors()))
    if (!plain.origin.contains(stated.substr(0, stated.find('=')))) settings.push_back(stated);
  all.overrides.insert(all.overrides.begin(), settings.begin(), settings.end());
  return scenario::read_scenario_text(text, place, all);
}

result::Outcome replay_external(const scenario::ReadScenario& scenario, recording::AslFolder& folder,
                                const result::ResultPlace& place, const result::Progress& progress) {
  files::AtomicFolder result(place.folder);
  const recording::AslSensors& sensors = folder.sensors();
  std::optional<tracking::Tracking> tracking(std::in_place, scenario.scenario, sensors.setup.calibration,
                                             sensors.setup.X_WC_start, sensors.setup.camera_rate_hz);
  result::Timing timing;
  std::vector<files::TimedPose> plan;
  const slam::Stamp last = track(
      folder, [&] { return folder.next(); }, tracking, timing, progress, &plan);
  result::RunRecord record{scenario, {scenario::Ending::completed}, sensors.setup, {}, tracking->finish(),
                           ""};
  recording::Truth truth = folder.truth();
  if (!truth.positions_of && !truth.camera.empty() && truth.camera.front().t > folder.times().front())
    begin_at_estimate(truth.camera, record.tracked->estimates());
  record.truth = std::move(truth);
  record.planned_camera = std::move(plan);
  record.no_scale = why_no_scale(*scenario.scenario.slam, sensors.has_motion);
  const result::Outcome outcome =
      result::write_result(result.path(), record, place, timing, slam::seconds(last));
  result.commit();
  return outcome;
}

result::Outcome score_external(const scenario::ReadScenario& scenario, const fs::path& recording,
                               const WalkEnd& walk, const ExternalRun& run, const result::ResultPlace& place,
                               const fs::path& into, result::Timing timing) {
  recording::RecordingReader reader(recording);
  const Frames frames = frames_of(reader);
  result::RunRecord record{scenario,     walk.ended,   reader.setup(), recording::read_truth(recording),
                           std::nullopt, reader.hash()};
  record.alignment = run.alignment;
  tracking::Tracked tracked;
  tracked.log = run.log;
  tracked.failed = run.failed;
  try {
    if (!run.failed) read_run(run, frames, record, tracked);
  } catch (const files::FileError& unusable) {
    tracked.failed = fmt::format("its trajectory cannot be used: {}", unusable.what());
  } catch (const estimators::EstimatorFailed& unusable) {
    tracked.failed = unusable.what();
  }
  if (run.alignment == score::Alignment::sim3 || run.alignment == score::Alignment::scale)
    record.no_scale =
        fmt::format("the estimate was scaled by {:.4g} to the truth: see ate_sim3_rmse_m", record.scaled_by);
  if (tracked.failed) tracked.untracked = frames.stamps;
  timing.each_frame = false;
  for (const slam::Stamp t : frames.stamps)
    timing.frames.push_back({.t = t, .filter_ms = run.cpu_ms / double(frames.stamps.size())});
  record.tracked = std::move(tracked);
  const double end_s = frames.stamps.empty() ? 0 : slam::seconds(frames.stamps.back());
  if (run.keep && fs::exists(run.trajectory)) fs::copy_file(run.trajectory, into / "trajectory.txt");
  return result::write_result(into, record, place, timing, end_s);
}

}  // namespace sim::replay
