// Active search: which landmarks should be visible, where they are predicted, and where they are found.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/options.h"
#include "slam/vision/landmark.h"

namespace slam {

/// A landmark that should be visible: its predicted pixel, its linearized measurement (whose innovation is
/// still zero), the innovation covariance S in px², and how the view has changed since it was first seen.
struct Candidate {
  std::size_t index = 0;  ///< in the list of landmarks
  Eigen::Vector2d pixel;
  Measurement measurement;
  Eigen::Matrix2d S;
  Eigen::Matrix2d view_change;
};

/// Predicts a landmark as if it were of the given kind, which has as many parameters as its own. Nothing
/// where it is not visible in the sense of predict_view. The index is 0.
std::optional<Candidate> predict_landmark(const Kalman& kalman, const Landmark& landmark,
                                          const LandmarkKind& kind, const Camera& camera, double sigma_px);

/// Fills `candidates` with the landmarks that should be visible: in front of the camera, inside the image, at
/// half to twice the size at which they were first seen, and not seen too obliquely. Landmarks that are still
/// lines are left out.
void predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks, const Camera& camera,
                  double sigma_px, std::vector<Candidate>& candidates);
inline std::vector<Candidate> predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks,
                                           const Camera& camera, double sigma_px) {
  std::vector<Candidate> candidates;
  predict_view(kalman, landmarks, camera, sigma_px, candidates);
  return candidates;
}

/// Keeps the `count` candidates with the largest trace of S, whose measurements are the most informative
/// (Davison et al. 2007).
void keep_most_informative(std::vector<Candidate>& candidates, std::size_t count);

/// Keeps candidates whose searches compare templates at no more than `most_px` pixels together: the most
/// informative ones first, and each that still fits.
void keep_affordable(std::vector<Candidate>& candidates, int most_px);

/// Searches a candidate inside its 3-sigma ellipse, refines the match to sub-pixel accuracy (if the options
/// say so) and fills the innovation. Nothing where no place correlates well enough.
std::optional<Measurement> search_candidate(const cv::Mat& image, const Landmark& landmark,
                                            const Candidate& candidate, const Options::Vision& options);

/// Searches the image for the landmark, which is a SemiInfiniteLine, at each of its depths and multiplies
/// their probabilities by |S|^(-1/2) exp(−νᵀS⁻¹ν/2); depths without a match are removed. The state is only
/// read.
void search_line(const cv::Mat& image, const Kalman& kalman, const Camera& camera,
                 const Options::Vision& options, Landmark& landmark);

/// One step of a local search for the normal of a locally planar patch (Molton, Davison, Reid 2004, follow
/// the gradient instead): returns the landmark's tilt, or the neighboring tilt whose template correlates
/// better with the image at `pixel`, where the landmark was found. While the view has hardly changed, all
/// tilts correlate alike and the tilt stays.
Eigen::Vector2d refined_tilt(const cv::Mat& image, const Landmark& landmark, const Eigen::Vector2d& pixel,
                             const Camera& camera, const State& state);

}  // namespace slam
