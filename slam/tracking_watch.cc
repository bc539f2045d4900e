#include "slam/tracking_watch.h"

#include <numeric>

namespace slam {
namespace {

constexpr double kFewFound = 0.2;          // of the landmarks searched for
constexpr double kAllOver = 0.4;           // part of the image
constexpr std::size_t kEnoughToJudge = 5;  // landmarks searched for

}  // namespace

bool blind(const Glance& glance) {
  return glance.searched >= kEnoughToJudge && glance.spread > kAllOver &&
         static_cast<double>(glance.accepted) < kFewFound * static_cast<double>(glance.searched);
}

/// Whether the window is full and its mean, with the value taken in, is beyond the bound.
bool TrackingWatch::Mean::beyond(const std::optional<double>& value, double bound) {
  if (!value) return false;
  values[count++ % kWindow] = *value;
  return count >= kWindow && std::accumulate(values.begin(), values.end(), 0.0) > bound * kWindow;
}

std::string TrackingWatch::judge(const Glance& glance) {
  blind_s_ = blind(glance) ? blind_s_ + glance.dt_s : 0;
  const bool vision = vision_.beyond(glance.vision_nis, options_.vision_bound);
  const bool height = height_.beyond(glance.height_nis, options_.height_bound);
  if (blind_s_ > options_.lost_after_s) return "almost no landmark found";
  if (vision) return "matches are further from where they should be than the filter believes possible";
  if (height) return "the height is further from the planned one than the filter believes possible";
  return "";
}

}  // namespace slam
