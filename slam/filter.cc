#include "slam/filter.h"

namespace slam {
namespace {

constexpr double kLongestStep_s = 10;  // a later time indicates a broken clock
// Standard deviation at the start of a walk without a plan: legs that march add up errors of height.
constexpr double kStartHeight_m = 0.01;
constexpr int kFramesBetweenFullChecks = 150;  // a full check covers the whole covariance
constexpr int kMostChecked = 600;              // parameters in a full check; its cost grows with their cube

}  // namespace

Filter::Filter(const Options& options, const Calibration& calibration, const Eigen::Isometry3d& X_WC_start,
               std::uint64_t seed)
    : options_(options),
      X_WC_start_(X_WC_start),
      depth_(calibration.depth),
      kalman_(initial_state(X_WC_start, with_leg_odometry(options)),
              options.consistency.observability_constrained && options.known_landmarks.at_m.empty(),
              MatchBiases::places(options.vision, options.bounds)),
      internal_(options, calibration),
      visual_(options, Camera(calibration.camera), seed),
      tracking_(options.tracking),
      sensors_(options) {
  report_.deleted.reserve(kLandmarksInView);
  update_estimate(Stamp(0));
}

void FrameReport::begin(Stamp time) {
  t = time;
  predicted = measured = accepted = 0;
  use = {};
  innovations.clear(), initialized.clear(), matched.clear(), searched.clear(), lines.clear(), deleted.clear();
  evidence = {};
  relocalized = false;
  refused.clear();
}

/// One cycle of the filter: Stasse et al. 2006, sections III and IV.
const FrameReport& Filter::step(const Observation& o) {
  if (const auto why = objection(o)) return refuse(o.t, *why);
  const Stamp interval = now_ ? o.t - *now_ : Stamp(0);
  const bool was_lost = tracking_.health() == Health::lost;
  tracking_.accept();
  report_.begin(o.t);
  const auto planned = internal_.advance_plan(o, seconds(interval));
  if (now_)
    predict_and_update(o, planned);  // eq. (6), section IV
  else if (o.legs && !o.plan)
    start_without_plan();
  const VisualResult visual =
      visual_.step({o.image, depth_image(o), o.t, interval, stands_still(o, planned, options_),
                    o.plan || o.legs, frames_, kalman_, tracking_, report_});  // section III-A
  monitor(o, interval, visual);
  const bool gives_up = !tracking_.is_blind() || !knows_pose(pose_estimate(kalman_.state(), o.t));
  if (was_lost && gives_up && visual_.map_use() != MapUse::searching) tracking_.remains_lost(interval);
  if (now_) interval_ = interval;
  now_ = o.t;
  update_estimate(o.t);
  if (smoother_) smoother_->end_step(o.t, kalman_.state());
  return complete_report();
}

void Filter::start_without_plan() {
  internal_.leave_level();
  RobotState start = initial_state(X_WC_start_, with_leg_odometry(without_plan(options_)));
  double& height = start.P(kPosition + 2, kPosition + 2);
  height = std::max(height, kStartHeight_m * kStartHeight_m);
  kalman_.reset_robot(start);
}

void Filter::start_from(const SavedMap& map, MapStart start) {
  visual_.start_from(map, start, kalman_);
  tracking_.search();
}

std::optional<SavedMap> Filter::saved_map() const {
  if (visual_.map_use() == MapUse::searching) return std::nullopt;
  return visual_.saved_map(kalman_.state());
}

void Filter::record() {
  smoother_ = std::make_unique<Smoother>();
  kalman_.record(*smoother_);
}

std::optional<std::vector<SmoothedPose>> Filter::smoothed() {
  return smoother_ ? smoother_->smoothed() : std::nullopt;
}

/// Returns why the observation cannot be used at all.
std::optional<std::string> Filter::objection(const Observation& o) const {
  if (tracking_.health() == Health::diverged) return "the filter has stopped: " + *tracking_.cause();
  if (now_ && o.t <= *now_) return "the observation is not later than the last one";
  if (now_ && seconds(o.t - *now_) > kLongestStep_s) return "the observation is over 10 s after the last one";
  const CameraIntrinsics& camera = visual_.intrinsics();
  const cv::Mat depth_mm = depth_image(o).mm;
  if (!depth_mm.empty() &&
      (depth_mm.type() != CV_16UC1 || depth_mm.size() != cv::Size(camera.width_px, camera.height_px)))
    return "the depth image is not a 16-bit image of the camera's size";
  return malformation(o, camera);
}

/// The image of the aligned depth camera at the time of the frame.
DepthImage Filter::depth_image(const Observation& o) const {
  for (const RigReading& reading : o.rig)
    if (depth_ && reading.sensor == depth_->sensor && reading.t == o.t)
      return {reading.image, depth_->sigma_inverse_1_m};
  return {};
}

/// A rejected observation changes the health but not the state.
const FrameReport& Filter::refuse(Stamp t, const std::string& why) {
  tracking_.refuse(interval_, why);
  report_.begin(t);
  report_.refused.add(why);
  return complete_report();
}

void Filter::predict_and_update(const Observation& o, const std::optional<PlannedInterval>& planned) {
  const Prediction prediction = internal_.predict(o, *now_, planned, kalman_.state(), report_);
  kalman_.predict(prediction.x, prediction.F, prediction.Q);
  visual_.predict(o.t, seconds(o.t - *now_), kalman_);
  if (!internal_.update(o, *now_, planned, kalman_, report_))
    tracking_.diverge("the internal innovation covariance is not positive definite");
  const double dt = seconds(o.t - *now_);
  sensors_.turns().add(dt, internal_.turn_difference(kalman_.state().robot(), planned, dt));
}

/// Tests the sensors against their models, using the evidence in this frame's innovations.
void Filter::monitor(const Observation& o, Stamp interval, const VisualResult& visual) {
  report_.evidence = kalman_.release_evidence();
  const double dt = seconds(interval);
  sensors_.gyro().add(o.gyro);
  if (visual.statistics)
    sensors_.images().add(dt, visual.statistics->searched, visual.statistics->accepted, visual.deleted_young);
  const bool by_legs = o.legs && options_.leg_odometry.enabled;
  sensors_.matches().add(dt, nis_of(report_.innovations, "vision"));
  sensors_.legs().add(dt, by_legs ? nis_of(report_.innovations, "plan_velocity") : std::nullopt);
  sensors_.height().add(dt, nis_of(report_.innovations, "height"));
  if (sensors_.height().fails()) internal_.leave_level();
  const bool lost = tracking_.health() != Health::ok && visual_.map_use() != MapUse::searching;
  sensors_.images().add_health(dt, lost, visual.good_image);
  if (report_.relocalized)
    sensors_.reset();
  else
    sensors_.add(report_.evidence, dt);
}

void Filter::update_estimate(Stamp t) {
  const State& state = kalman_.state();
  if (!kalman_.is_valid(++frames_ % kFramesBetweenFullChecks == 0 ? std::min(state.size, kMostChecked)
                                                                  : kRobot))
    tracking_.diverge("the state is not finite or its covariance is not positive definite");
  estimate_ = pose_estimate(state, t);
}

const FrameReport& Filter::complete_report() {
  report_.landmarks = static_cast<int>(visual_.landmarks().size());
  report_.map = visual_.map_use();
  report_.health = tracking_.health();
  report_.cause = tracking_.cause();
  report_.suspect = sensors_.suspect();
  return report_;
}

}  // namespace slam
