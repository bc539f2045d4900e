// The errors of matches that last over frames: of which landmarks they are states of the filter, and how they
// are predicted.
#pragma once

#include <vector>

#include "slam/kalman.h"
#include "slam/options.h"
#include "slam/vision/active_search.h"
#include "slam/vision/landmark.h"

namespace slam {

/// A template is not quite what the camera sees of the landmark from another place: where it is found, is off
/// by an error that hardly changes from frame to frame. As white noise, the same error would count as new
/// information in each frame. It is a Gauss-Markov process in the state, two parameters for each landmark in
/// view, in units of Camera::sigma(pixel, 1), from the landmark's first sight on, when it is zero by
/// definition. Landmarks in view share a fixed number of places in the state.
class MatchBiases {
 public:
  MatchBiases(const Options::Vision& options, const Options::Bounds& bounds);

  /// The number of places, for which the state must have room: 0 if the options have no lasting error.
  static int places(const Options::Vision& options, const Options::Bounds& bounds);

  /// Predicts the errors over a frame interval.
  void predict(double dt_s, Kalman& kalman) const;

  /// Gives free the places of landmarks that are not among the `visible` ones (indices of the list of
  /// landmarks).
  void keep_visible(const std::vector<std::size_t>& visible, const std::vector<Landmark>& landmarks,
                    Kalman& kalman);

  /// The index in the state of a landmark's lasting error; -1 if it has no place.
  int at(int landmark) const;

  /// Gives a place to a landmark, where one is free: with the variance of a landmark that was out of view, or
  /// without an error for one that is seen for the first time. Returns what at() does then.
  int add(int landmark, bool first_sight, Kalman& kalman);

  /// Forgets all errors, as their state was reset.
  void clear(Kalman& kalman);

  double variance() const { return options_.match_bias_sigma_px * options_.match_bias_sigma_px; }

 private:
  Options::Vision options_;
  std::vector<int> landmark_of_;  // by place; -1: free
};

}  // namespace slam
