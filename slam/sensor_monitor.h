// Judges whether the sensors are what the filter is told of them: the distances of plan and leg odometry, the
// gyro's noise, and the images.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "slam/frame_report.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

/// Tests the hypothesis of a constant systematic error δ from the start on against δ = 0 (Willsky & Jones
/// 1976: generalized likelihood ratio). The filter carries ∂ν/∂δ of every innovation ν with it. Evidence is
/// forgotten with a time constant of 30 s, and an error of up to 2 % is ordinary: the small one that every
/// plan has would otherwise become certain on a long walk.
class SystematicErrorTest {
 public:
  /// dt_s: the interval since the evidence before.
  void add(const SystematicEvidence& evidence, double dt_s);

  /// By how many of its standard deviations the estimate of δ is beyond ±2 %, with the sign of δ; 0 if it is
  /// not, and without evidence.
  double sigmas() const;

 private:
  SystematicEvidence sum_;
};

/// Compares the scatter of successive gyro readings with the noise that the filter assumes. Second
/// differences of readings 5 ms apart hardly know of the motion, and the part of them beyond a threshold
/// nothing of its impacts.
class GyroNoiseTest {
 public:
  explicit GyroNoiseTest(const Options::Gyro& options) : options_(options) {}

  void add(const std::vector<InertialSample>& readings);

  /// True if the median of the last seconds' second differences is more than 1.5 times what the noise would
  /// give.
  bool scatters() const;

 private:
  Options::Gyro options_;
  InertialSample last_, before_;
  double count_ = 0, beyond_ = 0;  // of second differences, older ones weighing less
};

/// Compares how many landmarks are found again with how many should be. Images of another place or of another
/// motion than the other sensors' give ever new landmarks, which are not found where they should be, and
/// tracking is lost again and again or for long, although the images are good.
class ImageTest {
 public:
  /// Takes in whether tracking is lost after a frame. A loss counts if it began with a good image: one that
  /// was not missing, flat or frozen.
  void add_health(double dt_s, bool lost, bool good_image);

  /// Takes in the landmarks that were searched for, accepted, and deleted soon after their first sight
  /// because they were not found, in a frame interval.
  void add(double dt_s, std::size_t searched, std::size_t accepted, std::size_t unreliable);

  bool fails() const;

 private:
  double searched_ = 0, accepted_ = 0, unreliable_ = 0;  // older ones weigh less
  bool lost_ = false, loss_counts_ = false;
  double losses_ =
      0;  // older ones weigh less; one more for every two seconds for which tracking remains lost
};

class SensorMonitor {
 public:
  explicit SensorMonitor(const Options& options) : options_(options), gyro_(options.gyro) {}

  void add(const Evidence& evidence, double dt_s);
  GyroNoiseTest& gyro() { return gyro_; }
  ImageTest& images() { return images_; }

  /// Forgets what the innovations said; the filter has a new pose.
  void reset();

  /// Of a systematic error, see SystematicErrorTest::sigmas.
  double sigmas(int error) const { return systematic_[static_cast<std::size_t>(error)].sigmas(); }

  /// "inconsistent: plan, its distances are too long by 9 standard deviations" or the like; empty as
  /// long as all is consistent. What is wrong with the gyro is said first and what is wrong with the plan
  /// last, because the evidence for the latter needs the others.
  std::string suspect() const;

 private:
  Options options_;
  std::array<SystematicErrorTest, kSystematicErrors> systematic_;
  GyroNoiseTest gyro_;
  ImageTest images_;
};

}  // namespace slam
