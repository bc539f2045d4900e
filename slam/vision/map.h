// The map: the list of landmarks and its management (Stasse et al. 2006, section III-A).
#pragma once

#include <cstdint>
#include <random>

#include "slam/saved_map.h"

namespace slam {

/// Adds a landmark seen at a pixel of the image to the state, with inverse depth or as a line with depth
/// particles. Returns nothing and leaves the state unchanged if the pixel has no ray. The id remains 0.
std::optional<Landmark> initialize_landmark(const cv::Mat& image, const DepthImage& depth, Stamp t,
                                            const Eigen::Vector2i& pixel, const Camera& camera,
                                            const Options& options, Kalman& kalman);

/// Adds a landmark of known position to the state if the image shows a corner within 3 sigma of its predicted
/// pixel. Otherwise returns nothing and leaves the state unchanged. The id remains 0.
std::optional<Landmark> initialize_known_landmark(const cv::Mat& image, Stamp t, const Eigen::Vector3d& p_W,
                                                  const Camera& camera, const Options& options,
                                                  Kalman& kalman);

/// Numbers of landmarks requested and initialized in a frame.
struct InitializationCount {
  int wanted = 0, added = 0;
};

/// The parameters of its landmarks are in the state of the Kalman filter that is passed to the methods.
class Map {
 public:
  Map(const Options& options, const Camera& camera, std::uint64_t seed);

  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  std::vector<MapPoint> points(const State& state) const;
  /// Initializes landmarks at corners away from the predicted pixels of visible landmarks, until as many are
  /// visible as the options request. New landmarks are at the end of landmarks(). In a full map, they replace
  /// landmarks out of view, starting with the ones found least often, whose ids are appended to `deleted`.
  /// While fewer than four are visible and no corner is found, weaker corners suffice from image to image.
  InitializationCount initialize(const cv::Mat& image, const DepthImage& depth, Stamp t,
                                 const std::vector<Eigen::Vector2d>& visible, Kalman& kalman,
                                 std::vector<int>& deleted, bool on_trial = false);
  /// Keeps the landmarks on trial if they passed. Otherwise deletes them, and appends their ids to `deleted`.
  void end_trial(bool passed, Kalman& kalman, std::vector<int>& deleted);
  /// Initializes the known landmarks in the first image. Returns false if one of them is not seen.
  bool initialize_known(const cv::Mat& image, Stamp t, Kalman& kalman);
  /// Adds the landmarks of earlier sessions to an empty map, inflated for the match errors of this session,
  /// which are those of its views again.
  void load(const SavedMap& map, Kalman& kalman);
  /// Returns the points and inverse depths. Lines, whose depth is unknown, are left out.
  SavedMap saved(const State& state) const;
  /// Deletes all landmarks; later ones are the first of a new map.
  void clear(Kalman& kalman);
  /// Records that a landmark is predicted to be visible at t.
  void record_visible(std::size_t index, Stamp t) { landmarks_[index].last_visible = t; }
  /// Records one search for a landmark. Failures do not count against it
  /// while it is set aside, or if `counts` is false because the image or the pose may be at fault.
  void record_search(std::size_t index, const Search& search, bool counts, Stamp t, const Kalman& kalman);
  /// Forgets the failed searches of a lost filter.
  void forget_misses() {
    for (Landmark& landmark : landmarks_) landmark.misses = 0;
  }
  /// Inflates the covariance of a measured landmark for the possible shift of its patch's apparent center due
  /// to the change of view since the last inflation (viewpoint_sigma_px). Considered landmarks are inflated
  /// during the second visit only, because their positions refer to the last view of the first.
  void inflate_for_view_change(std::size_t index, Kalman& kalman);
  /// Match errors are a function of the view, and a return to a place would count the same errors again.
  /// Therefore, landmarks that were in the map during the previous visit are only considered
  /// (Kalman::consider). Later ones are updated, which closes the loop. Does nothing if the options have no
  /// match bias.
  void consider_known(Stamp t, Kalman& kalman);
  /// Improves the surface normal of a landmark that was just found at `pixel`, if the options say so.
  void refine_surface(std::size_t index, const cv::Mat& image, const Eigen::Vector2d& pixel,
                      const State& state);
  /// Converts landmarks from inverse depth to points once their linearity index allows it. Landmarks that
  /// were last in view before t may be less linear.
  void convert_to_points(Stamp t, Kalman& kalman);
  /// Searches for the landmarks that are still lines. Lines whose depth has become precise turn into points.
  /// Lines that failed are deleted, and their ids are appended to `deleted`. The depths of all lines are
  /// appended to `lines`.
  void search_lines(const cv::Mat& image, Kalman& kalman, std::vector<int>& deleted,
                    std::vector<DepthHypotheses>& lines);
  /// Deletes landmarks that were searched for at least 10 times or are set aside, and that were found in less
  /// than half of the searches (Davison et al. 2007). Also deletes landmarks whose inverse depth is certainly
  /// negative. Appends the ids to `deleted`.
  /// Returns how many of them were last in view within 10 s of their first sighting, since older ones may be
  /// hidden now. A landmark does not count within 5 s of another in the same direction, since a bad corner
  /// may be chosen again and again.
  std::size_t prune(Kalman& kalman, std::vector<int>& deleted);

 private:
  int number_wanted(std::size_t visible, const State& state) const;
  bool make_room(Stamp t, Kalman& kalman, std::vector<int>& deleted);
  void add(Landmark landmark);
  void make_point(Landmark& landmark, const Eigen::Vector3d& p_W, const Eigen::Ref<const Eigen::MatrixXd>& J,
                  Kalman& kalman);
  void erase(std::size_t index, Kalman& kalman);

  struct Pruned {
    Eigen::Vector3d p_W;
    Stamp t;
  };
  bool is_bad_anew(const Pruned& pruned, const Eigen::Vector3d& r);

  /// A view of the map.
  struct Place {
    Eigen::Vector3d p_WC, axis;  ///< position of the camera and direction of its optical axis
    Stamp last, known;           ///< times of the latest frame here and of the last one of the previous visit
    int visits;
  };

  Options options_;
  Camera camera_;
  std::vector<Landmark> landmarks_;
  std::vector<Place> places_;
  int visits_ = 0;                        // to the present place
  std::vector<Pruned> pruned_;            // young landmarks deleted recently
  std::vector<Eigen::Vector3d> sliding_;  // positions of the last landmarks deleted because they slide
  int next_id_ = 0, session_ = 1;
  std::mt19937_64 random_;
  bool known_initialized_ = false;
  double corner_share_ = 1;                // of the threshold for corners
  std::vector<Eigen::Vector2d> occupied_;  // work space, kept so that initialize takes no heap memory
};

}  // namespace slam
