// The EKF: observations in, pose and map out. Read step() first: it is the paper's section III on one page.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/depth_hypotheses.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Where the filter believes the camera is. covariance: 6x6, order (orientation, position) of the error
/// (Log(R_WC_estimateᵀ R_WC_true) in rad, axes C; p_true − p_estimate in m, axes W).
struct Estimate {
  Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();
};

/// A landmark's place in an image.
struct Sighting {
  int landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< (u, v) in px
};

/// Normalised innovation squared of one sensor in one frame, with its degrees of freedom, and ln |S| of the
/// innovation's covariance.
struct Nis {
  double value = 0;
  int dof = 0;
  double log_determinant = 0;
};

/// Where a landmark was looked for.
struct Search {
  int landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< predicted, px
  Eigen::Matrix2d S = Eigen::Matrix2d::Zero();  ///< of the innovation, px²: the ellipse searched is 3 sigma
  bool used = false;                            ///< its match entered the update
};

/// ok; or lost: the images no longer fit the map, and the map is looked for in them; or the filter has found
/// itself broken and takes no more observations.
enum class Health { ok, lost, diverged };

/// What one step did.
struct FrameReport {
  Stamp t{0};
  int landmarks = 0;                                       ///< in the map after the step
  int predicted = 0;                                       ///< predicted to be visible
  int measured = 0;                                        ///< searched for and found by correlation
  int accepted = 0;                                        ///< passed the gates and entered the update
  std::optional<Nis> vision, gyro, plan_velocity, height;  ///< absent where the sensor gave nothing
  std::optional<Nis> update;      ///< of the accepted matches, by the noise that the update expects of them
  std::vector<Sighting> begun;    ///< landmarks begun in this frame, where they were first seen
  std::vector<Sighting> matched;  ///< accepted matches of this frame
  std::vector<Search> searched;
  std::vector<DepthHypotheses> lines;  ///< of landmarks that were lines before this frame, after its image
  std::vector<int> deleted;
  bool relocalised = false;  ///< found again in this frame
  std::string refused;       ///< why the observation (or one of its parts) was not used; empty if it was
  Health health = Health::ok;
  std::string cause;  ///< of a health other than ok
};

/// A landmark as the map has it.
struct MapPoint {
  int id = 0;
  std::string kind;                                      ///< "point", "inverse_depth" or "line"
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m², axes W
  Stamp begun{0};
  int attempts = 0, successes = 0;
};

/// The filter. Copies nothing it is not given, reads no clock, draws random numbers only from its own seeded
/// stream.
class Filter {
 public:
  /// Begins at X_WC_start (the planned camera pose at the start) with the options' start covariance. Throws
  /// std::invalid_argument where options or calibration make no sense.
  Filter(const Options& options, const Calibration& calibration, const Eigen::Isometry3d& X_WC_start,
         std::uint64_t seed);
  ~Filter();
  Filter(Filter&&) noexcept;
  Filter& operator=(Filter&&) noexcept;

  /// Takes one observation in: predict, internal measurements, active search, update, manage the map.
  /// An observation that goes back in time or is malformed is refused (report.refused) and changes nothing.
  const FrameReport& step(const Observation& observation);

  const Estimate& estimate() const;
  std::vector<MapPoint> map() const;

 private:
  struct Workings;
  std::unique_ptr<Workings> workings_;
};

}  // namespace slam
