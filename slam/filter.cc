#include "slam/filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "slam/accelerometer.h"
#include "slam/active_search.h"
#include "slam/camera.h"
#include "slam/consensus.h"
#include "slam/gyro.h"
#include "slam/kalman.h"
#include "slam/map.h"
#include "slam/motion_model.h"
#include "slam/plan.h"
#include "slam/relocalisation.h"
#include "slam/tracking_watch.h"

namespace slam {
namespace {

constexpr double kGate3 = 16.27;  // chi-square, 99.9 %, 3 rows: an internal measurement beyond is refused
constexpr double kGate1 = 10.83;  // 1 row
constexpr double kGate2 = 9.21;   // 99 %, 2 rows: a match beyond is refused
constexpr double kLongestStep_s = 10;  // a stamp further ahead is a broken clock
constexpr int kAllOfP = 30;            // frames between two looks at all of P
constexpr int kBegunPerFrame = 3;      // landmarks, after the first frame with any

RobotVector start_mean(const Eigen::Isometry3d& X_WC) {
  RobotVector x = RobotVector::Zero();
  const Eigen::Quaterniond q(X_WC.linear());
  x.segment<3>(kPosition) = X_WC.translation();
  x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  return x;
}

RobotMatrix start_covariance(const RobotVector& x, const Options& options) {
  const auto square = [](double a) { return a * a; };
  RobotMatrix P = RobotMatrix::Zero();
  P.diagonal().segment<3>(kPosition).setConstant(square(options.start.sigma_position_m));
  const Matrix43d dq = left_matrix(x.segment<4>(kOrientation)).rightCols<3>() / 2;  // ∂(q × Exp(θ))/∂θ
  P.block<4, 4>(kOrientation, kOrientation) =
      square(options.start.sigma_orientation_rad) * dq * dq.transpose();
  P.diagonal().segment<3>(kVelocity).setConstant(square(options.start.sigma_velocity_m_s));
  P.diagonal().segment<3>(kRate).setConstant(square(options.start.sigma_rate_rad_s));
  P.diagonal().segment<3>(kGyroBias).setConstant(square(options.gyro.sigma_bias_rad_s));
  P.diagonal().segment<3>(kAccelerometerBias).setConstant(square(options.accelerometer.sigma_bias_m_s2));
  P.diagonal().segment<3>(kSlip).setConstant(square(options.plan_velocity.sigma_slip_m_s));
  P.diagonal().segment<2>(kStride).setConstant(square(options.plan_velocity.sigma_stride));
  const Eigen::Vector3d sway = sway_sigma(options.plan_velocity);
  P.diagonal().segment<3>(kSwayVelocity) = sway.cwiseAbs2();
  P.diagonal().segment<3>(kSway) =
      (sway * options.plan_velocity.sway_period_s / (2 * std::numbers::pi)).cwiseAbs2();
  return P;
}

bool finite(const PlannedMotion& plan) {
  return plan.X_PC.matrix().allFinite() && plan.v_PC_C.allFinite() && plan.w_PC_C.allFinite() &&
         plan.p_CF.allFinite();
}

const char* kind_name(const LandmarkKind& kind) {
  constexpr std::array kNames{"point", "inverse_depth", "line"};
  return kNames[kind.index()];
}

/// Area of the box around where they are expected, part of the image's.
double spread(const std::vector<Candidate>& candidates, const CameraIntrinsics& camera) {
  Eigen::AlignedBox2d box;
  for (const Candidate& candidate : candidates) box.extend(candidate.pixel);
  return box.isEmpty() ? 0 : box.volume() / (camera.width_px * camera.height_px);
}

/// σ of the image's grey values, every fourth row looked at.
double contrast(const cv::Mat& image) {
  std::int64_t sum = 0, square = 0, count = 0;
  for (int row = 0; row < image.rows; row += 4) {
    const uchar* grey = image.ptr<uchar>(row);
    for (int column = 0; column < image.cols; ++column) {
      sum += grey[column];
      square += grey[column] * grey[column];
    }
    count += image.cols;
  }
  const double mean = static_cast<double>(sum) / static_cast<double>(count);
  return std::sqrt(std::max(0.0, static_cast<double>(square) / static_cast<double>(count) - mean * mean));
}

}  // namespace

struct Filter::Workings {
  Workings(const Options& o, const Calibration& c, const Eigen::Isometry3d& X_WC_start, std::uint64_t seed)
      : options(o),
        calibration(c),
        camera(c.camera),
        kalman(start_mean(X_WC_start), start_covariance(start_mean(X_WC_start), o),
               o.consistency.observability_constrained && o.known_landmarks.at_m.empty()),
        map(seed) {}

  Options options;
  Calibration calibration;
  Camera camera;
  Kalman kalman;
  Map map;
  std::optional<Stamp> now;           // of the last observation taken in
  std::optional<PlannedMotion> plan;  // of the last observation
  Gait gait;                          // till then
  InertialInterval earlier, later;    // of the last two observations
  TrackingWatch watch{options.tracking};
  Glance glance;       // of this frame
  double lost_s = 0;   // in images, since tracking was lost
  int frames = 0;      // taken in
  cv::Mat last_image;  // to tell a frozen one
  bool known_sought = false;
  Estimate estimate;
  FrameReport report;
  // Work space, kept so that a step in the steady state takes no memory anew.
  Joint joint, strict, agreed;
  Consensus consensus;
  std::vector<Measurement> internal, matches;
  std::vector<Candidate> candidates;
  std::vector<std::size_t> whose, keep;  // candidate of each match; those of matches that are used
  std::vector<char> success;             // of each candidate
  std::vector<Eigen::Vector2d> taken;    // pixels in view where a landmark is
  Eigen::MatrixXd factor;

  RobotVector robot() const { return kalman.state().storage_x.head<kRobot>(); }
  std::string objection(const Observation& o) const;
  void predict(const Observation& o);
  std::optional<Impulse> felt_impulse(const Observation& o);
  std::optional<Measurement> velocity_measurement(const RobotVector& x, const Observation& o) const;
  void measure_internal(const Observation& o, Stamp before);
  std::optional<Nis> gated(const Measurement& m, double gate, const char* name);
  void begin_known(const Observation& o);
  void measure_vision(const Observation& o);
  void begin_report(Stamp t);
  void update_with_matches(const cv::Mat& image);
  void learn_surface(const cv::Mat& image);
  void choose();
  Nis nis_of(const Joint& joined);
  void add_line_pixels();
  int landmarks_wanted(std::size_t in_view) const;
  void report_begun(std::size_t first);
  void judge_tracking();
  bool usable(const cv::Mat& image);
  void look_for_the_map(const Observation& o, double dt);
  void restart_at(const Relocation& found);
  void manage_map(const Observation& o);
  void update(const Joint& with, const char* name);
  void refuse(const std::string& why) { report.refused += (report.refused.empty() ? "" : "; ") + why; }
  void diverge(const std::string& cause);
  void publish();
};

Filter::Filter(const Options& options, const Calibration& calibration, const Eigen::Isometry3d& X_WC_start,
               std::uint64_t seed)
    : workings_(std::make_unique<Workings>(options, calibration, X_WC_start, seed)) {
  workings_->publish();
}
Filter::~Filter() = default;
Filter::Filter(Filter&&) noexcept = default;
Filter& Filter::operator=(Filter&&) noexcept = default;

/// One cycle of the paper's section III.
const FrameReport& Filter::step(const Observation& o) {
  Workings& w = *workings_;
  w.begin_report(o.t);
  w.report.refused = w.objection(o);
  if (!w.report.refused.empty()) return w.report;

  const double dt = w.now ? seconds(o.t - *w.now) : 0;
  if (w.now) {
    w.predict(o);                   // eq. (6)
    w.measure_internal(o, *w.now);  // section III-C: gyro, planned velocity
  }
  w.glance = Glance{};
  w.glance.dt_s = dt;
  if (w.options.vision.enabled && w.usable(o.image)) {
    if (w.report.health == Health::lost) {
      w.look_for_the_map(o, dt);
    } else {
      w.measure_vision(o);  // section III-A: active search, update, map
      w.judge_tracking();
    }
  }
  if (w.plan && o.plan)
    w.gait =
        planned_gait(*w.plan, *o.plan, planned_stride(*w.plan, *o.plan, dt, VelocityAxes::robot), w.gait, dt);
  w.now = o.t;
  w.plan = o.plan;
  w.publish();
  return w.report;
}

/// An empty one but for what lasts; its lists keep their memory.
void Filter::Workings::begin_report(Stamp t) {
  FrameReport last;
  std::swap(last, report);
  report.t = t;
  report.health = last.health;
  report.cause.swap(last.cause);
  report.landmarks = static_cast<int>(map.landmarks().size());
  const auto keep_memory = [](auto& list, auto& old) {
    list.swap(old);
    list.clear();
  };
  keep_memory(report.begun, last.begun);
  keep_memory(report.matched, last.matched);
  keep_memory(report.searched, last.searched);
  keep_memory(report.deleted, last.deleted);
  keep_memory(report.lines, last.lines);
}

const Estimate& Filter::estimate() const { return workings_->estimate; }

/// Why the observation cannot be used at all; empty if it can.
std::string Filter::Workings::objection(const Observation& o) const {
  if (report.health == Health::diverged) return "the filter has stopped: " + report.cause;
  if (now && o.t <= *now) return "its time is not after the last one's";
  if (now && seconds(o.t - *now) > kLongestStep_s) return "its time is more than 10 s after the last one's";
  if (!o.image.empty() && (o.image.type() != CV_8UC1 || o.image.cols != calibration.camera.width_px ||
                           o.image.rows != calibration.camera.height_px))
    return "its image is not 8-bit grey of the camera's size";
  for (const auto* samples : {&o.gyro, &o.accelerometer})
    for (const InertialSample& sample : *samples)
      if (!sample.value.allFinite() || sample.end < sample.begin) return "an inertial reading is not finite";
  if (o.plan && !finite(*o.plan)) return "its plan is not finite";
  return "";
}

void Filter::Workings::predict(const Observation& o) {
  const Prediction prediction = predict_motion(robot(), seconds(o.t - *now), felt_impulse(o), options);
  kalman.predict(prediction.x, prediction.F, prediction.Q);
}

std::optional<Measurement> Filter::Workings::velocity_measurement(const RobotVector& x,
                                                                  const Observation& o) const {
  if (!options.plan_velocity.enabled || !o.plan || !plan) return std::nullopt;
  const double dt = seconds(o.t - *now);
  PlannedStride stride = planned_stride(*plan, *o.plan, dt, options.plan_velocity.axes);
  const Gait walking = planned_gait(*plan, *o.plan, stride, gait, dt);
  stride.steady_C = walking.steady_C;
  Options::PlanVelocity expected = options.plan_velocity;
  expected.sigma_m_s = velocity_sigma(walking, options.plan_velocity);
  return measure_velocity(x, stride, expected);
}

/// The accelerometer's word, unless the motion model finds it incredible or the plan contradicts it.
std::optional<Impulse> Filter::Workings::felt_impulse(const Observation& o) {
  if (!options.accelerometer.enabled) return std::nullopt;
  std::swap(earlier, later);
  later.from = *now, later.to = o.t;
  later.gyro = o.gyro, later.accelerometer = o.accelerometer;
  const auto impulse =
      mean_velocity_change(earlier, later, calibration.X_CG, robot().segment<3>(kGyroBias), options);
  if (!impulse) return std::nullopt;
  const double dt = seconds(o.t - *now);
  const Prediction with = predict_motion(robot(), dt, impulse, options);
  const Eigen::Vector3d V = with.x.segment<3>(kVelocity) - robot().segment<3>(kVelocity);
  const double believable = options.motion.sigma_acceleration_m_s2 * dt;
  bool trusted = V.squaredNorm() < kGate3 * believable * believable;
  if (const auto m = velocity_measurement(with.x, o); trusted && m) {
    const RobotMatrix P = with.F * kalman.state().marginal<kRobot>(0) * with.F.transpose() + with.Q;
    const Eigen::Matrix3d S = m->H_robot * P * m->H_robot.transpose() + m->R;
    trusted = S.llt().matrixL().solve(m->innovation).squaredNorm() < kGate3;
  }
  if (trusted) return impulse;
  refuse("accelerometer is beyond its gate");
  return std::nullopt;
}

/// Puts a measurement to the others if it passes its gate, and says so if it does not.
std::optional<Nis> Filter::Workings::gated(const Measurement& measurement, double gate, const char* name) {
  Measurement m = measurement;
  kalman.constrain(m);
  const Nis nis{kalman.nis(m), m.rows, kalman.log_determinant(m)};
  if (nis.value < gate)
    internal.push_back(m);
  else
    refuse(std::string(name) + " is beyond its gate");
  return nis;
}

void Filter::Workings::measure_internal(const Observation& o, Stamp before) {
  internal.clear();
  if (options.gyro.enabled && o.gyro.empty()) refuse("the gyro is silent");
  if (options.gyro.enabled)
    if (const auto rate = mean_rate(o.gyro, before, o.t, calibration.X_CG.linear(), options))
      report.gyro = gated(measure_rate(robot(), *rate), kGate3, "gyro");
  if (const auto m = velocity_measurement(robot(), o))
    report.plan_velocity = gated(*m, kGate3, "planned velocity");
  if (options.height.enabled && o.plan)
    report.height = gated(measure_height(robot(), o.plan->X_PC.translation().z(), options.height), kGate1,
                          "planned height");
  if (options.plan_orientation.enabled && o.plan)
    gated(measure_orientation(robot(), o.plan->X_PC.linear(), options.plan_orientation), kGate3,
          "planned orientation");
  if (options.plan_position.enabled && o.plan)
    gated(measure_position(robot(), o.plan->X_PC.translation(), options.plan_position), kGate3,
          "planned position");
  if (internal.empty()) return;
  kalman.stack(internal, joint);
  update(joint, "internal");
}

void Filter::Workings::begin_known(const Observation& o) {
  const std::size_t known = options.known_landmarks.at_m.size();
  if (std::exchange(known_sought, true) || known == 0) return;
  const int seen = map.begin_known(o.image, o.t, camera, options, kalman);
  if (static_cast<std::size_t>(seen) < known) refuse("a known landmark is not seen in the first image");
  report_begun(0);
}

/// The landmarks from `first` on were begun in this frame.
void Filter::Workings::report_begun(std::size_t first) {
  for (std::size_t i = first; i < map.landmarks().size(); ++i)
    report.begun.push_back({map.landmarks()[i].id, map.landmarks()[i].pixel_first});
}

/// Whether the image can tell anything; says so where it should and cannot.
bool Filter::Workings::usable(const cv::Mat& image) {
  if (image.empty()) return false;
  const bool frozen =
      !last_image.empty() && std::equal(image.begin<uchar>(), image.end<uchar>(), last_image.begin<uchar>());
  image.copyTo(last_image);
  if (contrast(image) < kFlatContrast)
    refuse("the image is flat");
  else if (frozen)
    refuse("the image is the last one again");
  else
    return true;
  return false;
}

void Filter::Workings::measure_vision(const Observation& o) {
  begin_known(o);
  predict_view(kalman, map.landmarks(), camera, options.vision.sigma_px, candidates);
  report.predicted = static_cast<int>(candidates.size());
  taken.clear();
  for (const Candidate& candidate : candidates) taken.push_back(candidate.pixel);
  keep_most_informative(candidates, static_cast<std::size_t>(options.vision.measured_landmarks));

  matches.clear();
  whose.clear();
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (auto m = find(o.image, map.landmarks()[candidates[i].index], candidates[i], options.vision)) {
      matches.push_back(*m);
      whose.push_back(i);
    }
  report.measured = static_cast<int>(matches.size());
  update_with_matches(o.image);
  manage_map(o);
}

/// νᵀS⁻¹ν and ln |S| of matches.
Nis Filter::Workings::nis_of(const Joint& joined) {
  make_room(factor, joined.rows, joined.rows + 1);
  auto L = factor.topLeftCorner(joined.rows, joined.rows);
  auto white = factor.col(joined.rows).head(joined.rows);
  L = joined.S();
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(L);
  white = joined.innovation();
  llt.matrixL().solveInPlace(white);
  return {white.squaredNorm(), joined.rows, 2 * L.diagonal().array().log().sum()};
}

/// Stacks what was found and keeps the matches that agree among themselves.
void Filter::Workings::choose() {
  keep.resize(matches.size());
  std::iota(keep.begin(), keep.end(), std::size_t{0});
  if (matches.empty()) return;
  kalman.stack(matches, joint);
  strict = joint;
  if (!options.vision.consensus) return;
  sharpen(strict, matches, options.vision.gate_sigma_px / options.vision.sigma_px);
  keep = consensus.largest(strict, kGate2);
}

/// Of one match a frame, in turn.
void Filter::Workings::learn_surface(const cv::Mat& image) {
  if (!options.vision.warped_patches || !options.vision.estimate_normals) return;
  const std::size_t i = keep[static_cast<std::size_t>(frames) % keep.size()];
  const Candidate& found = candidates[whose[i]];
  map.learn_surface(found.index, image, found.pixel + matches[i].innovation, camera, kalman.state());
}

/// Updates with the matches that agree, and counts searches and successes.
void Filter::Workings::update_with_matches(const cv::Mat& image) {
  choose();
  success.assign(candidates.size(), 0);
  for (const std::size_t i : keep) {
    const Candidate& c = candidates[whose[i]];
    success[whose[i]] = 1;
    report.matched.push_back({map.landmarks()[c.index].id, c.pixel + matches[i].innovation});
  }
  if (!keep.empty()) {
    select(strict, keep, agreed);
    report.vision = nis_of(agreed);
    select(joint, keep, agreed);
    report.update = nis_of(agreed);
    update(agreed, "vision");
    learn_surface(image);
    for (const std::size_t i : keep) map.seen_anew(candidates[whose[i]].index, camera, options, kalman);
  }
  for (std::size_t i = 0; i < candidates.size(); ++i)
    report.searched.push_back(
        {map.landmarks()[candidates[i].index].id, candidates[i].pixel, candidates[i].S, success[i] != 0});
  report.accepted = static_cast<int>(report.matched.size());
  glance.searched = candidates.size();
  glance.accepted = report.matched.size();
  glance.spread = spread(candidates, calibration.camera);
  if (blind(glance)) return;  // the image or the pose is at fault, not the landmarks
  for (std::size_t i = 0; i < candidates.size(); ++i) map.count(candidates[i].index, success[i] != 0);
}

void Filter::Workings::judge_tracking() {
  const auto per_row = [](const Nis& nis) { return nis.value / nis.dof; };
  if (report.vision) glance.vision_nis = per_row(*report.vision);
  if (report.height) glance.height_nis = per_row(*report.height);
  if (report.health != Health::ok) return;
  const std::string why = watch.judge(glance);
  if (why.empty()) return;
  if (!options.tracking.relocalise) return diverge("tracking lost: " + why);
  report.health = Health::lost;
  report.cause = "tracking lost: " + why;
  lost_s = 0;
}

void Filter::Workings::look_for_the_map(const Observation& o, double dt) {
  const auto found = relocalise(o.image, map.landmarks(), kalman.state(), camera, options.vision.sigma_px);
  if (found) return restart_at(*found);
  lost_s += dt;
  if (lost_s > options.tracking.give_up_s) diverge(report.cause + ", and the map was not found again");
}

/// The pose that the map gives; velocities are those of a walking robot, sensors' biases stay as believed.
void Filter::Workings::restart_at(const Relocation& found) {
  constexpr double kWalking_m_s = 0.3, kWalking_rad_s = 0.5;
  RobotVector x = start_mean(found.X_WC);
  x.tail<kRobot - kCamera>() = robot().tail<kRobot - kCamera>();
  RobotMatrix P = RobotMatrix::Zero();
  Eigen::Matrix<double, 7, 6> J = Eigen::Matrix<double, 7, 6>::Zero();
  J.block<3, 3>(kPosition, 3).setIdentity();
  J.block<4, 3>(kOrientation, 0) =
      left_matrix(x.segment<4>(kOrientation)).rightCols<3>() / 2;  // ∂(q × Exp(θ))/∂θ
  P.topLeftCorner<7, 7>() = J * found.covariance * J.transpose();
  P.diagonal().segment<3>(kVelocity).setConstant(kWalking_m_s * kWalking_m_s);
  P.diagonal().segment<3>(kRate).setConstant(kWalking_rad_s * kWalking_rad_s);
  P.bottomRightCorner<kRobot - kCamera, kRobot - kCamera>() =
      kalman.state().marginal<kRobot - kCamera>(kCamera);
  kalman.restart(x, P);
  watch.begin_anew();
  report.health = Health::ok;
  report.cause.clear();
  report.relocalised = true;
}

void Filter::Workings::manage_map(const Observation& o) {
  map.prune(kalman, report.deleted);
  if (options.depth.linearity > 0) map.convert(options.depth.linearity, kalman);
  map.follow_lines(o.image, camera, options, kalman, report.deleted, report.lines);
  const int wanted = landmarks_wanted(taken.size());
  const std::size_t before = map.landmarks().size();
  add_line_pixels();
  if (wanted > 0 && !watch.in_doubt() && !blind(glance))
    map.begin(o.image, o.t, taken, wanted, camera, options, kalman);
  report_begun(before);
  report.landmarks = static_cast<int>(map.landmarks().size());
}

/// Where the landmarks that are still lines should be about now.
void Filter::Workings::add_line_pixels() {
  for (const Landmark& landmark : map.landmarks()) {
    if (!std::holds_alternative<SemiInfiniteLine>(landmark.kind)) continue;
    const Parameters y = kalman.state().storage_x.segment(landmark.at, landmark.size());
    const auto seen = camera.project(
        direction(landmark.kind, y, kalman.state().position(), kalman.state().orientation()).h_C);
    if (seen) taken.push_back(seen->pixel);
  }
}

int Filter::Workings::landmarks_wanted(std::size_t in_view) const {
  const int missing = options.vision.visible_landmarks - static_cast<int>(in_view);
  const Options::Depth::Particles& particles = options.depth.particles;
  if (options.depth.first_sight == FirstSight::inverse_depth)
    return map.landmarks().empty() ? missing : std::min(missing, kBegunPerFrame);
  if (kalman.state().velocity().norm() < particles.minimum_speed_m_s) return 0;
  return std::min(missing, particles.at_once - map.lines());
}

void Filter::Workings::update(const Joint& with, const char* name) {
  if (!kalman.update(with))
    diverge(std::string("the ") + name + " innovation covariance is not positive definite");
}

void Filter::Workings::diverge(const std::string& cause) {
  if (report.health == Health::diverged) return;
  report.health = Health::diverged;
  report.cause = cause;
}

void Filter::Workings::publish() {
  const int looked_at = ++frames % kAllOfP == 0 ? kalman.state().size : kRobot;
  if (!kalman.sound(looked_at)) diverge("the state is not finite or its covariance not positive definite");
  const State& state = kalman.state();
  estimate.t = now.value_or(Stamp{0});
  estimate.X_WC = state.X_WC();
  Eigen::Vector4d back = state.orientation();
  back.tail<3>() *= -1;
  Eigen::Matrix<double, 6, 7> J = Eigen::Matrix<double, 6, 7>::Zero();  // of (orientation, position) errors
  J.block<3, 4>(0, kOrientation) = 2 * left_matrix(back).bottomRows<3>();
  J.block<3, 3>(3, kPosition).setIdentity();
  const Matrix6d covariance = J * state.marginal<7>(0) * J.transpose();
  estimate.covariance = (covariance + covariance.transpose()) / 2;  // symmetric to the last bit
}

std::vector<MapPoint> Filter::map() const {
  std::vector<MapPoint> points;
  const State& state = workings_->kalman.state();
  for (const Landmark& landmark : workings_->map.landmarks()) {
    const int at = landmark.at, size = landmark.size();
    const Parameters y = state.storage_x.segment(at, size);
    const auto J = position_jacobian(landmark.kind, y);
    points.push_back(
        {landmark.id, kind_name(landmark.kind), position(landmark.kind, y),
         J * state.storage_P.block(at, at, size, size).selfadjointView<Eigen::Lower>() * J.transpose(),
         landmark.begun, landmark.attempts, landmark.successes});
  }
  return points;
}

}  // namespace slam
