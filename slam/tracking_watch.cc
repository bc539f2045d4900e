#include "slam/tracking_watch.h"

#include <numeric>

namespace slam {
namespace {

constexpr double kLeastFound = 0.2;        // fraction of the landmarks searched for
constexpr double kLeastCoverage = 0.4;     // fraction of the image
constexpr std::size_t kLeastSearched = 5;  // landmarks
constexpr const char* kNotFoundAgain = "; the map was not found again";

}  // namespace

bool matching_failed(const TrackingStatistics& s) {
  return s.searched >= kLeastSearched && s.coverage > kLeastCoverage &&
         static_cast<double>(s.accepted) < kLeastFound * static_cast<double>(s.searched);
}

/// Takes in a value, if there is one; true if the window is full and its mean exceeds the bound.
bool TrackingWatch::MovingMean::exceeds(const std::optional<double>& value, double bound) {
  if (!value) return false;
  values[count++ % kWindow] = *value;
  return count >= kWindow && std::accumulate(values.begin(), values.end(), 0.0) > bound * kWindow;
}

/// Why tracking is lost with this frame; empty if it is not.
std::string TrackingWatch::loss(const TrackingStatistics& s) {
  failing_s_ = matching_failed(s) ? failing_s_ + s.dt_s : 0;
  const bool vision = vision_.exceeds(s.vision_nis, options_.vision_bound);
  const bool height = height_.exceeds(s.height_nis, options_.height_bound);
  if (failing_s_ > options_.lost_after_s) return "almost no landmark found";
  if (vision) return "matches are further from where they should be than the filter believes possible";
  if (height) return "the height is further from the planned one than the filter believes possible";
  return "";
}

void TrackingWatch::judge(const TrackingStatistics& statistics) {
  if (health_ != Health::ok) return;
  const std::string why = loss(statistics);
  if (!why.empty()) lose(why);
}

void TrackingWatch::lose(const std::string& why) {
  if (!options_.relocalise) return diverge("tracking lost: " + why);
  health_ = Health::lost;
  cause_ = "tracking lost: " + why;
  refused_ = lost_ = Stamp(0);
  blind_loss_ = false;
}

void TrackingWatch::blind(Stamp interval, const std::string& why) {
  blind_ += interval;
  if (health_ != Health::ok || !(seconds(blind_) > options_.lost_after_s)) return;
  lose(why);
  blind_loss_ = true;
}

void TrackingWatch::refuses(Stamp interval, const std::string& why) {
  refused_ += interval;
  if (health_ == Health::lost && seconds(refused_) > options_.give_up_s)
    return diverge(cause_ + kNotFoundAgain);
  if (health_ != Health::ok || !(seconds(refused_) > options_.lost_after_s)) return;
  lose("observations are refused because " + why);
  blind_loss_ = true;
}

void TrackingWatch::sees() {
  blind_ = Stamp(0);
  if (!is_blind()) return;
  health_ = Health::ok;
  cause_.clear();
}

void TrackingWatch::diverge(const std::string& cause) {
  if (health_ == Health::diverged) return;
  health_ = Health::diverged;
  cause_ = cause;
}

void TrackingWatch::remains_lost(Stamp interval) {
  if (health_ != Health::lost) return;
  lost_ += interval;
  if (seconds(lost_) > options_.give_up_s) diverge(cause_ + kNotFoundAgain);
}

}  // namespace slam
