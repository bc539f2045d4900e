// Vision: the visible landmarks are predicted, searched for and gated, and the inliers update the state
// (Stasse et al. 2006, section III-A).
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/options.h"
#include "slam/vision/active_search.h"
#include "slam/vision/match_bias.h"

namespace slam {

class Consensus {
 public:
  /// The inliers among the stacked matches (2 rows each) by the 1-point RANSAC of Civera et al. 2010. Each
  /// match serves once as the hypothesis, and the others are gated by their chi-square conditional on it, so
  /// that prior correlations count as in joint compatibility (Neira & Tardós 2001). Then those are rescued
  /// that pass the gate conditional on all the inliers. Returns rising indices, valid until the next call.
  /// gate: chi-square bound for a match of 2 rows.
  const std::vector<std::size_t>& largest(const StackedMeasurement& matches, double gate);

 private:
  void rescue(const StackedMeasurement& matches, double gate);

  std::vector<std::size_t> best_, supporters_, rescued_;
  StackedMeasurement inliers_;
  Whitening whitening_;
  Eigen::MatrixXd cross_;
};

/// A landmark that was searched for, and its match if there is one.
struct SearchedLandmark {
  std::size_t index;                                    ///< in the list of landmarks
  Eigen::Vector2d predicted;                            ///< px
  Eigen::Matrix2d S;                                    ///< innovation covariance, px²
  std::optional<Eigen::Vector2d> match = std::nullopt;  ///< px
  bool inlier = false;                                  ///< its match entered the update
};

struct VisionResult {
  std::vector<Eigen::Vector2d> visible;      ///< predicted pixels of all landmarks that should be visible
  std::vector<std::size_t> visible_indices;  ///< their indices in the list of landmarks
  std::vector<SearchedLandmark> searched;
  std::vector<std::size_t> inliers;  ///< rising indices of `searched`
  int matches = 0;                   ///< how many of those searched for were found
  double coverage = 0;            ///< bounding box of those searched for, as a fraction of the image's area
  std::optional<Nis> nis;         ///< of the inliers, with the noise of single matches (gate_sigma_px)
  std::optional<Nis> update_nis;  ///< of the inliers, with the noise that the update assumes (sigma_px)
  bool updated = false;           ///< false without inliers, or where S is not positive definite
};

class Vision {
 public:
  Vision(const Options::Vision& options, const Options::Bounds& bounds, const Camera& camera)
      : options_(options), bounds_(bounds), camera_(camera), biases_(options, bounds) {}

  /// Searches the image for the landmarks and updates the state with the inliers. The result is valid until
  /// the next call.
  const VisionResult& update(const cv::Mat& image, const std::vector<Landmark>& landmarks, Kalman& kalman);

  /// The errors of matches that last: to be predicted as the state is; landmarks initialized after the update
  /// are to be added.
  MatchBiases& biases() { return biases_; }
  const MatchBiases& biases() const { return biases_; }

  /// Whether landmarks that were in the map before a time are found where the state predicts them: at least
  /// kLeastRecognized of them, and most of those searched for. Does not update the estimate.
  bool recognizes(const cv::Mat& image, const std::vector<Landmark>& landmarks, Stamp before, Kalman& kalman);

 private:
  void search(const cv::Mat& image, const std::vector<Landmark>& landmarks, std::optional<Stamp> before,
              Kalman& kalman);
  void add_bias(int landmark, Measurement& match, Kalman& kalman);
  void find_inliers(const State& state);

  Options::Vision options_;
  Options::Bounds bounds_;
  Camera camera_;
  MatchBiases biases_;
  Consensus consensus_;
  VisionResult result_;
  // Work space, kept so that a step in the steady state takes no heap memory.
  std::vector<Candidate> candidates_;
  std::vector<Measurement> matches_;
  std::vector<std::size_t> searched_of_, inliers_;  // of each match: its index in searched; inlier matches
  StackedMeasurement stacked_, gated_, selected_;   // gated_: with the noise of single matches
  Whitening whitening_;
};

}  // namespace slam
