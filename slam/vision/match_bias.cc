#include "slam/vision/match_bias.h"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr int kSparePlaces = 6;  // of landmarks in view that are not measured in this frame
constexpr int kMostPlaces = 40;
constexpr int kFree = -1;

int index_of_place(std::size_t place) { return kRobot + 2 * static_cast<int>(place); }

}  // namespace

int MatchBiases::places(const Options::Vision& options, const Options::Bounds& bounds) {
  if (!options.enabled || !(options.match_bias_sigma_px > 0)) return 0;
  return std::min(std::min(options.measured_landmarks, bounds.measured) + kSparePlaces, kMostPlaces);
}

MatchBiases::MatchBiases(const Options::Vision& options, const Options::Bounds& bounds)
    : options_(options), landmark_of_(static_cast<std::size_t>(places(options, bounds)), kFree) {}

void MatchBiases::predict(double dt_s, Kalman& kalman) const {
  const double decay = std::exp(-dt_s / options_.match_bias_s);
  for (std::size_t place = 0; place < landmark_of_.size(); ++place)
    if (landmark_of_[place] != kFree)
      kalman.predict_match_bias(index_of_place(place), decay, variance() * (1 - decay * decay));
}

void MatchBiases::keep_visible(const std::vector<std::size_t>& visible,
                               const std::vector<Landmark>& landmarks, Kalman& kalman) {
  for (std::size_t place = 0; place < landmark_of_.size(); ++place) {
    if (landmark_of_[place] == kFree) continue;
    const bool seen = std::any_of(visible.begin(), visible.end(),
                                  [&](std::size_t i) { return landmarks[i].id == landmark_of_[place]; });
    if (seen) continue;
    kalman.predict_match_bias(index_of_place(place), 0, 0);
    landmark_of_[place] = kFree;
  }
}

int MatchBiases::at(int landmark) const {
  const auto found = std::find(landmark_of_.begin(), landmark_of_.end(), landmark);
  return found == landmark_of_.end() ? -1
                                     : index_of_place(static_cast<std::size_t>(found - landmark_of_.begin()));
}

int MatchBiases::add(int landmark, bool first_sight, Kalman& kalman) {
  const auto free = std::find(landmark_of_.begin(), landmark_of_.end(), kFree);
  if (free == landmark_of_.end()) return -1;
  *free = landmark;
  const int index = index_of_place(static_cast<std::size_t>(free - landmark_of_.begin()));
  kalman.predict_match_bias(index, 0, first_sight ? 0 : variance());
  return index;
}

void MatchBiases::clear(Kalman& kalman) {
  for (std::size_t place = 0; place < landmark_of_.size(); ++place)
    kalman.predict_match_bias(index_of_place(place), 0, 0);
  std::fill(landmark_of_.begin(), landmark_of_.end(), kFree);
}

}  // namespace slam
