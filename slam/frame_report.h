// The filter's output: the estimated pose, a report of each step, and the map.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "slam/observation.h"
#include "slam/state.h"

namespace slam {

/// The estimated pose of the camera. The covariance refers to the error, in the order (orientation,
/// position): Log(R_WC_estimateᵀ R_WC_true) in rad, axes C, and p_true − p_estimate in m, axes W.
struct Estimate {
  Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();
};

/// The place of a landmark in an image.
struct Sighting {
  int landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< (u, v), px
};

/// The normalized innovation squared (NIS) of one sensor in one frame, its degrees of freedom, and ln |S| of
/// the innovation covariance S = LLᵀ. lagged is the dot product of the whitened innovations L⁻¹ν of this
/// frame and the last one; lagged_square is the squared norm of this frame's. Both are 0 if the last frame
/// has none.
struct Nis {
  double value = 0;
  int dof = 0;
  double log_determinant = 0;
  double lagged = 0, lagged_square = 0;
};

/// The innovation of one sensor in one frame: "gyro" (unless it drives the motion model), "plan_velocity" and
/// "height" (which may also come from leg odometry), or "vision" (the matches that entered the update).
struct SensorInnovation {
  std::string_view sensor;
  Nis nis;
};

/// The NIS of a sensor; nothing if it is not among the innovations.
inline std::optional<Nis> nis_of(const std::vector<SensorInnovation>& innovations, std::string_view sensor) {
  for (const SensorInnovation& innovation : innovations)
    if (innovation.sensor == sensor) return innovation.nis;
  return std::nullopt;
}

/// The sensors of FrameReport::use, in its order.
inline constexpr std::array<std::string_view, 5> kSensorNames{"vision", "gyro", "plan_velocity", "height",
                                                              "accelerometer"};
enum class SensorIndex { vision, gyro, plan_velocity, height, accelerometer };

/// Whether an enabled sensor had readings in a frame, and whether they passed its gate and were used.
enum class SensorUse { none, readings, accepted };
using SensorUses = std::array<SensorUse, kSensorNames.size()>;

/// The evidence for each systematic error (kPlanScale, kLensDistortion, kLegScale).
using Evidence = std::array<SystematicEvidence, kSystematicErrors>;

/// The search for one landmark.
struct Search {
  int landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();      ///< predicted, px
  Eigen::Matrix2d S = Eigen::Matrix2d::Zero();          ///< innovation covariance, px²; 3-sigma ellipse
  bool used = false;                                    ///< its match entered the update
  std::optional<Eigen::Vector2d> match = std::nullopt;  ///< px; rejected by the gates unless used
};

/// One hypothesis of a landmark's distance along its line (Davison 2003; Stasse et al. 2006, Fig. 3).
struct DepthParticle {
  double depth_m, probability;
};

/// All hypotheses of one landmark that is still a line; their probabilities sum to 1.
struct DepthHypotheses {
  int landmark = 0;
  std::vector<DepthParticle> particles;
};

/// ok: the filter tracks. lost: its images no longer fit its map, and it searches for the map.
/// diverged: it failed and accepts no further observations.
enum class Health { ok, lost, diverged };

/// The use of a loaded map. searching: its pose is not known yet, and the estimate is in a local frame that
/// starts at the told pose. refused: it was not recognized, and a new map starts in the local frame.
enum class MapUse { none, searching, found, refused };

/// Capacity reserved in lists of landmarks, so that a step in the steady state takes no heap memory.
inline constexpr int kLandmarksInView = 64;

/// Reasons in words. Their memory is reused, so that adding one in the steady state takes no heap memory.
class Reasons {
 public:
  explicit operator bool() const { return !text_.empty(); }
  /// All reasons, separated by "; "; empty if there is none.
  const std::string& text() const { return text_; }
  void add(std::string_view reason) { text_.append(text_.empty() ? "" : "; ").append(reason); }
  void clear() { text_.clear(); }

 private:
  std::string text_;
};

/// The report of one step.
struct FrameReport {
  Stamp t{0};
  int landmarks = 0;                          ///< in the map after the step
  int predicted = 0;                          ///< predicted to be visible
  int measured = 0;                           ///< searched for and found by correlation
  int accepted = 0;                           ///< passed the gates and entered the update
  std::vector<SensorInnovation> innovations;  ///< one for each sensor that gave a measurement
  SensorUses use{};                           ///< by SensorIndex
  std::vector<Sighting> initialized;          ///< landmarks initialized in this frame, at their first pixels
  std::vector<Sighting> matched;              ///< accepted matches of this frame
  std::vector<Search> searched;
  std::vector<DepthHypotheses> lines;  ///< landmarks that were lines before this frame, after its image
  std::vector<int> deleted;
  Evidence evidence{};       ///< evidence of systematic errors in this frame's innovations
  bool relocalized = false;  ///< the pose was reset from the map in this frame
  Reasons refused;           ///< why the observation or parts of it were not used
  MapUse map = MapUse::none;
  Health health = Health::ok;
  std::optional<std::string> cause;  ///< why the health is not ok
  /// The sensor whose measurements contradict its model: "inconsistent: X, ...", where X is plan, leg
  /// odometry, gyro or images.
  std::optional<std::string> suspect;

  /// Notes that a sensor has readings in this frame, or that they are accepted.
  void note(SensorIndex sensor, SensorUse used) { use[static_cast<std::size_t>(sensor)] = used; }
  /// Starts the report of a step at t, reusing the memory of its lists.
  void begin(Stamp t);
};

/// A landmark of the map.
struct MapPoint {
  int id = 0;
  std::string kind;                                      ///< "point", "inverse_depth" or "line"
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m², axes W
  Stamp initialized{0};
  int attempts = 0, successes = 0;  ///< searches for it, and accepted matches
};

}  // namespace slam
