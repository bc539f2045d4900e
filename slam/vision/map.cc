#include "slam/vision/map.h"

#include <algorithm>
#include <cmath>

#include "slam/vision/active_search.h"

namespace slam {
namespace {

Landmark landmark_seen_from(const Eigen::Isometry3d& X_WC, Stamp t) {
  Landmark landmark;
  landmark.X_WC_first = X_WC;
  landmark.p_WC_inflated = X_WC.translation();
  landmark.initialized = landmark.last_visible = landmark.last_search = t;
  return landmark;
}

constexpr std::size_t kRoom = 256;          // landmarks for which memory is reserved
constexpr double kDriftMemory = 0.99;       // weight of a landmark's earlier innovations after each match
constexpr int kProposals = 5;               // corners tried for each landmark wanted
constexpr int kInitializedPerFrame = 3;     // landmarks, once the map is not empty
constexpr std::size_t kFewVisible = 4;      // with fewer, weak corners are better than none
constexpr double kWeaker = 0.9;             // of the threshold for corners, after each image without any
constexpr Stamp kYoung{10'000'000'000};     // time between a landmark's first and last view
constexpr Stamp kBadCorner{5'000'000'000};  // time since a young landmark was deleted there
constexpr double kSameDirection = 0.9976;   // cosine of 4 degrees
// Ratio of motion to distance; swaying moves the camera less, and back again.
constexpr double kLeastViewChange = 0.02;
// Cameras within these bounds (the cosine of 14 degrees) see the map with the same match errors.
constexpr double kPlace_m = 0.15, kPlaceDirection = 0.97;
constexpr Stamp kAway{10'000'000'000};  // time between two visits to a place
// Factor on the linearity bound of landmarks that are out of view: with it, the default is 0.1 as in Civera
// et al. 2008. Landmarks in view would lose accuracy, and points halve the cost of an update.
constexpr double kOutOfView = 2;

/// Adds an error of the direction, as seen from r, to a landmark's covariance.
void inflate(const Landmark& landmark, double sigma_rad, const Eigen::Vector3d& r, Kalman& kalman) {
  const double variance = sigma_rad * sigma_rad;
  const double distance = (position(landmark.kind, landmark.parameters(kalman.state())) - r).norm();
  if (std::holds_alternative<Point>(landmark.kind))
    kalman.inflate(landmark.at, variance * distance * distance * Eigen::Matrix3d::Identity());
  else  // azimuth and elevation of the ray
    kalman.inflate(landmark.at + 3, variance * Eigen::Vector3d(1, 1, 0).asDiagonal().toDenseMatrix());
}

bool is_line(const Landmark& landmark) { return std::holds_alternative<SemiInfiniteLine>(landmark.kind); }

double inverse_depth_sigma(const State& state, const Landmark& landmark) {
  return std::sqrt(std::max(0.0, state.storage_P(landmark.at + 5, landmark.at + 5)));
}

/// True if the landmark lies behind the camera that first saw it, by 3 sigma of its inverse depth.
bool surely_behind(const State& state, const Landmark& landmark) {
  return std::holds_alternative<InverseDepth>(landmark.kind) &&
         state.storage_x(landmark.at + 5) + 3 * inverse_depth_sigma(state, landmark) < 0;
}

}  // namespace

std::optional<Landmark> initialize_landmark(const cv::Mat& image, const DepthImage& depth, Stamp t,
                                            const Eigen::Vector2i& pixel, const Camera& camera,
                                            const Options& options, Kalman& kalman) {
  const auto ray = camera.unproject(pixel.cast<double>());
  if (!ray) return std::nullopt;
  Landmark landmark = landmark_seen_from(kalman.state().X_WC(), t);
  landmark.patch = cut_patch(image, pixel);
  landmark.pixel_first = pixel.cast<double>();
  const double sigma_px = camera.sigma(landmark.pixel_first, options.vision.sigma_first_px);
  const RobotVector x = kalman.state().robot();
  if (options.depth.first_sight == FirstSight::particles) {
    landmark.kind = SemiInfiniteLine{uniform_prior(options.depth.particles)};
    landmark.at = kalman.append(initialize_line(x, *ray, sigma_px));
  } else {
    landmark.at = kalman.append(initialize_inverse_depth(
        x, *ray, sigma_px, camera.displacement(ray->h, landmark.pixel_first), options.depth,
        options.depth.first_sight == FirstSight::measured_depth ? depth.at(pixel) : std::nullopt));
  }
  return landmark;
}

std::optional<Landmark> initialize_known_landmark(const cv::Mat& image, Stamp t, const Eigen::Vector3d& p_W,
                                                  const Camera& camera, const Options& options,
                                                  Kalman& kalman) {
  Landmark landmark = landmark_seen_from(kalman.state().X_WC(), t);
  landmark.kind = Point{};
  landmark.at = kalman.append_point(p_W, options.known_landmarks.sigma_m);
  const auto predicted =
      predict_landmark(kalman, landmark, landmark.kind, camera, options.vision.search_sigma_px());
  const auto pixel = predicted ? corner_near(image, predicted->pixel, predicted->S) : std::nullopt;
  if (!pixel || !camera.inside(*pixel, kSourceHalf + 1)) {
    kalman.erase(landmark.at, Point::kSize);
    return std::nullopt;
  }
  landmark.patch = cut_patch_between(image, *pixel);
  landmark.pixel_first = *pixel;
  return landmark;
}

Map::Map(const Options& options, const Camera& camera, std::uint64_t seed)
    : options_(options), camera_(camera), random_(seed) {
  landmarks_.reserve(kRoom);
  pruned_.reserve(kRoom);
  sliding_.reserve(kRoom);
  places_.reserve(kRoom);
}

std::vector<MapPoint> Map::points(const State& state) const {
  constexpr std::array kKinds{"point", "inverse_depth", "line"};
  std::vector<MapPoint> points;
  for (const Landmark& l : landmarks_)
    points.push_back({l.id, kKinds[l.kind.index()], position(l.kind, l.parameters(state)),
                      position_covariance(state, l), l.initialized, l.attempts, l.successes});
  return points;
}

void Map::add(Landmark landmark) {
  landmark.id = next_id_++, landmark.last_session = session_;
  landmarks_.push_back(std::move(landmark));
}

/// Returns how many landmarks to initialize in this frame.
int Map::number_wanted(std::size_t visible, const State& state) const {
  const int missing = options_.vision.visible_landmarks - static_cast<int>(visible);
  const Options::Depth::Particles& particles = options_.depth.particles;
  if (options_.depth.first_sight != FirstSight::particles)
    return landmarks_.empty() ? missing : std::min(missing, kInitializedPerFrame);
  if (state.velocity().norm() < particles.minimum_speed_m_s) return 0;
  const auto lines = std::count_if(landmarks_.begin(), landmarks_.end(), is_line);
  return std::min(missing, particles.at_once - static_cast<int>(lines));
}

/// Makes room for one landmark. Returns false if all landmarks are in view at t.
bool Map::make_room(Stamp t, Kalman& kalman, std::vector<int>& deleted) {
  while (landmarks_.size() >= static_cast<std::size_t>(options_.bounds.landmarks)) {
    auto worst = landmarks_.end();
    for (auto it = landmarks_.begin(); it != landmarks_.end(); ++it)
      if (it->last_visible < t && !is_line(*it) &&
          (worst == landmarks_.end() || it->successes < worst->successes))
        worst = it;
    if (worst == landmarks_.end()) return false;
    deleted.push_back(worst->id);
    erase(static_cast<std::size_t>(worst - landmarks_.begin()), kalman);
  }
  return true;
}

InitializationCount Map::initialize(const cv::Mat& image, const DepthImage& depth, Stamp t,
                                    const std::vector<Eigen::Vector2d>& visible, Kalman& kalman,
                                    std::vector<int>& deleted, bool on_trial) {
  const State& state = kalman.state();
  const int wanted = number_wanted(visible.size(), state);
  if (visible.size() >= kFewVisible) corner_share_ = 1;
  occupied_ = visible;
  for (const Landmark& landmark : landmarks_) {
    if (!is_line(landmark)) continue;
    const Parameters y = landmark.parameters(state);
    const Direction d = direction(landmark.kind, y, state.position(), state.orientation());
    if (const auto mean = camera_.project(d.h_C)) occupied_.push_back(mean->pixel);
  }
  for (const Eigen::Vector3d& p_W : sliding_)
    if (const auto mean = camera_.project(state.X_WC().inverse() * p_W)) occupied_.push_back(mean->pixel);
  int added = 0;
  for (int proposals = 0; added < wanted && proposals < kProposals * wanted; ++proposals) {
    const auto corner = propose_corner(image, occupied_, options_.vision, random_, corner_share_);
    if (!corner) continue;
    occupied_.push_back(corner->cast<double>());
    if (!make_room(t, kalman, deleted)) return {0, added};
    auto landmark = initialize_landmark(image, depth, t, *corner, camera_, options_, kalman);
    if (!landmark) continue;
    landmark->on_trial = on_trial;
    add(std::move(*landmark));
    ++added;
  }
  if (wanted > 0 && added == 0 && visible.size() < kFewVisible) corner_share_ *= kWeaker;
  return {wanted, added};
}

void Map::end_trial(bool passed, Kalman& kalman, std::vector<int>& deleted) {
  for (std::size_t i = landmarks_.size(); i-- > 0;) {
    if (!std::exchange(landmarks_[i].on_trial, false) || passed) continue;
    deleted.push_back(landmarks_[i].id);
    erase(i, kalman);
  }
}

bool Map::initialize_known(const cv::Mat& image, Stamp t, Kalman& kalman) {
  bool all_seen = true;
  if (std::exchange(known_initialized_, true)) return all_seen;
  for (const Eigen::Vector3d& p_W : options_.known_landmarks.at_m) {
    auto landmark = initialize_known_landmark(image, t, p_W, camera_, options_, kalman);
    all_seen = all_seen && landmark;
    if (landmark) add(std::move(*landmark));
  }
  return all_seen;
}

void Map::load(const SavedMap& map, Kalman& kalman) {
  session_ = map.sessions + 1;
  Eigen::VectorXd null_yaw = Eigen::VectorXd::Zero(map.x.size());
  for (const Landmark& l : map.landmarks) {
    null_yaw.segment<3>(l.at) = Eigen::Vector3d::UnitZ().cross(map.x.segment<3>(l.at));
    if (std::holds_alternative<InverseDepth>(l.kind)) null_yaw(l.at + 3) = 1;
  }
  const int first = kalman.append_map(map.x, map.P, null_yaw);
  const double angle = options_.vision.match_bias_sigma_px / camera_.intrinsics().fu_px;
  for (const Landmark& saved : map.landmarks) {
    Landmark& landmark = landmarks_.emplace_back(saved);
    landmark.at += first;
    landmark.initialized = landmark.last_visible = landmark.last_search = kEarlierSession;
    next_id_ = std::max(next_id_, landmark.id + 1);
    inflate(landmark, angle, landmark.X_WC_first.translation(), kalman);
  }
}

SavedMap Map::saved(const State& state) const {
  SavedMap map{session_, camera_.intrinsics(), {}, {}, {}};
  std::vector<int> indices;
  for (const Landmark& landmark : landmarks_) {
    if (is_line(landmark) || landmark.on_trial) continue;
    map.landmarks.push_back(landmark);
    map.landmarks.back().at = static_cast<int>(indices.size());
    for (int i = 0; i < landmark.size(); ++i) indices.push_back(landmark.at + i);
  }
  map.x = state.storage_x(indices);
  map.P = state.P()(indices, indices);
  return map;
}

void Map::clear(Kalman& kalman) {
  while (!landmarks_.empty()) erase(landmarks_.size() - 1, kalman);
  sliding_.clear();
  session_ = 1;
}

void Map::record_search(std::size_t index, const Search& search, bool counts, Stamp t, const Kalman& kalman) {
  Landmark& landmark = landmarks_[index];
  const State& state = kalman.state();
  const bool success = search.used;
  const bool again = landmark.is_set_aside(state);
  landmark.last_search = t;
  if (success || landmark.misses == 0 || landmark.is_seen_anew(state)) {
    landmark.misses = 0;
    landmark.p_WC_missed = state.position();
  }
  if (!success) ++landmark.misses;
  if (success) ++landmark.successes, landmark.last_session = session_;
  if (counts && (success || !again)) ++landmark.attempts;
  if (!counts || !success || kalman.considers(landmark.at)) return;  // errors of those considered last
  const Eigen::Array2d innovation = *search.match - search.pixel;
  landmark.drift = kDriftMemory * landmark.drift.array() + innovation / search.S.diagonal().array().sqrt();
  landmark.drift_count = kDriftMemory * kDriftMemory * landmark.drift_count + 1;
}

void Map::inflate_for_view_change(std::size_t index, Kalman& kalman) {
  Landmark& landmark = landmarks_[index];
  const State& state = kalman.state();
  const double distance = (position(landmark.kind, landmark.parameters(state)) - state.position()).norm();
  const double change = (state.position() - landmark.p_WC_inflated).norm() / distance;
  if (change < kLeastViewChange) return;
  landmark.p_WC_inflated = state.position();
  if (visits_ > 2 && kalman.considers(landmark.at)) return;
  const double angle = options_.vision.viewpoint_sigma_px / camera_.intrinsics().fu_px * std::sqrt(change);
  inflate(landmark, angle, state.position(), kalman);
}

void Map::consider_known(Stamp t, Kalman& kalman) {
  if (!(options_.vision.match_bias_sigma_px > 0)) return;
  const Eigen::Isometry3d X_WC = kalman.state().X_WC();
  const auto is_here = [&](const Place& place) {
    return (X_WC.translation() - place.p_WC).norm() < kPlace_m &&
           X_WC.linear().col(2).dot(place.axis) > kPlaceDirection;
  };
  auto place = std::find_if(places_.begin(), places_.end(), is_here);
  if (place == places_.end())
    place = places_.insert(place, {X_WC.translation(), X_WC.linear().col(2), t,
                                   session_ > 2 ? kEarlierSession : Stamp::min(), session_});
  if (t - place->last > kAway) place->known = place->last, ++place->visits;
  place->last = t;
  visits_ = place->visits;
  kalman.consider(0, 0);
  const auto later = std::find_if(landmarks_.begin(), landmarks_.end(),
                                  [&](const Landmark& l) { return l.initialized > place->known; });
  if (later != landmarks_.begin())
    kalman.consider(landmarks_[0].at, later == landmarks_.end() ? kalman.state().size : later->at);
}

void Map::refine_surface(std::size_t index, const cv::Mat& image, const Eigen::Vector2d& pixel,
                         const State& state) {
  if (!options_.vision.warped_patches || !options_.vision.estimate_normals) return;
  landmarks_[index].tilt = refined_tilt(image, landmarks_[index], pixel, camera_, state);
}

void Map::convert_to_points(Stamp t, Kalman& kalman) {
  if (!(options_.depth.linearity > 0)) return;
  for (Landmark& landmark : landmarks_) {
    const State& state = kalman.state();
    if (!std::holds_alternative<InverseDepth>(landmark.kind)) continue;
    const Vector6d y = state.storage_x.segment<6>(landmark.at);
    const double index = linearity_index(y, inverse_depth_sigma(state, landmark), state.position());
    if (!(index < options_.depth.linearity * (landmark.last_visible < t ? kOutOfView : 1))) continue;
    make_point(landmark, position(landmark.kind, y), position_jacobian(landmark.kind, y), kalman);
  }
}

void Map::make_point(Landmark& landmark, const Eigen::Vector3d& p_W,
                     const Eigen::Ref<const Eigen::MatrixXd>& J, Kalman& kalman) {
  const int size = landmark.size();
  kalman.replace(landmark.at, size, p_W, J);
  landmark.kind = Point{};
  for (Landmark& later : landmarks_)
    if (later.at > landmark.at) later.at -= size - Point::kSize;
}

void Map::search_lines(const cv::Mat& image, Kalman& kalman, std::vector<int>& deleted,
                       std::vector<DepthHypotheses>& lines) {
  for (std::size_t i = landmarks_.size(); i-- > 0;) {
    Landmark& landmark = landmarks_[i];
    if (!is_line(landmark)) continue;
    search_line(image, kalman, camera_, options_.vision, landmark);
    const auto line = std::get<SemiInfiniteLine>(landmark.kind);
    lines.push_back({landmark.id, line.particles});
    const Options::Depth::Particles& options = options_.depth.particles;
    const DepthMoments depth = depth_moments(line.particles);
    if (static_cast<int>(line.particles.size()) < options.fewest || line.attempts > options.attempts) {
      deleted.push_back(landmark.id);
      erase(i, kalman);
    } else if (depth.sigma_m < options.converged * depth.mean_m) {
      const Parameters y = landmark.parameters(kalman.state());
      make_point(landmark, position(line, y), position_jacobian(line, y), kalman);
      kalman.inflate(landmark.at,
                     depth.sigma_m * depth.sigma_m * y.segment<3>(3) * y.segment<3>(3).transpose());
    }
  }
}

/// Records a deleted young landmark. Returns false if another was deleted recently in the same direction as
/// seen from r.
bool Map::is_bad_anew(const Pruned& pruned, const Eigen::Vector3d& r) {
  std::erase_if(pruned_, [&](const Pruned& before) { return pruned.t - before.t > kBadCorner; });
  const bool known = std::any_of(pruned_.begin(), pruned_.end(), [&](const Pruned& before) {
    return (before.p_W - r).normalized().dot((pruned.p_W - r).normalized()) > kSameDirection;
  });
  pruned_.push_back(pruned);
  return !known;
}

std::size_t Map::prune(Kalman& kalman, std::vector<int>& deleted) {
  std::size_t young = 0;
  for (std::size_t i = landmarks_.size(); i-- > 0;) {
    const Landmark& landmark = landmarks_[i];
    const bool judged = landmark.attempts >= 10 || landmark.misses >= Landmark::kMostMisses;
    const bool unreliable = judged && 2 * landmark.successes < landmark.attempts;
    if (!unreliable && !landmark.slides() && !surely_behind(kalman.state(), landmark)) continue;
    deleted.push_back(landmark.id);
    const State& state = kalman.state();
    const Eigen::Vector3d p_W = position(landmark.kind, landmark.parameters(state));
    if (landmark.slides()) {
      if (sliding_.size() == kRoom) sliding_.erase(sliding_.begin());
      sliding_.push_back(p_W);
    } else if (landmark.last_visible - landmark.initialized < kYoung &&
               is_bad_anew({p_W, landmark.last_visible}, state.position())) {
      ++young;
    }
    erase(i, kalman);
  }
  return young;
}

void Map::erase(std::size_t index, Kalman& kalman) {
  const int at = landmarks_[index].at, size = landmarks_[index].size();
  kalman.erase(at, size);
  landmarks_.erase(landmarks_.begin() + static_cast<std::ptrdiff_t>(index));
  for (Landmark& later : landmarks_)
    if (later.at > at) later.at -= size;
}

}  // namespace slam
