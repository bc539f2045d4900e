#include "slam/vision/vision.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "slam/eigen_kernels.h"

namespace slam {
namespace {

double mahalanobis_squared(const Eigen::Vector2d& nu, const Eigen::Matrix2d& S) {
  return S.llt().matrixL().solve(nu).squaredNorm();
}

/// νᵀS⁻¹ν of match j conditional on match i, whose S has this inverse.
double distance_given(const StackedMeasurement& matches, int i, const Eigen::Matrix2d& inverse, int j) {
  const Eigen::Matrix2d S_ji = matches.S().block<2, 2>(2 * j, 2 * i);
  const Eigen::Matrix2d gain = S_ji * inverse;
  const Eigen::Vector2d nu =
      matches.innovation().segment<2>(2 * j) - gain * matches.innovation().segment<2>(2 * i);
  const Eigen::Matrix2d S = matches.S().block<2, 2>(2 * j, 2 * j) - gain * S_ji.transpose();
  return mahalanobis_squared(nu, S);
}

/// Finds the matches that pass the gate when match i is the hypothesis; returns the sum of their νᵀS⁻¹ν.
double find_supporters(const StackedMeasurement& matches, int i, double gate,
                       std::vector<std::size_t>& supporters) {
  supporters.clear();
  const Eigen::Matrix2d inverse = matches.S().block<2, 2>(2 * i, 2 * i).inverse();
  double sum = 0;
  for (int j = 0; j < static_cast<int>(matches.count()); ++j) {
    const double d = i == j ? mahalanobis_squared(matches.innovation().segment<2>(2 * i),
                                                  matches.S().block<2, 2>(2 * i, 2 * i))
                            : distance_given(matches, i, inverse, j);
    if (!(d < gate)) continue;
    supporters.push_back(static_cast<std::size_t>(j));
    sum += d;
  }
  return sum;
}

constexpr Stamp kRetryAfter{500'000'000};  // for a landmark that is set aside
constexpr std::size_t kRetried = 2;  // number of these in a frame, even if there are others to search for
constexpr int kMostSearched_px = 400000;       // in a frame; bounds its cost
constexpr double kGate = 9.21;                 // chi-square, 99 %, 2 rows
constexpr std::size_t kLeastAtPrediction = 4;  // chance matches at predicted pixels are rare
constexpr double kLeastShareRecognized = 0.5;  // fraction of the landmarks searched for
constexpr double kMoved = 25;                  // chi-square; outside of the ellipse that is searched

/// The area of the bounding box of the predicted pixels, as a fraction of the image's.
double image_coverage(const std::vector<Candidate>& candidates, const CameraIntrinsics& camera) {
  Eigen::AlignedBox2d box;
  for (const Candidate& candidate : candidates) box.extend(candidate.pixel);
  return box.isEmpty() ? 0 : box.volume() / (camera.width_px * camera.height_px);
}

/// Predicts a candidate's match bias and S. at: the bias's index in the state; < 0: not in the state.
void predict_bias(int at, const State& state, double gain, double variance, Candidate& candidate) {
  Measurement& m = candidate.measurement;
  m.bias_at = at;
  m.bias_gain = gain;
  if (at >= 0) candidate.pixel += gain * state.storage_x.segment<2>(at);
  candidate.S = innovation_covariance(state, m);
  if (at < 0) candidate.S.diagonal().array() += gain * gain * variance;
}

constexpr int kSparePlaces = 6;  // for landmarks in view that are not measured in this frame
constexpr int kMostPlaces = 40;
constexpr int kFree = -1;

int index_of_place(std::size_t place) { return kRobot + 2 * static_cast<int>(place); }

}  // namespace

/// Adds to best_ the matches that pass the gate conditional on all of best_.
void Consensus::rescue(const StackedMeasurement& matches, double gate) {
  select_innovation(matches, best_, inliers_);
  whitening_.compute(inliers_);
  reserve_workspace(cross_, inliers_.rows, 2);
  auto cross = cross_.leftCols<2>().topRows(inliers_.rows);
  rescued_.clear();
  for (std::size_t j = 0; j < matches.count(); ++j) {
    if (std::binary_search(best_.begin(), best_.end(), j)) {
      rescued_.push_back(j);
      continue;
    }
    const int row = matches.first_row[j];
    for (std::size_t k = 0; k < best_.size(); ++k)
      cross.middleRows<2>(2 * static_cast<int>(k)) =
          matches.S().block<2, 2>(matches.first_row[best_[k]], row);
    whitening_.solve(cross);
    const Eigen::Vector2d nu =
        matches.innovation().segment<2>(row) - cross.transpose() * whitening_.innovation();
    const Eigen::Matrix2d S = matches.S().block<2, 2>(row, row) - cross.transpose() * cross;
    if (mahalanobis_squared(nu, S) < gate) rescued_.push_back(j);
  }
  best_.swap(rescued_);
}

const std::vector<std::size_t>& Consensus::largest(const StackedMeasurement& matches, double gate) {
  best_.clear();
  double least = 0;
  for (int i = 0; i < static_cast<int>(matches.count()); ++i) {
    const double sum = find_supporters(matches, i, gate, supporters_);
    const bool more = supporters_.size() > best_.size();
    const bool closer = supporters_.size() == best_.size() && sum < least;
    if (!more && !closer) continue;
    best_.swap(supporters_);
    least = sum;
  }
  if (!best_.empty()) rescue(matches, gate);
  return best_;
}

void Consensus::prune(const StackedMeasurement& matches, double gate, std::vector<std::size_t>& inliers) {
  while (inliers.size() > 1) {
    select_innovation(matches, inliers, inliers_);
    const Eigen::MatrixXd information = inliers_.S().inverse();
    const Eigen::VectorXd u = information * inliers_.innovation();
    double worst = gate;
    std::optional<int> contradicted;
    for (int k = 0; k < static_cast<int>(inliers.size()); ++k) {
      const Eigen::Matrix2d given_others = information.block<2, 2>(2 * k, 2 * k);
      if (const double d = mahalanobis_squared(u.segment<2>(2 * k), given_others); d > worst)
        worst = d, contradicted = k;
    }
    if (!contradicted) return;
    inliers.erase(inliers.begin() + *contradicted);
  }
}

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
    if (!seen) remove(landmark_of_[place], kalman);
  }
}

void MatchBiases::remove(int landmark, Kalman& kalman) {
  kalman.predict_match_bias(at(landmark), 0, 0);
  *std::find(landmark_of_.begin(), landmark_of_.end(), landmark) = kFree;
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

/// Removes the landmarks that are set aside from candidates_, and fills retried_ with the ones that are due.
void Vision::set_aside(const std::vector<Landmark>& landmarks, Stamp t, const State& state) {
  const auto last_search = [&](const Candidate& c) { return landmarks[c.index].last_search; };
  const auto is_set_aside = [&](const Candidate& c) { return landmarks[c.index].is_set_aside(state); };
  for (const Candidate& c : candidates_)
    if (is_set_aside(c) && t - last_search(c) >= kRetryAfter) retried_.push_back(c);
  std::sort(retried_.begin(), retried_.end(), [&](const Candidate& a, const Candidate& b) {
    return std::pair(last_search(a), a.index) < std::pair(last_search(b), b.index);
  });
  std::erase_if(candidates_, is_set_aside);
}

/// Keeps the candidates initialized before a time, at most as many as are searched for in a frame. Prefers
/// the fewest misses, so that failures rotate the candidates.
void Vision::keep_least_missed(const std::vector<Landmark>& landmarks, Stamp before) {
  std::erase_if(candidates_, [&](const Candidate& c) { return landmarks[c.index].initialized >= before; });
  // Not std::stable_sort: its buffer is not aligned for Eigen's matrices.
  std::ranges::sort(candidates_, {},
                    [&](const Candidate& c) { return std::pair(landmarks[c.index].misses, c.index); });
  if (candidates_.size() > most_measured_) candidates_.resize(most_measured_, candidates_.front());
}

/// Makes the bias of a match a part of the state. If no place is free, it replaces the landmark in view that
/// was not searched for in this frame and has waited longest for a search.
void Vision::place_bias(const std::vector<Landmark>& landmarks, int landmark, Measurement& m,
                        Kalman& kalman) {
  m.bias_at = biases_.add(landmark, false, kalman);
  if (m.bias_at >= 0) return;
  const Landmark* oldest = nullptr;
  for (const std::size_t i : result_.visible_indices) {
    const bool searched = std::any_of(candidates_.begin(), candidates_.end(),
                                      [&](const Candidate& candidate) { return candidate.index == i; });
    if (searched || biases_.at(landmarks[i].id) < 0) continue;
    if (!oldest || landmarks[i].last_search < oldest->last_search) oldest = &landmarks[i];
  }
  if (oldest) {
    biases_.remove(oldest->id, kalman);
    m.bias_at = biases_.add(landmark, false, kalman);
  } else {  // more landmarks are measured than there are places
    m.R.diagonal().array() += m.bias_gain * m.bias_gain * biases_.variance();
  }
}

/// before: only landmarks that were initialized before this time are searched for. most: their number.
/// on_trial: searches for the landmarks on trial instead of the others.
void Vision::search(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks,
                    std::optional<Stamp> before, std::size_t most, Kalman& kalman, bool on_trial) {
  predict_view(kalman, landmarks, camera_, options_.sigma_px, candidates_);
  for (Candidate& candidate : candidates_) {
    const double gain = options_.match_bias_sigma_px > 0 ? camera_.sigma(candidate.pixel, 1) : 0;
    predict_bias(biases_.at(landmarks[candidate.index].id), kalman.state(), gain, biases_.variance(),
                 candidate);
  }
  result_.visible.clear();
  result_.visible_indices.clear();
  const auto add_visible = [&](const Candidate& candidate) {
    result_.visible.push_back(candidate.pixel);
    result_.visible_indices.push_back(candidate.index);
  };
  std::erase_if(candidates_, [&](const Candidate& candidate) {
    const bool other = landmarks[candidate.index].on_trial != on_trial;
    if (other) add_visible(candidate);
    return other;
  });
  result_.tested = std::min(candidates_.size(), most);
  result_.coverage = image_coverage(candidates_, camera_.intrinsics());
  retried_.clear();
  if (!before) set_aside(landmarks, t, kalman.state());
  std::ranges::for_each(candidates_, add_visible);
  biases_.keep_visible(result_.visible_indices, landmarks, kalman);
  if (before)
    keep_least_missed(landmarks, *before);
  else
    keep_most_informative(candidates_, most - std::min({retried_.size(), kRetried, most - 1}));
  const std::size_t retried = std::min(retried_.size(), most - candidates_.size());
  candidates_.insert(candidates_.end(), retried_.begin(),
                     retried_.begin() + static_cast<std::ptrdiff_t>(retried));
  keep_affordable(candidates_, kMostSearched_px);
  result_.searched.clear();
  result_.searched_indices.clear();
  matches_.measurements.clear();
  matches_.searched.clear();
  for (const Candidate& candidate : candidates_) {
    Search searched{landmarks[candidate.index].id, candidate.pixel, candidate.S};
    if (auto m = search_candidate(image, landmarks[candidate.index], candidate, options_)) {
      searched.match = candidate.pixel + m->innovation;
      if (m->bias_at < 0 && m->bias_gain > 0) place_bias(landmarks, searched.landmark, *m, kalman);
      matches_.searched.push_back(result_.searched.size());
      matches_.measurements.push_back(*m);
    }
    result_.searched.push_back(searched);
    result_.searched_indices.push_back(candidate.index);
  }
  result_.matches = static_cast<int>(matches_.measurements.size());
}

void Vision::stack_matches(const State& state) {
  all_.resize(matches_.measurements.size());
  std::iota(all_.begin(), all_.end(), std::size_t{0});
  if (all_.empty()) return;
  stack(state, matches_.measurements, stacked_.all);
  select_innovation(stacked_.all, all_, stacked_.gated);
  if (options_.consensus)
    scale_noise(stacked_.gated, matches_.measurements, options_.gate_sigma_px / options_.sigma_px);
}

/// uncertain, least: see update.
void Vision::find_inliers(Kalman& kalman, const std::optional<RobotState>& uncertain, std::size_t least) {
  stack_matches(kalman.state());
  inliers_ = all_;
  if (options_.consensus && !all_.empty()) inliers_ = consensus_.largest(stacked_.gated, kGate);
  if (uncertain) {
    kalman.reset_robot(*uncertain);
    stack_matches(kalman.state());
    consensus_.prune(stacked_.gated, kGate, inliers_);
  }
  if (inliers_.size() < least) inliers_.clear();
  for (const std::size_t match : inliers_) result_.searched[matches_.searched[match]].used = true;
}

/// Multiplies the whitened innovation of each landmark by its whitened innovation in the last frame.
void Vision::add_lagged() {
  for (const std::size_t match : inliers_) {
    const int id = result_.searched[matches_.searched[match]].landmark;
    const int row = stacked_.all.first_row[match];
    const Eigen::Vector2d now = stacked_.all.S().block<2, 2>(row, row).llt().matrixL().solve(
        stacked_.all.innovation().segment<2>(row));
    whitened_.now.emplace_back(id, now);
    for (const auto& [landmark, before] : whitened_.before) {
      if (landmark != id) continue;
      result_.update->lagged += now.dot(before), result_.update->lagged_square += now.squaredNorm();
    }
  }
}

bool Vision::recognizes(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks, Stamp before,
                        Kalman& kalman) {
  search(image, t, landmarks, before, most_measured_, kalman);
  find_inliers(kalman);
  return inliers_.size() >= kLeastAtPrediction &&
         static_cast<double>(inliers_.size()) >
             kLeastShareRecognized * static_cast<double>(result_.searched.size());
}

std::optional<bool> Vision::passes_trial(const cv::Mat& image, Stamp t,
                                         const std::vector<Landmark>& landmarks, Kalman& kalman) {
  search(image, t, landmarks, std::nullopt, most_measured_, kalman, true);
  find_inliers(kalman);
  std::size_t moved = 0, found = 0;
  for (std::size_t i = 0; i < result_.searched.size(); ++i) {
    const Search& s = result_.searched[i];
    if (mahalanobis_squared(s.pixel - landmarks[result_.searched_indices[i]].pixel_first, s.S) < kMoved)
      continue;
    ++moved;
    if (s.used) ++found;
  }
  if (moved < kLeastAtPrediction) return std::nullopt;
  return static_cast<double>(found) > kLeastShareRecognized * static_cast<double>(moved);
}

const VisionResult& Vision::update(const cv::Mat& image, Stamp t, const std::vector<Landmark>& landmarks,
                                   Kalman& kalman, const std::optional<RobotState>& uncertain,
                                   std::size_t least) {
  // In doubt, landmarks that failed are not set aside: they are seen again when a cover is removed.
  search(image, t, landmarks, least > 1 ? std::optional(Stamp::max()) : std::nullopt,
         uncertain ? landmarks.size() : most_measured_, kalman);
  find_inliers(kalman, uncertain, least);
  result_.inliers.clear();
  result_.gate.reset();
  result_.update.reset();
  result_.updated = false;
  std::swap(whitened_.now, whitened_.before);
  whitened_.now.clear();
  if (inliers_.empty()) return result_;
  for (const std::size_t match : inliers_) result_.inliers.push_back(matches_.searched[match]);
  const bool all = inliers_.size() == stacked_.all.count();
  if (!all) select_innovation(stacked_.gated, inliers_, stacked_.selected);
  whitening_.compute(all ? stacked_.gated : stacked_.selected);
  result_.gate = whitening_.nis();
  if (!all) select(stacked_.all, inliers_, stacked_.selected);
  result_.updated = kalman.update(all ? stacked_.all : stacked_.selected);
  result_.update = kalman.whitening().nis();
  add_lagged();
  return result_;
}

}  // namespace slam
