// Tests the sensors against their models: the distances of plan and leg odometry, the gyro's noise, and the
// images.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "slam/frame_report.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

/// Tests a constant systematic error δ from the start against δ = 0 (Willsky & Jones 1976: generalized
/// likelihood ratio). The filter keeps ∂ν/∂δ of every innovation ν. Evidence is forgotten with a time
/// constant of 30 s, and an error of up to 2 % is ordinary: otherwise the small error of every plan would
/// become certain on a long walk.
class SystematicErrorTest {
 public:
  /// dt_s: the interval since the previous evidence.
  void add(const SystematicEvidence& evidence, double dt_s);

  /// The distance of the estimate of δ from ±2 % in its standard deviations, with the sign of δ; 0 within ±2
  /// % and without evidence.
  double sigmas() const;

 private:
  SystematicEvidence sum_;
};

/// Compares the scatter of successive gyro readings with the assumed noise. Second differences of readings 5
/// ms apart are almost independent of the motion, and their median is independent of impacts.
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

/// Compares the number of landmarks found again with that predicted. Images of another place or another
/// motion give ever new landmarks that are not found again, and tracking is lost repeatedly or for long
/// although the images are good.
class ImageTest {
 public:
  /// Adds whether tracking is lost after a frame. A loss counts if it started with a good image: one that was
  /// not missing, flat or frozen.
  void add_health(double dt_s, bool lost, bool good_image);

  /// Adds the numbers of landmarks of a frame that were searched for, accepted, and deleted as unreliable
  /// soon after their first sight.
  void add(double dt_s, std::size_t searched, std::size_t accepted, std::size_t unreliable);

  bool fails() const;

 private:
  double searched_ = 0, accepted_ = 0, unreliable_ = 0;  // older ones weigh less
  bool lost_ = false, loss_counts_ = false;
  double losses_ = 0;  // older ones weigh less; one more for every two seconds of a loss
};

class SensorMonitor {
 public:
  explicit SensorMonitor(const Options& options) : options_(options), gyro_(options.gyro) {}

  void add(const Evidence& evidence, double dt_s);
  GyroNoiseTest& gyro() { return gyro_; }
  ImageTest& images() { return images_; }

  /// Forgets the evidence of the innovations, after a new pose.
  void reset();

  /// See SystematicErrorTest::sigmas.
  double sigmas(int error) const { return systematic_[static_cast<std::size_t>(error)].sigmas(); }

  /// "inconsistent: plan, its distances are too long by 9 standard deviations" or the like; empty if all is
  /// consistent. The gyro comes first and the plan last, because the evidence against the plan depends on the
  /// others.
  std::string suspect() const;

 private:
  Options options_;
  std::array<SystematicErrorTest, kSystematicErrors> systematic_;
  GyroNoiseTest gyro_;
  ImageTest images_;
};

}  // namespace slam
