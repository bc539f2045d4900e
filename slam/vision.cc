#include "slam/vision.h"

#include <algorithm>
#include <numeric>

#include "slam/relocalisation.h"

namespace slam {
namespace {

constexpr double kGate = 9.21;                 // chi-square, 99 %, 2 rows
constexpr double kLeastShareRecognised = 0.5;  // of those searched for

/// The area of the bounding box of the predicted pixels, as a fraction of the image's.
double image_coverage(const std::vector<SearchedLandmark>& searched, const CameraIntrinsics& camera) {
  Eigen::AlignedBox2d box;
  for (const SearchedLandmark& landmark : searched) box.extend(landmark.predicted);
  return box.isEmpty() ? 0 : box.volume() / (camera.width_px * camera.height_px);
}

/// Adds to a candidate the lasting error of its match, which is at `at` in the state; at < 0: it is not in the state.
void predict_lasting_error(int at, const State& state, double gain, double variance, Candidate& candidate) {
  Measurement& m = candidate.measurement;
  m.error_at = at;
  m.error_gain = gain;
  if (at < 0)
    m.R.diagonal().array() += gain * gain * variance;
  else
    candidate.pixel += gain * state.storage_x.segment<2>(at);
  candidate.S = innovation_covariance(state, m);
}

}  // namespace

/// The lasting error of a match, which so far is part of its noise, becomes a state of the filter where one is free.
void Vision::add_lasting_error(int landmark, Measurement& m, Kalman& kalman) {
  if (m.error_at >= 0 || !(options_.sigma_lasting_px > 0)) return;
  m.error_at = errors_.add(landmark, false, kalman);
  if (m.error_at >= 0) m.R.diagonal().array() -= m.error_gain * m.error_gain * errors_.variance();
}

/// before: only landmarks that were initialised before this time are searched for.
void Vision::search(const cv::Mat& image, const std::vector<Landmark>& landmarks, std::optional<Stamp> before,
                    Kalman& kalman) {
  predict_view(kalman, landmarks, camera_, options_.sigma_px, candidates_);
  if (options_.sigma_lasting_px > 0)
    for (Candidate& candidate : candidates_)
      predict_lasting_error(errors_.at(landmarks[candidate.index].id), kalman.state(),
                            camera_.sigma(candidate.pixel, 1), errors_.variance(), candidate);
  result_.visible.clear();
  result_.visible_indices.clear();
  for (const Candidate& candidate : candidates_) {
    result_.visible.push_back(candidate.pixel);
    result_.visible_indices.push_back(candidate.index);
  }
  errors_.keep_visible(result_.visible_indices, landmarks, kalman);
  if (before)
    std::erase_if(candidates_, [&](const Candidate& c) { return landmarks[c.index].initialised >= *before; });
  keep_most_informative(candidates_,
                        static_cast<std::size_t>(std::min(options_.measured_landmarks, bounds_.measured)));
  keep_affordable(candidates_, bounds_.searched_px);
  result_.searched.clear();
  matches_.clear();
  searched_of_.clear();
  for (const Candidate& candidate : candidates_) {
    SearchedLandmark searched{candidate.index, candidate.pixel, candidate.S};
    if (const auto m = search_candidate(image, landmarks[candidate.index], candidate, options_)) {
      searched.match = candidate.pixel + m->innovation;
      searched_of_.push_back(result_.searched.size());
      matches_.push_back(*m);
      add_lasting_error(landmarks[candidate.index].id, matches_.back(), kalman);
    }
    result_.searched.push_back(searched);
  }
  result_.matches = static_cast<int>(matches_.size());
  result_.coverage = image_coverage(result_.searched, camera_.intrinsics());
}

void Vision::find_inliers(const State& state) {
  inliers_.resize(matches_.size());
  std::iota(inliers_.begin(), inliers_.end(), std::size_t{0});
  if (matches_.empty()) return;
  stack(state, matches_, stacked_);
  gated_ = stacked_;
  if (!options_.consensus) return;
  scale_noise(gated_, matches_, options_.gate_sigma_px / options_.sigma_px);
  inliers_ = consensus_.largest(gated_, kGate);
}

bool Vision::recognises(const cv::Mat& image, const std::vector<Landmark>& landmarks, Stamp before,
                        Kalman& kalman) {
  search(image, landmarks, before, kalman);
  find_inliers(kalman.state());
  return inliers_.size() >= kLeastRecognised &&
         static_cast<double>(inliers_.size()) >
             kLeastShareRecognised * static_cast<double>(result_.searched.size());
}

const VisionResult& Vision::update(const cv::Mat& image, const std::vector<Landmark>& landmarks,
                                   Kalman& kalman) {
  search(image, landmarks, std::nullopt, kalman);
  find_inliers(kalman.state());
  result_.inliers.clear();
  result_.nis.reset();
  result_.update_nis.reset();
  result_.updated = false;
  if (inliers_.empty()) return result_;
  for (const std::size_t match : inliers_) {
    result_.inliers.push_back(searched_of_[match]);
    result_.searched[searched_of_[match]].inlier = true;
  }
  const auto nis_of_selected = [&] {
    whitening_.compute(selected_);
    return whitening_.nis();
  };
  select(gated_, inliers_, selected_);
  result_.nis = nis_of_selected();
  select(stacked_, inliers_, selected_);
  result_.update_nis = nis_of_selected();
  result_.updated = kalman.update(selected_);
  return result_;
}

}  // namespace slam
