// Searches an image for the landmarks that should be visible, and for corners that may become new ones.
#pragma once

#include <random>

#include "slam/vision/landmark.h"

namespace slam {

/// A landmark that should be visible: its predicted pixel, its linearized measurement with zero innovation,
/// the innovation covariance S in px², and the change of view since it was first seen.
struct Candidate {
  std::size_t index = 0;  ///< in the list of landmarks
  Eigen::Vector2d pixel;
  Measurement measurement;
  Eigen::Matrix2d S;
  Eigen::Matrix2d view_change;
};

/// Predicts a landmark as if it were of the given kind, which must have as many parameters as its own.
/// Returns nothing if it is not visible in the sense of predict_view. Leaves the index 0.
std::optional<Candidate> predict_landmark(const Kalman& kalman, const Landmark& landmark,
                                          const LandmarkKind& kind, const Camera& camera, double sigma_px);

/// Fills `candidates` with the landmarks that should be visible: in front of the camera, inside the image, at
/// half to twice their original size, and not seen too obliquely. Landmarks that are still lines are left
/// out. The caller computes S, after adding match biases if needed.
void predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks, const Camera& camera,
                  double sigma_px, std::vector<Candidate>& candidates);
inline std::vector<Candidate> predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks,
                                           const Camera& camera, double sigma_px) {
  std::vector<Candidate> candidates;
  predict_view(kalman, landmarks, camera, sigma_px, candidates);
  for (Candidate& candidate : candidates)
    candidate.S = innovation_covariance(kalman.state(), candidate.measurement);
  return candidates;
}

/// Keeps the `count` most informative candidates, which have the largest trace of S (Davison et al. 2007).
void keep_most_informative(std::vector<Candidate>& candidates, std::size_t count);

/// Keeps the most informative candidates that together compare templates at no more than `most_px` pixels.
void keep_affordable(std::vector<Candidate>& candidates, int most_px);

/// Searches for a candidate inside its 3-sigma ellipse, refines the match to sub-pixel accuracy (if enabled)
/// and fills in the innovation. Returns nothing if no place correlates well enough.
std::optional<Measurement> search_candidate(const cv::Mat& image, const Landmark& landmark,
                                            const Candidate& candidate, const Options::Vision& options);

/// Searches the image for a SemiInfiniteLine at each of its depths (Stasse et al. 2006, Fig. 3(b) and (c))
/// and multiplies their probabilities by |S|^(-1/2) exp(−νᵀS⁻¹ν/2); depths without a match are removed.
void search_line(const cv::Mat& image, const Kalman& kalman, const Camera& camera,
                 const Options::Vision& options, Landmark& landmark);

/// One step of a local search for the normal of a locally planar patch (Molton, Davison, Reid 2004, follow
/// the gradient instead): returns the landmark's tilt, or a neighboring tilt if its template correlates
/// better with the image at `pixel`, the match. The tilt stays the same as long as the view has hardly
/// changed.
Eigen::Vector2d refined_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                             const Camera& camera, const State& state);

/// A corner, and the smaller eigenvalue of Σ[gx² gxgy; gxgy gy²] over 11x11 pixels, in gray levels squared.
struct Corner {
  Eigen::Vector2i pixel;
  double strength;
};

/// The strongest corner in `region` (Shi & Tomasi 1994); gradients are central differences. Pixels too close
/// to the image's border are left out. Returns nothing if no corner is stronger than `threshold` (20 000 in
/// MonoSLAM).
std::optional<Corner> strongest_corner(const cv::Mat& image, const cv::Rect& region, double threshold);

/// The strongest corner in a box at a random place, which leaves room for the patch. Returns nothing if the
/// box contains an occupied pixel, or if its corner is too weak or too close to an occupied pixel. share: of
/// the threshold that suffices, down to the share in the dark.
std::optional<Eigen::Vector2i> propose_corner(const cv::Mat& image,
                                              const std::vector<Eigen::Vector2d>& occupied,
                                              const Options::Vision& options, std::mt19937_64& random,
                                              double share = 1);

/// The sub-pixel corner near the predicted pixel, found from the gradients. Returns nothing if it lies
/// outside the 3-sigma ellipse of the innovation covariance S, px².
std::optional<Eigen::Vector2d> corner_near(const cv::Mat& image, const Eigen::Vector2d& predicted,
                                           const Eigen::Matrix2d& S);

}  // namespace slam
