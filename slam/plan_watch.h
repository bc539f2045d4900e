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

  /// The estimate of δ, relative to the planned distances, and the standard deviation that it would have if the
  /// filter's models were exact. 0 and infinite without evidence.
  double error() const;
  double sigma() const;

  /// "plan: its distances are 18 % too long, ..."; empty as long as the plan agrees with the other sensors.
  std::string suspect() const;

 private:
  double least_error_;
  bool enabled_;
  ScaleEvidence sum_;
};

}  // namespace slam
