// Active search: the landmarks that should be visible, their predicted pixels, and the search for them.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/options.h"
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

/// Predicts a landmark as if it were of the given kind, which has as many parameters as its own. Nothing if
/// it is not visible in the sense of predict_view. The index is 0.
std::optional<Candidate> predict_landmark(const Kalman& kalman, const Landmark& landmark,
                                          const LandmarkKind& kind, const Camera& camera, double sigma_px);

/// Fills `candidates` with the landmarks that should be visible: in front of the camera, inside the image, at
/// half to twice their first size, and not seen too obliquely. Landmarks that are still lines are left out.
void predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks, const Camera& camera,
                  double sigma_px, std::vector<Candidate>& candidates);
inline std::vector<Candidate> predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks,
                                           const Camera& camera, double sigma_px) {
  std::vector<Candidate> candidates;
  predict_view(kalman, landmarks, camera, sigma_px, candidates);
  return candidates;
}

/// Keeps the `count` candidates with the largest trace of S, the most informative measurements (Davison et
/// al. 2007).
void keep_most_informative(std::vector<Candidate>& candidates, std::size_t count);

/// Keeps candidates that together compare templates at no more than `most_px` pixels: the most informative
/// first, and each that still fits.
void keep_affordable(std::vector<Candidate>& candidates, int most_px);

/// Searches a candidate inside its 3-sigma ellipse, refines the match to sub-pixel accuracy (if enabled) and
/// fills the innovation. Nothing if no place correlates well enough.
std::optional<Measurement> search_candidate(const cv::Mat& image, const Landmark& landmark,
                                            const Candidate& candidate, const Options::Vision& options);

/// Searches the image for a SemiInfiniteLine at each of its depths (Stasse et al. 2006, Fig. 3(b) and (c))
/// and multiplies their probabilities by |S|^(-1/2) exp(−νᵀS⁻¹ν/2); depths without a match are removed.
void search_line(const cv::Mat& image, const Kalman& kalman, const Camera& camera,
                 const Options::Vision& options, Landmark& landmark);

/// One step of a local search for the normal of a locally planar patch (Molton, Davison, Reid 2004, follow
/// the gradient instead): returns the landmark's tilt, or a neighboring tilt if its template correlates
/// better with the image at `pixel`, the match. While the view has hardly changed, all tilts correlate alike
/// and the tilt stays.
Eigen::Vector2d refined_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                             const Camera& camera, const State& state);

}  // namespace slam
