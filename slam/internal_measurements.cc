#include "slam/internal_measurements.h"

#include <Eigen/Cholesky>
#include <utility>

#include "slam/gyro.h"

namespace slam {
namespace {

constexpr double kGate3 = 16.27;  // chi-square, 99.9 %, 3 rows
constexpr double kGate1 = 10.83;  // chi-square, 99.9 %, 1 row

}  // namespace

std::optional<VelocityIncrement> InternalMeasurements::integrate_accelerometer(const Observation& o,
                                                                               Stamp previous,
                                                                               const State& state) {
  if (!options_.accelerometer.enabled) return std::nullopt;
  std::swap(earlier_, later_);
  later_.from = previous, later_.to = o.t;
  later_.gyro = o.gyro, later_.accelerometer = o.accelerometer;
  return velocity_increment(earlier_, later_, X_CG_, state.robot().segment<3>(kGyroBias), options_);
}

Measurement InternalMeasurements::measured_velocity(const RobotVector& x,
                                                    const PlannedVelocity& planned) const {
  return planned.legs ? measure_leg_velocity(x, planned, by_legs_.plan_velocity)
                      : measure_velocity(x, planned, options_.plan_velocity);
}

bool InternalMeasurements::agrees_with_plan(const Prediction& prediction, const State& state,
                                            const std::optional<PlannedVelocity>& planned) const {
  if (!options_.plan_velocity.enabled || !planned) return true;
  const Measurement m = measured_velocity(prediction.x, *planned);
  const RobotMatrix P = prediction.F * state.marginal<kRobot>(0) * prediction.F.transpose() + prediction.Q;
  const Eigen::Matrix3d S = m.H_robot * P * m.H_robot.transpose() + m.R;
  return S.llt().matrixL().solve(m.innovation).squaredNorm() < kGate3;
}

GatedPrediction InternalMeasurements::predict(const Observation& o, Stamp previous,
                                              const std::optional<PlannedVelocity>& planned,
                                              const State& state) {
  const double dt = seconds(o.t - previous);
  const RobotVector x = state.robot();
  const auto increment = integrate_accelerometer(o, previous, state);
  if (increment) {
    GatedPrediction gated{predict_motion(x, dt, increment, options(planned))};
    const Eigen::Vector3d V = gated.prediction.x.segment<3>(kVelocity) - x.segment<3>(kVelocity);
    const double sigma = options_.motion.sigma_acceleration_m_s2 * dt;
    if (V.squaredNorm() < kGate3 * sigma * sigma && agrees_with_plan(gated.prediction, state, planned))
      return gated;
  }
  return {predict_motion(x, dt, std::nullopt, options(planned)), increment.has_value()};
}

InternalResult InternalMeasurements::update(const Observation& o, Stamp previous,
                                            const std::optional<PlannedVelocity>& planned, Kalman& kalman) {
  InternalResult result;
  const RobotVector x = kalman.state().robot();
  accepted_.clear();
  const auto gate = [&](Measurement m, double bound, const char* name) {
    kalman.constrain(m);
    const Nis nis = normalised_innovation_squared(kalman.state(), m);
    if (nis.value < bound)
      accepted_.push_back(m);
    else
      add_reason(result.rejected, std::string(name) + " is beyond its gate");
    return nis;
  };
  if (options_.gyro.enabled && o.gyro.empty()) add_reason(result.rejected, "the gyro is silent");
  if (options_.gyro.enabled)
    if (const auto rate = mean_rate(o.gyro, previous, o.t, X_CG_.linear(), options_))
      result.gyro = gate(measure_rate(x, *rate), kGate3, "gyro");
  if (options_.gyro.enabled && options_.start.sigma_rest_rad_s > 0 && planned && plan_.at_rest())
    gate(measure_rest(x, options_.start.sigma_rest_rad_s), kGate3, "rest");
  if (options_.plan_velocity.enabled && planned)
    result.plan_velocity =
        gate(measured_velocity(x, *planned), kGate3, planned->legs ? "leg odometry" : "planned velocity");
  if (options_.plan_velocity.enabled && planned && planned->legs)
    kalman.add_evidence(kPlanScale, planned->legs->plan_scale);
  if (o.plan) {
    const Eigen::Isometry3d& X_PC = o.plan->X_PC;
    if (options_.height.enabled)
      result.height =
          gate(measure_height(x, X_PC.translation().z(), options_.height), kGate1, "planned height");
    if (options_.plan_orientation.enabled)
      gate(measure_orientation(x, X_PC.linear(), options_.plan_orientation), kGate3, "planned orientation");
    if (options_.plan_position.enabled)
      gate(measure_position(x, X_PC.translation(), options_.plan_position), kGate3, "planned position");
  }
  if (accepted_.empty()) return result;
  stack(kalman.state(), accepted_, stacked_);
  result.updated = kalman.update(stacked_);
  return result;
}

}  // namespace slam
