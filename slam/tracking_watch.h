// Judges whether the filter tracks: by how many landmarks are found and by the innovations.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "slam/frame_report.h"
#include "slam/options.h"

namespace slam {

/// The tracking statistics of one frame.
struct TrackingStatistics {
  double dt_s = 0;
  std::size_t searched = 0, accepted = 0;        ///< landmarks
  double coverage = 1;                           ///< fraction of the image that those searched for span
  std::optional<double> vision_nis, height_nis;  ///< per degree of freedom; absent without a measurement
};

/// True if almost none of the landmarks that were searched for all over the image is found. If they span only
/// a part of it, the rest of the image may be occluded, and this is false.
bool matching_failed(const TrackingStatistics& statistics);

/// The health of the filter over time.
class TrackingWatch {
 public:
  explicit TrackingWatch(const Options::Tracking& options) : options_(options) {}

  Health health() const { return health_; }
  const std::string& cause() const { return cause_; }
  /// True if matching failed in the last frame.
  bool in_doubt() const { return failing_s_ > 0; }

  /// Takes in a frame, after which tracking may be lost. Does nothing if the health is not ok.
  void judge(const TrackingStatistics& statistics);
  /// The filter is broken. The first cause is kept.
  void diverge(const std::string& cause);
  /// The map was recognised: the health is ok, and all earlier frames are forgotten.
  void relocalised() { *this = TrackingWatch(options_); }
  /// The map was not recognised in an image dt_s after the previous one; after give_up_s of such images the
  /// filter has diverged.
  void relocalisation_failed(double dt_s);

 private:
  /// The mean of the last 15 values of a NIS.
  struct MovingMean {
    static constexpr std::size_t kWindow = 15;
    std::array<double, kWindow> values{};
    std::size_t count = 0;
    bool exceeds(const std::optional<double>& value, double bound);
  };

  std::string loss(const TrackingStatistics& statistics);

  Options::Tracking options_;
  Health health_ = Health::ok;
  std::string cause_;
  double failing_s_ = 0, lost_s_ = 0;
  MovingMean vision_, height_;
};

}  // namespace slam
