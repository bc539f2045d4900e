#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/replay/replay.h"
#include "sim/score/trajectory.h"

namespace sim::replay {
namespace {

constexpr slam::Stamp kSameFrame =
    std::chrono::milliseconds(2);  // external stamps are rounded, some to 1e-3 s

/// The frames of the recording: their stamps, and that of the first image.
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

/// The covariance of the camera's pose from that of the body's, see slam::Estimate.
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

/// The poses of the camera at the stamps of the frames, in the program's own world.
Poses poses_at_frames(const files::TrajectoryFile& file, const Frames& frames, PosedBody body,
                      const slam::Calibration& calibration) {
  slam::Stamp shift{0};  // from stamps of the file to those of the run
  if (file.format == "KITTI")
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

/// Moves the poses into W. Throws estimators::EstimatorFailed if they cannot be aligned with the truth.
void place_in_world(Poses& poses, const std::vector<files::TimedPose>& truth, score::Alignment alignment) {
  score::Trajectory unaligned;
  for (const estimators::PoseEstimate& pose : poses) unaligned.push_back({pose.t, pose.X_WC});
  const auto found = score::align(score::pair_by_stamp(truth, unaligned), alignment);
  if (const auto* const none = std::get_if<score::Absent>(&found))
    throw estimators::EstimatorFailed("its trajectory cannot be aligned with the truth: " + none->reason);
  const auto& S = std::get<score::Similarity>(found);
  slam::Matrix6d J = slam::Matrix6d::Identity();
  J.bottomRightCorner<3, 3>() = S.scale * S.R;
  for (estimators::PoseEstimate& pose : poses) {
    pose.X_WC = S * pose.X_WC;
    if (pose.covariance) pose.covariance = J * *pose.covariance * J.transpose();
  }
}

/// Frames with a pose are tracked, the others are not.
void read_run(const ExternalRun& run, const Frames& frames, const result::RunRecord& record,
              tracking::Tracked& tracked) {
  const files::TrajectoryFile file = files::read_trajectory(run.trajectory);
  if (!file.has_orientation)
    throw estimators::EstimatorFailed("its trajectory has positions only, expected poses");
  if (file.stamps == "frame numbers")
    throw estimators::EstimatorFailed(
        "its trajectory has frame numbers for stamps: write times.txt beside it");
  Poses poses = poses_at_frames(file, frames, run.body, record.setup.calibration);
  if (poses.empty())
    throw estimators::EstimatorFailed(
        fmt::format("none of its {} poses has the stamp of a frame", file.rows.size()));
  place_in_world(poses, record.truth.camera, run.alignment);
  auto pose = poses.begin();
  for (const slam::Stamp t : frames.stamps) {
    if (pose == poses.end() || pose->t != t) {
      tracked.untracked.push_back(t);
      continue;
    }
    tracking::TrackedFrame& frame = tracked.frames.emplace_back();
    frame.estimate = *pose++;
    frame.report.t = t;
  }
}

}  // namespace

result::Outcome score_external(const scenario::ReadScenario& scenario, const std::filesystem::path& recording,
                               const WalkEnd& walk, const ExternalRun& run, const result::ResultPlace& place,
                               result::Timing timing) {
  files::AtomicFolder folder(place.folder, place.existing);
  recording::RecordingReader reader(recording);
  const Frames frames = frames_of(reader);
  result::RunRecord record{scenario,     walk.ended,   reader.setup(), recording::read_truth(recording),
                           std::nullopt, reader.hash()};
  record.alignment = score::name_of(run.alignment);
  if (run.alignment == score::Alignment::sim3 || run.alignment == score::Alignment::scale)
    record.no_scale = "the estimate was scaled to the truth: see ate_sim3_rmse_m";
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
  if (tracked.failed) tracked.untracked = frames.stamps;
  timing.each_frame = false;
  for (const slam::Stamp t : frames.stamps)
    timing.frames.push_back({.t = t, .filter_ms = run.cpu_ms / static_cast<double>(frames.stamps.size())});
  record.tracked = std::move(tracked);
  const double end_s = frames.stamps.empty() ? 0 : slam::seconds(frames.stamps.back());
  const result::Outcome outcome = result::write_result(folder.path(), record, place, timing, end_s);
  if (run.keep && std::filesystem::exists(run.trajectory))
    std::filesystem::copy_file(run.trajectory, folder.path() / "trajectory.txt");
  folder.commit();
  return outcome;
}

}  // namespace sim::replay
