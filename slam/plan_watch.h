// Judges by the innovations of all sensors whether the plan's distances are those that are walked.
#pragma once

#include <string>

#include "slam/frame_report.h"
#include "slam/options.h"

namespace slam {

/// Tests the hypothesis that the planned distances are too long by a constant relative error δ from the start
/// on, against δ = 0 (Willsky & Jones 1976: generalised likelihood ratio). The filter carries ∂ν/∂δ of every
/// innovation ν with it; a plan that is wrong shows in them because accelerometer and gyro know the metre too.
class PlanWatch {
 public:
  explicit PlanWatch(const Options& options);

  /// Takes in what the innovations of a frame say.
  void take(const ScaleEvidence& evidence);

  /// Forgets all; the filter has a new pose.
  void reset() { sum_ = {}; }

  /// The signed square root of the likelihood ratio: the estimate of δ by its standard deviation, which is
  /// normal with variance 1 where the filter's models are exact. 0 without evidence, positive where the plan is
  /// too long.
  double sigmas() const;

  /// "plan: its distances are too long by 9 standard deviations of the innovations"; empty as long as the plan
  /// agrees with the other sensors.
  std::string suspect() const;

 private:
  double bound_;
  bool enabled_;
  ScaleEvidence sum_;
};

}  // namespace slam
