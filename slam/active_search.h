// From the map to the image: which landmarks should be in view, where, and where they were found.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/landmark.h"

namespace slam {

/// A landmark that should be in view: its predicted pixel, its linearised measurement (innovation still
/// zero), the covariance of the innovation, and how the view has changed since its first sight.
struct Candidate {
  std::size_t index = 0;  ///< in the list of landmarks
  Eigen::Vector2d pixel;
  Measurement measurement;
  Eigen::Matrix2d S;
  Eigen::Matrix2d view_change;
};

/// A landmark as it should be seen if it were of the given kind (of the same size as its own); index is left
/// 0. Nothing where it is not to be seen: see predict_view.
std::optional<Candidate> predict(const Kalman& kalman, const Landmark& landmark, const LandmarkKind& kind,
                                 const Camera& camera, double sigma_px);

/// What is predicted to be visible: in front, inside the image, at half to twice the first sight's size and
/// not seen too obliquely. Landmarks that are still lines are left out. Fills `candidates`.
void predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks, const Camera& camera,
                  double sigma_px, std::vector<Candidate>& candidates);
inline std::vector<Candidate> predict_view(const Kalman& kalman, const std::vector<Landmark>& landmarks,
                                           const Camera& camera, double sigma_px) {
  std::vector<Candidate> candidates;
  predict_view(kalman, landmarks, camera, sigma_px, candidates);
  return candidates;
}

/// Keeps the `count` candidates with the largest trace S: where measuring tells most (Davison et al. 2007).
void keep_most_informative(std::vector<Candidate>& candidates, std::size_t count);

/// Looks for a candidate inside its 3-sigma ellipse, refines the match below the pixel (where the options
/// have it) and fills the innovation. Nothing where no place correlates well enough.
std::optional<Measurement> find(const cv::Mat& image, const Landmark& landmark, const Candidate& candidate,
                                const Options::Vision& options);

}  // namespace slam
