#include "slam/internal_measurements.h"

#include <Eigen/Cholesky>
#include <utility>

#include "slam/eigen_kernels.h"

namespace slam {
namespace {

constexpr double kGate3 = 16.27;  // chi-square, 99.9 %, 3 rows
constexpr double kGate2 = 13.82;  // chi-square, 99.9 %, 2 rows
constexpr double kGate1 = 10.83;  // chi-square, 99.9 %, 1 row
// Bounds on the change between successive readings: twice the change in a stumble, and half the change in
// a 5 ms spike.
constexpr double kMostAngularAcceleration_rad_s2 = 1000, kMostJerk_m_s3 = 20000;

// A stumble takes some time, so leg odometry that was beyond its gate has less weight for a while.
constexpr double kLegDoubt_s = 0.5;
// Standard deviation of the legs' rotation rate in a frame. The heading drifts by 0.8 degrees in 3 s; the
// tilt varies as fast, but within 0.3 degrees.
constexpr double kLegRate_rad_s = 0.05;
constexpr double kStumbled_m = 0.1;  // standard deviation of the legs' height during a stumble
// Standard deviation of the legs' vertical velocity on a floor that is not level. Its errors add up from step
// to step, as the lasting error of the height does: without a plan, soles sink in as they land, by up to 5
// mm/s on average.
constexpr double kVertical_m_s = 0.03, kPlannedVertical_m_s = 0.01;
// At least the standard deviation of the planned height in a frame: legs yield in each step.
constexpr double kPlannedHeight_m = 0.001;
// At least the standard deviation of the legs' velocity on such a floor: a center of pressure moves as the
// sole rolls over edges and bumps.
constexpr double kUneven_m_s = 0.01;

// On such a floor, the body tilts with the slope, which moves the camera: two planned steps differ from those
// by leg odometry by about 30 mm instead of 5 mm.
constexpr double kUnevenSteps = 5.0 * 5.0 / (30.0 * 30.0);

SystematicEvidence weighted(const SystematicEvidence& evidence) {
  return {kUnevenSteps * evidence.score, kUnevenSteps * evidence.information};
}

/// The inputs from which the sensors' measurements of one frame are computed.
struct Inputs {
  const RobotVector& x;
  const Observation& observation;
  const InertialInterval& inertial;
  const std::optional<PlannedInterval>& planned;
  bool at_rest;  // the plan has not moved yet
  const Options& options;
  bool gyro_drives;  // the gyro drives the prediction and is not a measurement
  double leg_doubt;  // factor on the variance of leg odometry
  bool level;        // the floor
};

using OptionalMeasurement = std::optional<Measurement>;

OptionalMeasurement gyro(const Inputs& in) {
  if (!in.options.gyro.enabled || in.gyro_drives) return std::nullopt;
  const auto rate = mean_rate(in.inertial, in.options);
  return rate ? OptionalMeasurement(measure_rate(in.x, *rate)) : std::nullopt;
}

OptionalMeasurement rest(const Inputs& in) {
  const double sigma = in.options.start.sigma_rest_rad_s;
  if (!in.options.gyro.enabled || !(sigma > 0) || !in.planned || !in.at_rest) return std::nullopt;
  return measure_rate(in.x, {Eigen::Vector3d::Zero(), sigma}, false);
}

/// Without the gyro, the legs measure the rotation.
OptionalMeasurement leg_rate(const Inputs& in) {
  const bool has_gyro = in.options.gyro.enabled && !in.observation.gyro.empty();
  if (has_gyro || !in.options.plan_velocity.enabled || !in.planned || !in.planned->legs) return std::nullopt;
  return measure_rate(in.x, {in.planned->legs->rate, kLegRate_rad_s}, false);
}

OptionalMeasurement leg_velocity(const Inputs& in) {
  if (!in.options.plan_velocity.enabled || !in.planned || !in.planned->legs) return std::nullopt;
  PlannedVelocity legs = *in.planned->legs;
  if (!in.level) legs.sigma_m_s = std::max(legs.sigma_m_s, kUneven_m_s);
  Measurement m = measure_velocity(in.x, legs, in.options.plan_velocity, kLegScale);
  m.R *= in.leg_doubt;
  const Eigen::Vector3d up_C = rotation_matrix(in.x.segment<4>(kOrientation)).row(2);
  const double vertical = in.planned->plan ? kPlannedVertical_m_s : kVertical_m_s;
  if (!in.level) m.R += vertical * vertical * up_C * up_C.transpose();
  if (!in.planned->steady) m.sensitivity.setZero();
  return m;
}

OptionalMeasurement plan_velocity(const Inputs& in) {
  if (!in.options.plan_velocity.enabled || !in.planned || in.planned->legs || !in.planned->plan)
    return std::nullopt;
  return measure_velocity(in.x, *in.planned->plan, in.options.plan_velocity);
}

OptionalMeasurement commanded_velocity(const Inputs& in) {
  if (!in.planned || !in.planned->command) return std::nullopt;
  return measure_command(in.x, *in.planned->command, in.options.command);
}

OptionalMeasurement height(const Inputs& in) {
  const std::optional<PlannedMotion>& plan = in.observation.plan;
  const std::optional<LegMotion>& legs = in.observation.legs;
  const bool by_legs = in.options.leg_odometry.enabled && legs;
  if (!in.options.height.enabled || !(by_legs || (plan && in.level))) return std::nullopt;
  Options::Height options = in.options.height;
  if (!by_legs) options.sigma_m = std::max(options.sigma_m, kPlannedHeight_m);
  return measure_height(in.x, (by_legs ? legs->X_OC : plan->X_PC).translation().z(), options);
}

/// A sensor: its measurement, if there is one, its gate, its index in reports, and the reason for a
/// rejection.
struct Sensor {
  OptionalMeasurement (*measure)(const Inputs&);
  double gate;
  std::optional<SensorIndex> index;  // nothing: not reported
  const char* reason;
};

constexpr std::array kSensors{
    Sensor{gyro, kGate3, SensorIndex::gyro, "gyro is beyond its gate"},
    Sensor{rest, kGate3, std::nullopt, "the rate at rest is beyond its gate"},
    Sensor{leg_rate, kGate3, std::nullopt, "the legs' rotation is beyond its gate"},
    Sensor{leg_velocity, kGate3, SensorIndex::plan_velocity, "leg odometry is beyond its gate"},
    Sensor{plan_velocity, kGate3, SensorIndex::plan_velocity, "planned velocity is beyond its gate"},
    Sensor{commanded_velocity, kGate2, SensorIndex::plan_velocity, "commanded velocity is beyond its gate"},
    Sensor{height, kGate1, SensorIndex::height, "height is beyond its gate"}};

bool agrees(const OptionalMeasurement& m, const Prediction& prediction, const State& state) {
  if (!m) return true;
  const Measurement::Small<3, kRobot> HF = m->H_robot * prediction.F;
  const Eigen::Matrix3d S = HF * state.marginal<kRobot>(0) * HF.transpose() +
                            m->H_robot * prediction.Q * m->H_robot.transpose() + m->R;
  return S.llt().matrixL().solve(m->innovation).squaredNorm() < kGate3;
}

/// Returns whether the readings follow `last` and each other without a gap or a jump. If so, they show a real
/// motion, even a very fast one.
bool adjoin(std::optional<InertialSample> last, const std::vector<InertialSample>& readings,
            double most_per_s) {
  for (const InertialSample& next : readings) {
    if (!last || next.begin != last->end ||
        (next.value - last->value).norm() > most_per_s * seconds(next.end - last->begin) / 2)
      return false;
    last = next;
  }
  return !readings.empty();
}

}  // namespace

InternalMeasurements::InternalMeasurements(const Options& options, const Calibration& calibration)
    : options_(options),
      leg_options_(with_leg_odometry(options)),
      floor_options_(with_leg_odometry(on_any_floor(options))),
      command_options_(with_command(options)),
      X_CG_(calibration.X_CG),
      level_(calibration.level_floor) {}

/// Returns the gyro's rate if it should drive the prediction and either the motion model allows the change of
/// rate or the readings continue the ones that drove the last prediction.
std::optional<MeanRate> InternalMeasurements::driving_rate(const RobotVector& x) const {
  if (!options_.gyro.enabled || !options_.gyro.drives_motion) return std::nullopt;
  const auto rate = mean_rate(later_, options_);
  if (!rate) return std::nullopt;
  const Eigen::Vector3d change = rate->w_C - x.segment<3>(kGyroBias) - x.segment<3>(kRate);
  const double sigma = options_.motion.sigma_angular_acceleration_rad_s2 * seconds(later_.to - later_.from);
  const bool continues = adjoin(last_rate_, later_.gyro, kMostAngularAcceleration_rad_s2);
  return continues || change.squaredNorm() < kGate3 * sigma * sigma ? rate : std::nullopt;
}

double InternalMeasurements::turn_difference(const RobotVector& x,
                                             const std::optional<PlannedInterval>& planned,
                                             double dt_s) const {
  const auto rate = mean_rate(later_, options_);
  if (!rate || !planned || !planned->legs) return 0;
  const Eigen::Vector3d up_C = rotation_matrix(x.segment<4>(kOrientation)).row(2);
  return dt_s * up_C.dot(rate->w_C - x.segment<3>(kGyroBias) - planned->legs->rate);
}

Prediction InternalMeasurements::predict(const Observation& o, Stamp previous,
                                         const std::optional<PlannedInterval>& planned, const State& state,
                                         FrameReport& report) {
  const double dt = seconds(o.t - previous);
  const RobotVector x = state.robot();
  const Options& options = planned && planned->legs      ? (level_ ? leg_options_ : floor_options_)
                           : planned && planned->command ? command_options_
                                                         : options_;
  if (options_.accelerometer.enabled && !o.accelerometer.empty())
    report.note(SensorIndex::accelerometer, SensorUse::readings);
  const std::optional<InertialSample> last_force = std::exchange(last_force_, std::nullopt);
  std::swap(earlier_, later_);
  later_.from = previous, later_.to = o.t;
  later_.gyro = o.gyro, later_.accelerometer = o.accelerometer;
  later_.X_CG_to = X_CG_by_encoders_.value_or(X_CG_);
  if (options_.leg_odometry.enabled && o.legs && o.legs->X_CG) later_.X_CG_to = *o.legs->X_CG;
  later_.X_CG_from = X_CG_by_encoders_.value_or(later_.X_CG_to);
  if (options_.leg_odometry.enabled && o.legs) X_CG_by_encoders_ = later_.X_CG_to;
  gyro_rate_ = driving_rate(x);
  last_rate_ = gyro_rate_ ? std::optional(o.gyro.back()) : std::nullopt;
  const auto increment = velocity_increment(earlier_, later_, x.segment<3>(kGyroBias), options_);
  const auto predicted = [&](const std::optional<VelocityIncrement>& by) {
    Prediction prediction = predict_motion(x, dt, by, options, gyro_rate_);
    if (stumbled_) prediction.Q(kHeightError, kHeightError) += kStumbled_m * kStumbled_m;
    return prediction;
  };
  if (increment && options_.accelerometer.enabled) {
    const Prediction prediction = predicted(increment);
    const Eigen::Vector3d V = prediction.x.segment<3>(kVelocity) - x.segment<3>(kVelocity);
    const double sigma = options.motion.sigma_acceleration_m_s2 * dt;
    const Inputs in{prediction.x, o, later_, planned, plan_.at_rest(), options_, true, leg_doubt_, level_};
    const auto velocity = !level_                    ? std::nullopt
                          : planned && planned->legs ? leg_velocity(in)
                                                     : plan_velocity(in);
    const bool continues = adjoin(last_force, o.accelerometer, kMostJerk_m_s3);
    if ((continues || V.squaredNorm() < kGate3 * sigma * sigma) && agrees(velocity, prediction, state)) {
      last_force_ = o.accelerometer.back();
      report.note(SensorIndex::accelerometer, SensorUse::accepted);
      return prediction;
    }
    report.refused.add("accelerometer is beyond its gate");
  }
  return predicted(std::nullopt);
}

bool InternalMeasurements::update(const Observation& o, Stamp previous,
                                  const std::optional<PlannedInterval>& planned, Kalman& kalman,
                                  FrameReport& report) {
  accepted_.clear();
  stumbled_ = false;
  leg_doubt_ = 1 + (leg_doubt_ - 1) * std::exp(-seconds(o.t - previous) / kLegDoubt_s);
  if (options_.gyro.enabled && o.gyro.empty()) report.refused.add("the gyro is silent");
  if (options_.gyro.enabled && !o.gyro.empty())
    report.note(SensorIndex::gyro, gyro_rate_ ? SensorUse::accepted : SensorUse::readings);
  const RobotVector x = kalman.state().robot();
  static_assert(kSensors.size() == std::tuple_size_v<decltype(whitened_)>);
  for (const Sensor& sensor : kSensors) {
    auto m = sensor.measure(
        {x, o, later_, planned, plan_.at_rest(), options_, gyro_rate_.has_value(), leg_doubt_, level_});
    std::optional<Eigen::Vector3d>& whitened = whitened_[static_cast<std::size_t>(&sensor - kSensors.data())];
    if (!m) {
      whitened.reset();
      continue;
    }
    kalman.constrain(*m);
    const Nis nis = normalized_innovation_squared(kalman.state(), *m, &whitened);
    const bool accepted = nis.value < sensor.gate;
    if (sensor.measure == leg_velocity && !accepted) leg_doubt_ *= nis.value / sensor.gate;
    if (sensor.measure == height) stumbled_ = !accepted && !level_;
    if (sensor.index) {
      report.innovations.push_back({kSensorNames[static_cast<std::size_t>(*sensor.index)], nis});
      report.note(*sensor.index, accepted ? SensorUse::accepted : SensorUse::readings);
    }
    if (accepted)
      accepted_.push_back(*m);
    else
      report.refused.add(sensor.reason);
  }
  if (options_.plan_velocity.enabled && planned && planned->legs)
    kalman.add_evidence(kPlanScale, level_ ? planned->plan_scale : weighted(planned->plan_scale));
  if (accepted_.empty()) return true;
  stack(kalman.state(), accepted_, stacked_);
  return kalman.update(stacked_);
}

}  // namespace slam
