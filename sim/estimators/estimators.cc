#include <fmt/format.h>

#include "sim/estimators/messages.h"
#include "slam/filter.h"

namespace sim::estimators {
namespace {

constexpr double kMost_m = 1e9;      // larger positions lose accuracy when squared
constexpr double kRotation = 1e-6;   // bound on R^T R - I; allows for printed numbers
constexpr double kSymmetric = 1e-6;  // relative to the largest element
constexpr std::string_view kFilter = "filter", kOdometry = "odometry", kPlanAlone = "plan_alone";
constexpr double kOdometryPivot_m = 0.25;  // best on the training walks
constexpr std::array kNames{kFilter, kOdometry, kPlanAlone};

template <class Matrix>
void require_covariance(const Matrix& P, std::string_view of) {
  if (!P.allFinite()) throw EstimatorFailed(fmt::format("the covariance of {} is not finite", of));
  const double largest = P.cwiseAbs().maxCoeff();
  if ((P - P.transpose()).cwiseAbs().maxCoeff() > kSymmetric * largest)
    throw EstimatorFailed(fmt::format("the covariance of {} is not symmetric", of));
}

/// Returns the calibration, including the depth camera aligned with the head camera if the filter uses it.
slam::Calibration with_depth(const Start& start) {
  slam::Calibration calibration = start.calibration;
  if (start.options.depth.first_sight != slam::FirstSight::measured_depth) return calibration;
  for (std::size_t i = 0; i < start.rig.size(); ++i)
    if (start.rig[i].kind == rig::Kind::depth && start.rig[i].aligned_with == rig::kHeadCamera)
      calibration.depth = {int(i), rig::inverse_depth_sigma(start.rig[i])};
  if (!calibration.depth)
    throw std::invalid_argument(
        "slam.depth.first_sight: measured_depth needs a depth camera that is aligned with cam0");
  return calibration;
}

class FilterEstimator : public Estimator {
 public:
  explicit FilterEstimator(const Start& start)
      : calibration_(with_depth(start)),
        saves_map_(start.options.map.save),
        filter_(start.options, calibration_, start.X_WC, start.seed) {
    if (!start.options.vision.enabled) return;
    if (start.session.map) filter_.start_from(*start.session.map, start.options.map.start);
    filter_.record();
  }

  Answer step(const slam::Observation& observation) override {
    const slam::FrameReport& report = filter_.step(observation);
    const slam::Estimate& estimate = filter_.estimate();
    if (report.map == slam::MapUse::searching) {  // the estimate is in a local frame
      from_ = estimate.t + slam::Stamp(1);
      return {std::nullopt, report};
    }
    return {PoseEstimate{estimate.t, estimate.X_WC, estimate.covariance}, report};
  }
  bool uses(int sensor) const override { return calibration_.depth && calibration_.depth->sensor == sensor; }
  std::vector<slam::MapPoint> map() const override { return filter_.map(); }
  std::optional<slam::SavedMap> saved_map() const override {
    return saves_map_ ? filter_.saved_map() : std::nullopt;
  }
  std::vector<PoseEstimate> smoothed() override {
    std::vector<PoseEstimate> poses;
    for (const slam::SmoothedPose& pose : filter_.smoothed().value_or(std::vector<slam::SmoothedPose>()))
      if (pose.t >= from_) poses.push_back({pose.t, pose.X_WC, std::nullopt});
    return poses;
  }

 private:
  slam::Calibration calibration_;
  bool saves_map_;
  slam::Stamp from_ = slam::Stamp::min();  // stamp of the first pose in the map
  slam::Filter filter_;
};

std::string at(const slam::Observation& observation) {
  return fmt::format("at t = {:.3f} s", slam::seconds(observation.t));
}

/// Checks an estimator's answers and keeps the latest map among them. Omits poses older than the last one,
/// as for a late observation.
class CheckedEstimator : public Estimator {
 public:
  Answer step(const slam::Observation& observation) final {
    newest_ = std::max(newest_, observation.t);
    Answer answer = ask(observation);
    try {
      require_valid(answer, observation.t, last_, newest_);
    } catch (const EstimatorFailed& invalid) {
      throw failed(at(observation), invalid.what());
    }
    if (answer.estimate && answer.estimate->t < last_) answer.estimate.reset();
    if (answer.estimate) last_ = answer.estimate->t;
    if (answer.map) map_ = *answer.map;
    answer.report.t = observation.t;
    answer.report.landmarks = int(map_.size());
    return answer;
  }
  std::vector<slam::MapPoint> map() const override { return map_; }

 private:
  virtual Answer ask(const slam::Observation& observation) = 0;
  /// Returns the exception for an invalid answer. when: "at t = 1.000 s".
  virtual EstimatorFailed failed(const std::string& when, const std::string& cause) {
    return EstimatorFailed(fmt::format("{}: {}", when, cause));
  }

  slam::Stamp newest_{0}, last_{0};  // stamps of the newest observation; of the last answer's pose
  std::vector<slam::MapPoint> map_;
};

class FunctionEstimator : public CheckedEstimator {
 public:
  explicit FunctionEstimator(Step step) : step_(std::move(step)) {}

 private:
  Answer ask(const slam::Observation& observation) override { return step_(observation); }

  Step step_;
};

/// The filter without its images: gyro, accelerometer and leg odometry, with their covariance. Without
/// images, an error in the point about which the robot tilts would look like a gyro bias.
std::unique_ptr<Estimator> odometry(Start start) {
  double& pivot_m = start.options.leg_odometry.sigma_pivot_m;
  pivot_m = std::max(pivot_m, kOdometryPivot_m);
  start.options.vision.enabled = false;
  start.options.known_landmarks.at_m.clear();
  return std::make_unique<FilterEstimator>(start);
}

/// Lost until the first plan arrives.
Step plan_alone() {
  return [planned = std::optional<PoseEstimate>()](const slam::Observation& observation) mutable {
    if (observation.plan) planned.emplace().X_WC = observation.plan->X_PC;
    if (planned) planned->t = observation.t;
    Answer answer{planned, {}};
    if (!planned) answer.report.health = slam::Health::lost, answer.report.cause = "the walk has no plan";
    return answer;
  };
}

/// The conversation with a program, from START to END.
class ProgramEstimator : public CheckedEstimator {
 public:
  ProgramEstimator(const programs::Choice& choice, const Start& start)
      : rig_(start.rig),
        program_(choice, "estimator", start_message(choice, start), read_ready, kMostBytes,
                 start.session.memory) {}

  std::string finish() override { return program_.finish(); }

 private:
  Answer ask(const slam::Observation& observation) override {
    const double before_ms = program_.cpu_ms();
    try {
      Answer answer = read_answer(program_.ask(observation_message(observation, rig_)));
      answer.external_cpu_ms = std::max(0.0, program_.cpu_ms() - before_ms);
      return answer;
    } catch (const EstimatorFailed& failure) {
      throw failed(at(observation), failure.what());
    }
  }

  EstimatorFailed failed(const std::string& when, const std::string& cause) override {
    return program_.failed(when, cause);
  }

  std::vector<rig::RigSensor> rig_;
  programs::Conversation program_;
};

}  // namespace

void require_valid(const Answer& answer, slam::Stamp observed, slam::Stamp last, slam::Stamp newest) {
  if (answer.estimate) {
    const auto& [t, X, covariance] = *answer.estimate;
    if (t != observed && (t < last || t > newest))
      throw EstimatorFailed(fmt::format(
          "its pose has the stamp {} ns, expected the observation's, {} ns, or the last pose's, {} ns",
          t.count(), observed.count(), last.count()));
    if (!X.matrix().allFinite()) throw EstimatorFailed("its pose is not finite");
    if (const Eigen::Matrix3d R = X.linear();
        !(R.transpose() * R).isIdentity(kRotation) || R.determinant() < 0)
      throw EstimatorFailed("the orientation of its pose is not a rotation matrix");
    if (X.translation().cwiseAbs().maxCoeff() > kMost_m)
      throw EstimatorFailed("its position is more than 1e9 m away");
    if (covariance) require_covariance(*covariance, "its pose");
  }
  if (!answer.map) return;
  for (const slam::MapPoint& point : *answer.map) {
    if (!point.p_W.allFinite()) throw EstimatorFailed(fmt::format("its landmark {} is not finite", point.id));
    require_covariance(point.covariance, fmt::format("its landmark {}", point.id));
  }
}

std::unique_ptr<Estimator> estimator_from(Step step) {
  return std::make_unique<FunctionEstimator>(std::move(step));
}

std::span<const std::string_view> estimator_names() { return kNames; }

std::unique_ptr<Estimator> make_estimator(const programs::Choice& choice, const Start& start) {
  if (choice.source == programs::Source::program) return std::make_unique<ProgramEstimator>(choice, start);
  if (choice.source == programs::Source::built_in && choice.name == kFilter)
    return std::make_unique<FilterEstimator>(start);
  if (choice.source == programs::Source::built_in && choice.name == kOdometry) return odometry(start);
  if (choice.source == programs::Source::built_in && choice.name == kPlanAlone)
    return estimator_from(plan_alone());
  throw std::invalid_argument(
      "estimator: was a command on an exported recording, which gaitslam evaluate runs; expected another "
      "estimator");
}

}  // namespace sim::estimators
