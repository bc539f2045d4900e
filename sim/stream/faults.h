// What goes wrong with the sensors for a while: the items of the scenario's list errors.faults.
#pragma once

#include <cmath>
#include <variant>
#include <vector>

#include "slam/observation.h"

namespace sim::stream {

/// While a fault lasts: [from, from + duration) on the run's clock.
struct Span {
  double from_s = 0, duration_s = 1;

  bool holds(slam::Stamp t) const { return t >= begin() && t < end(); }
  bool touches(const slam::InertialSample& reading) const {
    return reading.end > begin() && reading.begin < end();
  }

 private:
  static slam::Stamp stamp(double s) { return slam::Stamp(std::llround(s * 1e9)); }
  slam::Stamp begin() const { return stamp(from_s); }
  slam::Stamp end() const { return stamp(from_s + duration_s); }
};

struct FramesLost : Span {  ///< no picture arrives
  double fraction = 1;      ///< of the frames meanwhile
};
struct FramesFrozen : Span {};  ///< the last picture before arrives again and again, with new stamps
struct FramesDimmed : Span {    ///< less light (or more), before the noise
  double factor = 0.1;
};
struct FramesCovered : Span {  ///< a poster that moves with the head, in the middle of the picture
  double fraction = 0.3;       ///< of the picture's area
};
struct FramesDoubled : Span {  ///< an observation arrives twice
  double fraction = 1;         ///< of the observations meanwhile
};
struct FramesReordered : Span {  ///< an observation arrives after the next one
  double fraction = 1;           ///< of the observations meanwhile that do not already come late or early
};
struct GyroSilent : Span {};  ///< no readings arrive
struct GyroSpike : Span {     ///< added to each axis of each reading that the span touches
  GyroSpike() { duration_s = 0.005; }
  double size_rad_s = 10;
};
struct AccelerometerSilent : Span {};
struct AccelerometerSpike : Span {  ///< likewise
  AccelerometerSpike() { duration_s = 0.005; }
  double size_m_s2 = 100;
};
struct PlanMissing : Span {};  ///< no plan arrives
struct PlanScaled : Span {     ///< the planned way and velocity are longer by the factor than what is walked
  double factor = 1.2;
};

using Fault =
    std::variant<FramesLost, FramesFrozen, FramesDimmed, FramesCovered, FramesDoubled, FramesReordered,
                 GyroSilent, GyroSpike, AccelerometerSilent, AccelerometerSpike, PlanMissing, PlanScaled>;

/// The faults of one kind, in their order.
template <class Kind>
std::vector<Kind> faults_of(const std::vector<Fault>& all) {
  std::vector<Kind> some;
  for (const Fault& fault : all)
    if (const Kind* const one = std::get_if<Kind>(&fault)) some.push_back(*one);
  return some;
}

}  // namespace sim::stream
