// Temporary sensor faults: the items of the scenario's list errors.faults.
#pragma once

#include <cmath>
#include <variant>

#include "slam/observation.h"

namespace sim::sensor_errors {

inline slam::Stamp stamp(double s) { return slam::Stamp(std::llround(s * 1e9)); }

/// The time of a fault: [from, from + duration) on the run's clock.
struct Span {
  double from_s = 0, duration_s = 1;
  bool operator==(const Span&) const = default;

  static void keys(auto&& key) {
    number<&Span::from_s>(key, 0, 1e6, "start of the fault, on the run's clock");
    number<&Span::duration_s>(key, 0, 1e6, "duration of the fault");
  }

  bool holds(slam::Stamp t) const { return t >= begin() && t < end(); }
  bool touches(const slam::InertialSample& reading) const {
    return reading.end > begin() && reading.begin < end();
  }

 private:
  slam::Stamp begin() const { return stamp(from_s); }
  slam::Stamp end() const { return stamp(from_s + duration_s); }
};

/// A fault of some of the frames, chosen by their stamps, or of a part of each picture.
template <class Fault>
struct FrameFault : Span {
  double fraction = 1;
  bool operator==(const FrameFault&) const = default;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&FrameFault::fraction>(key, 0, 1, Fault::kFraction);
  }
};
struct FramesLost : FrameFault<FramesLost> {  ///< no picture arrives
  static constexpr const char *kName = "frames_lost",
                              *kFraction = "fraction of the frames during the fault that lose their image";
};
struct FramesFrozen : Span {  ///< the last picture before it arrives again and again, with new stamps
  static constexpr const char* kName = "frames_frozen";
};
struct FramesDimmed : Span {  ///< less light (or more), before the noise
  static constexpr const char* kName = "frames_dimmed";
  double factor = 0.1;
  bool operator==(const FramesDimmed&) const = default;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&FramesDimmed::factor>(key, 0, 100, "factor on the light; above 1 the picture is overexposed");
  }
};
/// A poster in the middle of the picture that moves with the head.
struct FramesCovered : FrameFault<FramesCovered> {
  static constexpr const char *kName = "frames_covered",
                              *kFraction = "fraction of the picture that a poster fixed to the head covers";
  FramesCovered() { fraction = 0.3; }
};
struct FramesDoubled : FrameFault<FramesDoubled> {  ///< an observation arrives twice
  static constexpr const char *kName = "frames_doubled",
                              *kFraction = "fraction of the frames during the fault that arrive twice";
};
/// An observation arrives after the next one, unless it is already late or early.
struct FramesReordered : FrameFault<FramesReordered> {
  static constexpr const char *kName = "frames_reordered",
                              *kFraction =
                                  "fraction of the frames during the fault that arrive after the next one";
};
struct GyroSilent : Span {  ///< no readings arrive
  static constexpr const char* kName = "gyro_silent";
};
struct GyroSpike : Span {  ///< added to each axis of each reading that the span touches
  static constexpr const char* kName = "gyro_spike";
  GyroSpike() { duration_s = slam::kReadingPeriod_s; }
  double size_rad_s = 10;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&GyroSpike::size_rad_s>(key, -1e6, 1e6, "angular velocity added on each axis");
  }
};
struct GyroScaled : Span {  ///< each reading that the span touches is multiplied by `factor`
  static constexpr const char* kName = "gyro_scaled";
  double factor = 1.1;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&GyroScaled::factor>(key, -100, 100, "factor on the angular velocity");
  }
};
struct AccelerometerSilent : Span {  ///< no readings arrive
  static constexpr const char* kName = "accelerometer_silent";
};
struct AccelerometerSpike : Span {  ///< added to each axis of each reading that the span touches
  static constexpr const char* kName = "accelerometer_spike";
  AccelerometerSpike() { duration_s = slam::kReadingPeriod_s; }
  double size_m_s2 = 100;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&AccelerometerSpike::size_m_s2>(key, -1e6, 1e6, "acceleration added on each axis");
  }
};
struct PlanMissing : Span {  ///< no plan arrives
  static constexpr const char* kName = "plan_missing";
};
struct PlanScaled : Span {  ///< the planned motion is `factor` times the actual motion
  static constexpr const char* kName = "plan_scaled";
  double factor = 1.2;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&PlanScaled::factor>(key, -100, 100, "planned distance and velocity relative to the actual ones");
  }
};

// Faults of the estimate that steers a walk (walk.steering), not faults of the filter.
struct EstimateJump : Span {  ///< the estimate is displaced and turned, as after a wrong loop closure
  static constexpr const char* kName = "estimate_jump";
  double x_m = 0.3, y_m = 0, yaw_rad = 0;

  static void keys(auto&& key) {
    Span::keys(key);
    number<&EstimateJump::x_m>(key, -100, 100, "displacement of the steering estimate along x");
    number<&EstimateJump::y_m>(key, -100, 100, "displacement of the steering estimate along y");
    degrees<&EstimateJump::yaw_rad>(key, -180, 180, "turn of the steering estimate, to the left");
  }
};
struct EstimateFrozen : Span {  ///< the pose stays the same, with new stamps
  static constexpr const char* kName = "estimate_frozen";
};
struct EstimateLost : Span {  ///< no estimate
  static constexpr const char* kName = "estimate_lost";
};

using Fault =
    std::variant<FramesLost, FramesFrozen, FramesDimmed, FramesCovered, FramesDoubled, FramesReordered,
                 GyroSilent, GyroSpike, GyroScaled, AccelerometerSilent, AccelerometerSpike, PlanMissing,
                 PlanScaled, EstimateJump, EstimateFrozen, EstimateLost>;

/// Returns whether a fault affects the estimate that steers a walk.
inline bool is_of_steering(const Fault& fault) {
  return std::holds_alternative<EstimateJump>(fault) || std::holds_alternative<EstimateFrozen>(fault) ||
         std::holds_alternative<EstimateLost>(fault);
}

/// The faults of one kind, in their order.
template <class Kind>
std::vector<Kind> faults_of(const std::vector<Fault>& all) {
  std::vector<Kind> some;
  for (const Fault& fault : all)
    if (const Kind* const one = std::get_if<Kind>(&fault)) some.push_back(*one);
  return some;
}

}  // namespace sim::sensor_errors
