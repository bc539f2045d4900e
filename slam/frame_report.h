// What the filter gives: the estimated pose, a report of each step, and the map.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slam/depth_hypotheses.h"
#include "slam/observation.h"
#include "slam/state.h"

namespace slam {

/// The estimated pose of the camera. The covariance is that of the error in the order (orientation,
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

/// The normalised innovation squared (NIS) of one sensor in one frame, its degrees of freedom, and ln |S| of
/// the innovation covariance S.
struct Nis {
  double value = 0;
  int dof = 0;
  double log_determinant = 0;
};

/// By systematic error (kPlanScale, kLensDistortion, kLegScale).
using Evidence = std::array<SystematicEvidence, kSystematicErrors>;

/// Where a landmark was searched for.
struct Search {
  int landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< predicted, px
  Eigen::Matrix2d S =
      Eigen::Matrix2d::Zero();  ///< innovation covariance, px²; the 3-sigma ellipse is searched
  bool used = false;            ///< its match entered the update
  std::optional<Eigen::Vector2d> match = std::nullopt;  ///< where it was found, px; refused by the gates unless used
};

/// The filter tracks (ok); its images no longer fit its map, which it tries to recognise (lost); or it is
/// broken and refuses all further observations (diverged).
enum class Health { ok, lost, diverged };

/// What one step did.
struct FrameReport {
  Stamp t{0};
  int landmarks = 0;                                       ///< in the map after the step
  int predicted = 0;                                       ///< predicted to be visible
  int measured = 0;                                        ///< searched for and found by correlation
  int accepted = 0;                                        ///< passed the gates and entered the update
  std::optional<Nis> vision, gyro, plan_velocity, height;  ///< absent where the sensor gave no measurement
  std::optional<Nis> update;          ///< of the accepted matches, with the noise that the update assumes
  std::vector<Sighting> initialised;  ///< landmarks initialised in this frame, where they were first seen
  std::vector<Sighting> matched;      ///< accepted matches of this frame
  std::vector<Search> searched;
  std::vector<DepthHypotheses> lines;  ///< landmarks that were lines before this frame, after its image
  std::vector<int> deleted;
  Evidence evidence{};  ///< what this frame's innovations say of systematic errors
  bool relocalised = false;  ///< the map was recognised in this frame
  std::string refused;       ///< why the observation or parts of it were not used; empty if all was used
  Health health = Health::ok;
  std::string cause;  ///< why the health is not ok
  /// The sensor whose measurements are not what the filter is told of it, and in what way: "inconsistent:
  /// plan, ...", "inconsistent: leg odometry, ...", "inconsistent: gyro, ..." or "inconsistent: images, ...";
  /// empty if there is none.
  std::string suspect;
};

/// Appends a reason to a list of reasons separated by "; ".
inline void add_reason(std::string& reasons, std::string_view reason) {
  if (!reasons.empty()) reasons += "; ";
  reasons += reason;
}

/// A landmark of the map.
struct MapPoint {
  int id = 0;
  std::string kind;                                      ///< "point", "inverse_depth" or "line"
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m², axes W
  Stamp initialised{0};
  int attempts = 0, successes = 0;  ///< searches for it, and those whose match was accepted
};

}  // namespace slam
