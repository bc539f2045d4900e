// Judges whether the filter tracks: by what the images show, how many landmarks are found, and the innovations.
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
  /// True if tracking is lost because nothing was seen: the pose is then still the one predicted, with its
  /// honest uncertainty, and not in contradiction to the images.
  bool is_blind() const { return health_ == Health::lost && blind_loss_; }

  /// Takes in a frame, after which tracking may be lost. Does nothing if the health is not ok.
  void judge(const TrackingStatistics& statistics);
  /// Takes in a frame interval in which nothing was seen that the filter could use, and why. After lost_after_s
  /// of such intervals without sees() in between, tracking is lost.
  void blind(Stamp interval, const std::string& why);
  /// An observation was refused whole, and why. Its stamp may not tell how much time has passed; if no
  /// observation is accepted meanwhile, each stands for one interval, and tracking is lost after lost_after_s
  /// of them and the filter has diverged after give_up_s more.
  void refuses(Stamp interval, const std::string& why);
  /// An observation was accepted: its stamp tells how much time has passed since the last one.
  void accepts() { refused_ = Stamp(0); }
  /// Something was seen: ends a loss for want of it.
  void sees();
  /// The filter is broken. The first cause is kept.
  void diverge(const std::string& cause);
  /// The map was recognised: the health is ok, and all earlier frames are forgotten.
  void relocalised() { *this = TrackingWatch(options_); }
  /// For how long tracking has been lost.
  Stamp lost_for() const { return health_ == Health::ok ? Stamp(0) : lost_; }
  /// A filter that was lost before this frame interval is lost after it; after give_up_s it has diverged.
  void remains_lost(Stamp interval);

 private:
  /// The mean of the last 15 values of a NIS.
  struct MovingMean {
    static constexpr std::size_t kWindow = 15;
    std::array<double, kWindow> values{};
    std::size_t count = 0;
    bool exceeds(const std::optional<double>& value, double bound);
  };

  std::string loss(const TrackingStatistics& statistics);
  void lose(const std::string& why);

  Options::Tracking options_;
  Health health_ = Health::ok;
  std::string cause_;
  double failing_s_ = 0;
  Stamp blind_{0}, refused_{0}, lost_{0};  // for how long
  bool blind_loss_ = false;
  MovingMean vision_, height_;
};

}  // namespace slam
