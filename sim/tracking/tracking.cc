#include "sim/tracking/tracking.h"

#include <chrono>
#include <exception>
#include <iterator>
#include <new>

#include "sim/recording/map_file.h"
#include "sim/sensor_errors/random.h"

namespace sim::tracking {
namespace {

constexpr slam::Stamp kMapEvery = std::chrono::seconds(1);
const programs::Choice kOdometry{programs::Source::built_in, "odometry", {}, {}};

/// Returns the periods of consecutive frames with a cause, each with its last cause.
template <class CauseOf>
std::vector<TrackingFault> intervals(const std::vector<TrackedFrame>& frames, const CauseOf& cause_of) {
  std::vector<TrackingFault> all;
  bool open = false;
  for (const TrackedFrame& frame : frames) {
    const std::optional<std::string> cause = cause_of(frame.report);
    if (cause && !open) all.push_back({frame.report.t, std::nullopt, ""});
    if (cause) all.back().cause = *cause;
    if (!cause && open) all.back().to = frame.report.t;
    open = cause.has_value();
  }
  return all;
}

/// Sets `given` to the readings of both that end after `since` but not after `until`, each once and in order:
/// observations may arrive twice or out of order. Later readings stay in `missed`.
void merge_until(slam::Stamp until, slam::Stamp since, auto& missed, auto& given, const auto& order,
                 const auto& end) {
  missed.insert(missed.end(), given.begin(), given.end());
  std::ranges::stable_sort(missed, {}, order);
  const auto is_same = [&](const auto& a, const auto& b) { return order(a) == order(b); };
  missed.erase(std::unique(missed.begin(), missed.end(), is_same), missed.end());
  std::erase_if(missed, [&](const auto& reading) { return end(reading) <= since; });
  const auto later = std::stable_partition(missed.begin(), missed.end(),
                                           [&](const auto& reading) { return end(reading) <= until; });
  given.assign(missed.begin(), later);
  missed.erase(missed.begin(), later);
}

// Errors of a start that is told in the frame of a loaded map: uniform along x and y and in heading.
constexpr double kKnown_m = 0.05, kKnown_rad = 0.05, kRough_m = 0.5, kRough_rad = 0.35;

/// Returns W, which is under the start, in the map's frame as the estimator is told.
Eigen::Isometry3d told_start(const scenario::Scenario& scenario, bool has_map) {
  physics::WorldOptions::Start start = scenario.world.start;
  if (!has_map) return start.X_RW();
  if (scenario.slam->map.start == slam::MapStart::unknown) return Eigen::Isometry3d::Identity();
  const bool known = scenario.slam->map.start == slam::MapStart::known;
  sensor_errors::Random random(scenario.seed, "start in the map");
  for (double* const value : {&start.x_m, &start.y_m, &start.yaw_rad}) {
    const double m = known ? kKnown_m : kRough_m, rad = known ? kKnown_rad : kRough_rad;
    *value += (value == &start.yaw_rad ? rad : m) * (2 * random.uniform() - 1);
  }
  return start.X_RW();
}

constexpr double kMostMemory_gb = 2;

std::uintmax_t bytes_in(const std::filesystem::path& folder) {
  std::uintmax_t bytes = 0;
  if (folder.empty()) return bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.symlink_status().type() == std::filesystem::file_type::regular) bytes += entry.file_size();
  return bytes;
}

void move(const Eigen::Isometry3d& X, estimators::PoseEstimate& pose) {
  pose.X_WC = X * pose.X_WC;
  if (!pose.covariance) return;
  slam::Matrix6d J = slam::Matrix6d::Identity();
  J.bottomRightCorner<3, 3>() = X.linear();
  pose.covariance = J * *pose.covariance * J.transpose();
}

}  // namespace

double cpu_ms(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

std::optional<scenario::Ended> Tracked::failure() const {
  if (failed) return scenario::Ended{scenario::Ending::estimator_failed, *failed};
  if (frames.empty() || frames.back().report.health == slam::Health::ok) return std::nullopt;
  const slam::FrameReport& last = frames.back().report;
  const bool lost = last.health == slam::Health::lost;
  return scenario::Ended{scenario::Ending::diverged,
                         last.cause.value() + (lost ? "; the map was not found again before the end" : "")};
}

std::vector<estimators::PoseEstimate> Tracked::estimates() const {
  std::vector<estimators::PoseEstimate> all;
  for (const TrackedFrame& frame : frames)
    if (frame.estimate && (all.empty() || frame.estimate->t > all.back().t)) all.push_back(*frame.estimate);
  return all;
}

std::vector<TrackingFault> Tracked::losses() const {
  return intervals(frames, [](const slam::FrameReport& report) {
    return report.health == slam::Health::ok ? std::nullopt : report.cause;
  });
}

std::vector<TrackingFault> Tracked::suspicions() const {
  return intervals(frames, [](const slam::FrameReport& report) { return report.suspect; });
}

Tracking::Tracking(const scenario::Scenario& scenario, std::unique_ptr<estimators::Estimator> estimator,
                   const std::vector<rig::RigSensor>& rig)
    : rig_(rig),
      errors_(scenario.errors, scenario.seed, rig),
      time_(scenario.estimator_time),
      estimator_(std::move(estimator)) {}

Tracking::Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
                   const Eigen::Isometry3d& X_WC_start, double camera_rate_hz,
                   const std::vector<rig::RigSensor>& rig, const std::vector<std::string>& joints,
                   const estimators::Session& session)
    : Tracking(scenario, nullptr, rig) {
  estimators::Start start{calibration, X_WC_start, scenario.seed, *scenario.slam, camera_rate_hz};
  start.rig = rig, start.joints = joints;
  if (scenario.camera) start.camera_readout_s = scenario.camera->readout_s;
  sensor_errors::state_errors(scenario.errors, start.chest_imu);
  if (auto* lens = std::get_if<slam::OneParameterRadial>(&start.calibration.camera.lens))
    lens->k1_px2 *= 1 + scenario.errors.calibration_distortion_fraction;
  const fs::path& file = session.map_file.empty() ? scenario.slam->map.load : session.map_file;
  start.session = session, memory_ = session.memory;
  std::optional<slam::SavedMap>& map = start.session.map;
  if (!map && !file.empty()) map = recording::read_map(file, start.calibration.camera);
  in_memory_ = !memory_.empty() && !std::filesystem::is_empty(memory_);
  const bool has_map = map || in_memory_;
  if (has_map || !scenario.world.start.is_default()) {
    frames_ = {scenario.world.start.X_RW().inverse(), told_start(scenario, has_map)};
    start.X_WC = frames_->told * X_WC_start;
  }
  if (scenario.slam->plan_velocity.enabled && scenario.estimator != kOdometry) {
    odometry_input_.start = start;
    odometry_input_.start->session = {};
  }
  try {
    estimator_ = estimators::make_estimator(scenario.estimator, start);
  } catch (const estimators::EstimatorFailed& failure) {
    tracked_.failed = failure.what();
    tracked_.log = failure.log;
  }
}

void Tracking::process(slam::Observation ideal) {
  clock_.now = std::max(clock_.now, ideal.t);
  if (frames_ && ideal.plan) ideal.plan->X_PC = frames_->told * ideal.plan->X_PC;
  if (frames_ && ideal.legs) ideal.legs->X_OC = frames_->told * ideal.legs->X_OC;
  std::erase_if(ideal.rig, [this](const slam::RigReading& reading) { return !uses(reading.sensor); });
  for (const slam::Observation& arrived : errors_.process(std::move(ideal))) step(arrived);
}

void Tracking::step(const slam::Observation& arrived) {
  if (odometry_input_.start) {
    odometry_input_.arrived.push_back(arrived);
    odometry_input_.arrived.back().image.release();
    odometry_input_.arrived.back().rig.clear(), odometry_input_.arrived.back().body.clear();
  }
  clock_.now = std::max(clock_.now, arrived.t);
  image_ = arrived.image;
  advance(clock_.now);
  if (clock_.free <= clock_.now || time_.on_busy == scenario::OnBusy::wait)
    return answer(arrived, clock_.now);
  if (time_.queue == 0) return drop(arrived);
  if (waiting_) drop(waiting_->observation);
  waiting_ = {arrived, clock_.now};
}

void Tracking::advance(slam::Stamp now) {
  if (!waiting_ || clock_.free > now) return;
  const Waiting next = *std::exchange(waiting_, {});
  answer(next.observation, next.arrival);
}

// Exceptions from estimators are failures of the estimator, except running out of memory.
void Tracking::answer(const slam::Observation& arrived, slam::Stamp arrival) {
  const bool diverged = newest() && newest()->report.health == slam::Health::diverged;
  try {
    if (!diverged && !failed()) ask(arrived, arrival);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& failure) {
    tracked_.failed = failure.what();
  } catch (...) {
    tracked_.failed = "it threw an exception that is not a std::exception";
  }
  if (diverged || failed()) tracked_.untracked.push_back(arrived.t);
}

void Tracking::ask(const slam::Observation& arrived, slam::Stamp arrival) {
  using Clock = std::chrono::steady_clock;
  std::optional<slam::Observation> whole;
  if (!missed_.gyro.empty() || !missed_.accelerometer.empty() || !missed_.rig.empty() ||
      !missed_.body.empty())
    add_missed(whole.emplace(arrived));
  const auto began = Clock::now();
  const double cpu_began_ms = thread_cpu_ms();
  estimators::Answer answer = estimator_->step(whole ? *whole : arrived);
  slam::Stamp took{0};
  if (time_.model == scenario::TimeModel::measured) took = Clock::now() - began;
  if (time_.model == scenario::TimeModel::fixed) took = slam::Stamp(std::llround(1e6 * time_.frame_ms));
  clock_.free = std::max(clock_.free, arrival) + took;
  given_ = std::max(given_, arrived.t);
  cpu_ms_ += thread_cpu_ms() - cpu_began_ms + answer.external_cpu_ms;
  if (in_memory_) answer.report.map = slam::MapUse::found;
  refused_map_ = answer.report.map == slam::MapUse::refused;
  if (frames_ && answer.estimate) move(X_WM(), *answer.estimate);
  tracked_.frames.push_back({answer.estimate, std::move(answer.report), took, clock_.free});
  auto& maps = tracked_.maps;
  if (maps.empty() || arrived.t - maps.back().t >= kMapEvery) maps.push_back({arrived.t, map()});
}

std::vector<slam::MapPoint> Tracking::map() const {
  if (!estimator_) return {};
  std::vector<slam::MapPoint> points = estimator_->map();
  for (slam::MapPoint& point : points) {
    if (!frames_) break;
    point.p_W = X_WM() * point.p_W;
    point.covariance = X_WM().linear() * point.covariance * X_WM().linear().transpose();
  }
  return points;
}

void Tracking::drop(const slam::Observation& arrived) {
  tracked_.dropped.push_back(arrived.t);
  for (const auto readings : {&slam::Observation::gyro, &slam::Observation::accelerometer})
    std::ranges::copy(arrived.*readings, std::back_inserter(missed_.*readings));
  std::ranges::copy(arrived.body, std::back_inserter(missed_.body));
  std::ranges::copy_if(arrived.rig, std::back_inserter(missed_.rig),
                       [this](const auto& reading) { return is_imu(reading); });
}

void Tracking::add_missed(slam::Observation& observation) {
  const auto merge = [&](auto& missed, auto& given, const auto& order, const auto& end) {
    merge_until(observation.t, given_, missed, given, order, end);
  };
  for (const auto readings : {&slam::Observation::gyro, &slam::Observation::accelerometer})
    merge(
        missed_.*readings, observation.*readings, [](const slam::InertialSample& r) { return r.begin; },
        [](const slam::InertialSample& r) { return r.end; });
  const auto before = [](const slam::BodyReading& r) { return r.t + slam::Stamp(1); };
  merge(missed_.body, observation.body, before, before);
  // Adds the readings of the additional IMUs, after images and sweeps. Their true ends are compared with the
  // frames' stamps.
  auto& rig = observation.rig;
  const auto first =
      std::stable_partition(rig.begin(), rig.end(), [this](const auto& r) { return !is_imu(r); });
  std::vector<slam::RigReading> imus(first, rig.end());
  rig.erase(first, rig.end());
  merge(
      missed_.rig, imus, [](const slam::RigReading& r) { return std::pair(r.sensor, r.t); },
      [this](const slam::RigReading& r) {
        return r.t - sensor_errors::stamp(rig_.at(static_cast<std::size_t>(r.sensor)).time_offset_s);
      });
  std::ranges::move(imus, std::back_inserter(observation.rig));
}

bool Tracking::is_imu(const slam::RigReading& reading) const {
  return rig_.at(static_cast<std::size_t>(reading.sensor)).kind == rig::Kind::imu;
}

Tracked Tracking::finish() {
  for (const slam::Observation& arrived : errors_.flush()) step(arrived);
  advance(slam::Stamp::max());
  tracked_.odometry = odometry();
  if (!estimator_) return std::move(tracked_);
  try {
    tracked_.log = estimator_->finish();
  } catch (const estimators::EstimatorFailed& failure) {
    tracked_.log = failure.log;
    if (!failed()) tracked_.failed = failure.what();
  }
  if (const double gb = 1e-9 * double(bytes_in(memory_)); gb > kMostMemory_gb && !failed())
    tracked_.failed =
        fmt::format("its folder session.memory has {:.2f} GB, expected at most {} GB", gb, kMostMemory_gb);
  tracked_.map = map();
  tracked_.saved_map = estimator_->saved_map();
  tracked_.smoothed = estimator_->smoothed();
  for (estimators::PoseEstimate& pose : tracked_.smoothed)
    if (frames_) move(X_WM(), pose);
  return std::move(tracked_);
}

std::vector<estimators::PoseEstimate> Tracking::odometry() const {
  std::vector<estimators::PoseEstimate> poses;
  if (odometry_input_.arrived.empty() || !odometry_input_.arrived.front().plan) return poses;
  const auto odometry = estimators::make_estimator(kOdometry, *odometry_input_.start);
  for (const slam::Observation& observation : odometry_input_.arrived) {
    const estimators::Answer answer = odometry->step(observation);
    if (answer.report.health == slam::Health::diverged) return {};
    if (!poses.empty() && answer.estimate->t <= poses.back().t) continue;
    poses.push_back(*answer.estimate);
    if (frames_) move(frames_->told.inverse(), poses.back());
  }
  return poses;
}

}  // namespace sim::tracking
