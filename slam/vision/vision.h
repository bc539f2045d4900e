// Vision: the visible landmarks are predicted, searched for and gated, and the inliers update the state
// (Stasse et al. 2006, section III-A).
#pragma once

#include <algorithm>

#include "slam/vision/active_search.h"

namespace slam {

class Consensus {
 public:
  /// The inliers among the stacked matches (2 rows each) by the 1-point RANSAC of Civera et al. 2010. Each
  /// match serves once as the hypothesis, and the others are gated by their chi-square conditional on it, so
  /// that prior correlations count as in joint compatibility (Neira & Tardós 2001). Finally, matches that
  /// pass the gate conditional on all the inliers are rescued. Returns ascending indices, valid until the
  /// next call. gate: chi-square bound for a match of 2 rows.
  const std::vector<std::size_t>& largest(const StackedMeasurement& matches, double gate);
  /// Removes the inlier that the others contradict most, until each passes the gate conditional on all the
  /// others.
  void prune(const StackedMeasurement& matches, double gate, std::vector<std::size_t>& inliers);

 private:
  void rescue(const StackedMeasurement& matches, double gate);

  std::vector<std::size_t> best_, supporters_, rescued_;
  StackedMeasurement inliers_;
  Whitening whitening_;
  Eigen::MatrixXd cross_;
};

/// The match biases. From a new place, the camera sees a landmark slightly differently from its template,
/// so the match has an error that hardly changes from frame to frame. If it were modeled as white noise,
/// every frame would count as new information. Instead, the bias is a Gauss-Markov process in the state, with
/// two parameters for each landmark in view, in units of Camera::sigma(pixel, 1). It is zero at the first
/// sighting. Landmarks in view share a fixed number of places in the state.
class MatchBiases {
 public:
  MatchBiases(const Options::Vision& options, const Options::Bounds& bounds);
  /// The number of places that the state must have: 0 if the options have no match bias.
  static int places(const Options::Vision& options, const Options::Bounds& bounds);
  /// Predicts the biases over a frame interval.
  void predict(double dt_s, Kalman& kalman) const;
  /// Frees the places of landmarks that are not `visible` (indices in the list of landmarks).
  void keep_visible(const std::vector<std::size_t>& visible, const std::vector<Landmark>& landmarks,
                    Kalman& kalman);
  /// The index in the state of a landmark's bias; -1 if it has no place.
  int at(int landmark) const;
  /// Gives a landmark a place, with bias 0 at its first sighting and otherwise the stationary variance.
  /// Returns at().
  int add(int landmark, bool first_sight, Kalman& kalman);
  /// Frees the place of a landmark that has one.
  void remove(int landmark, Kalman& kalman);
  /// Forgets all biases, after a reset of the pose.
  void clear(Kalman& kalman);

  double variance() const { return options_.match_bias_sigma_px * options_.match_bias_sigma_px; }

 private:
  Options::Vision options_;
  std::vector<int> landmark_of_;  // by place; -1: free
};

struct VisionResult {
  std::vector<Eigen::Vector2d> visible;      ///< predicted pixels of all landmarks that should be visible
  std::vector<std::size_t> visible_indices;  ///< their indices in the list of landmarks
  std::size_t tested = 0;  ///< number of these plus the ones set aside, at most as many as may be measured
  std::vector<Search> searched;
  /// Indices of the landmarks searched for, in the list of landmarks.
  std::vector<std::size_t> searched_indices;
  std::vector<std::size_t> inliers;  ///< ascending indices in `searched`
  int matches = 0;                   ///< number of these that were found
  double coverage = 0;        ///< bounding box of all landmarks in view, as a fraction of the image's area
  std::optional<Nis> gate;    ///< NIS of the inliers, with the noise of the gate (gate_sigma_px)
  std::optional<Nis> update;  ///< NIS of the inliers, with the noise assumed by the update (sigma_px)
  bool updated = false;       ///< false without inliers, or if S is not positive definite
};

class Vision {
 public:
  Vision(const Options::Vision& options, const Options::Bounds& bounds, const Camera& camera)
      : options_(options),
        camera_(camera),
        most_measured_(static_cast<std::size_t>(std::min(options.measured_landmarks, bounds.measured))),
        biases_(options, bounds) {
    retried_.reserve(kLandmarksInView);
    for (auto* list : {&whitened_.now, &whitened_.before}) list->reserve(most_measured_);
  }
  /// Searches for the landmarks and updates the state with the inliers. Valid until the next call.
  /// least: number of inliers below which none is used.
  /// uncertain: the same robot with a larger covariance, to which it is reset after a search for all
  /// landmarks.
  const VisionResult& update(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks,
                             Kalman& kalman, const std::optional<RobotState>& uncertain = {},
                             std::size_t least = 1);
  /// The match biases. The caller predicts them along with the state and adds new landmarks to them.
  MatchBiases& biases() { return biases_; }
  const MatchBiases& biases() const { return biases_; }
  /// True if landmarks that were in the map before a time are found at their predicted pixels: at least four
  /// of them, and more than half of the landmarks searched for. Does not update the estimate.
  bool recognizes(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks, Stamp before,
                  Kalman& kalman);
  /// True if most of the landmarks on trial are found at their predicted pixels, false if they are not.
  /// Returns nothing until enough of these pixels differ from the first ones, as things that move with the
  /// camera stay there.
  std::optional<bool> passes_trial(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks,
                                   Kalman& kalman);
  /// The result of the last search.
  const VisionResult& result() const { return result_; }

 private:
  void set_aside(const std::vector<Landmark>& landmarks, Stamp t, const State& state);
  void keep_least_missed(const std::vector<Landmark>& landmarks, Stamp before);
  void search(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks,
              std::optional<Stamp> before, std::size_t most, Kalman& kalman, bool on_trial = false);
  void place_bias(const std::vector<Landmark>& landmarks, int landmark, Measurement& m, Kalman& kalman);
  void stack_matches(const State& state);
  void find_inliers(Kalman& kalman, const std::optional<RobotState>& uncertain = {}, std::size_t least = 1);
  void add_lagged();

  Options::Vision options_;
  Camera camera_;
  std::size_t most_measured_;
  MatchBiases biases_;
  Consensus consensus_;
  VisionResult result_;
  // Work space, kept so that a step in the steady state takes no heap memory.
  struct Matches {
    std::vector<Measurement> measurements;
    std::vector<std::size_t> searched;  // index of each match in VisionResult::searched
  } matches_;
  std::vector<Candidate> candidates_, retried_;
  std::vector<std::size_t> all_, inliers_;  // indices of the matches
  struct {
    std::vector<std::pair<int, Eigen::Vector2d>> now, before;
  } whitened_;  // innovations, by landmark
  struct {
    StackedMeasurement all, gated, selected;  // gated: with the noise of single matches
  } stacked_;
  Whitening whitening_;
};

}  // namespace slam
