// The input of the score: truth, plan and estimate of one run at the stamps of the frames, and what several
// metrics need of them.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/score/consistency.h"
#include "sim/score/feet.h"
#include "sim/score/statistics.h"
#include "sim/score/surfaces.h"
#include "sim/score/trajectory.h"
#include "sim/score/types.h"

namespace sim::score {

/// The pixel of a landmark in one image.
struct StampedPixel {
  Stamp t{0};
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A landmark from its initialization on.
struct LandmarkHistory {
  int id = 0;
  StampedPixel first_seen;
  std::vector<StampedPixel> accepted;  ///< matches that entered an update, in order of time
};

/// The true camera.
struct TrueCamera {
  /// The pixel of a point in W; nothing if it is behind the camera or outside the image.
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W)>
      project;
  /// The unit vector in C along which a pixel looks.
  std::function<Eigen::Vector3d(const Eigen::Vector2d& pixel)> bearing;
};

/// An early landmark that was found again.
struct LoopLandmark {
  int id = 0;
  Stamp found{0};       ///< its first match that counts, anywhere on the path
  bool closes = false;  ///< also matched after three quarters of the turn
};

/// A landmark of the filter's final map.
struct MappedPoint {
  int id = 0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m², axes W
};

/// The estimated camera pose. covariance: see pose_nees; absent if the estimator states none.
struct EstimatedPose {
  Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  std::optional<Matrix6d> covariance = Matrix6d::Identity();
};

/// The sensors of Run::innovations, in its order. They are named as in
/// slam::SensorInnovation; the metrics nis_<sensor>_... and the columns of frames.csv follow.
inline constexpr std::array kSensors{std::string_view("vision"), std::string_view("gyro"),
                                     std::string_view("plan_velocity"), std::string_view("height")};

/// The sensors of FrameUse, named as in slam::kSensorNames.
inline constexpr std::array kUsedSensors{std::string_view("vision"), std::string_view("gyro"),
                                         std::string_view("plan_velocity"), std::string_view("height"),
                                         std::string_view("accelerometer")};

/// The sensors that had readings in the frame of that time, and those whose readings were used.
struct FrameUse {
  Stamp t{0};
  std::array<bool, kUsedSensors.size()> readings{}, accepted{};
};

/// One sensor's normalized innovation squared in the frame of that time; lagged: see slam::Nis.
struct StampedInnovation {
  Stamp t{0};
  double square = 0;
  int dof = 0;
  double lagged = 0, lagged_square = 0;
};

/// The state of the filter after an observation.
struct TimedHealth {
  Stamp t{0};
  bool tracks = true;       ///< neither lost nor diverged
  bool fault_flag = false;  ///< a sensor contradicts the others
};

/// The commanded path, laid into W at the start.
struct DesiredPath {
  Trajectory waist;                                       ///< commanded X_WB at the stamps of the true waist
  Eigen::Isometry3d end = Eigen::Isometry3d::Identity();  ///< commanded X_WB at the end
  std::vector<std::pair<Stamp, Stamp>> laps;  ///< start and end of each lap, if the walk repeats commands
};

/// One run. W is the plan's world P at t = 0.
struct Run {
  Trajectory truth_camera, plan_camera;     ///< X_WC, X_PC
  bool truth_has_poses = true;  ///< else positions of the estimate's point, in a world of their own
  Trajectory truth_waist, plan_waist;       ///< X_WB, X_PB
  std::optional<DesiredPath> desired;       ///< absent without a planned walk
  std::vector<StepCorrection> corrections;  ///< empty unless the walk was steered
  bool steered = false;
  std::vector<FootRow> feet;  ///< of decompose_drift(); empty without feet
  /// While it tracked; absent: the filter was not run.
  std::optional<std::vector<EstimatedPose>> estimate;
  Trajectory
      odometry;  ///< by the same sensors without images; empty if that did not run beside the estimator
  std::array<std::vector<StampedInnovation>, kSensors.size()> innovations;
  std::vector<FrameUse> use;        ///< of each answer; empty if the estimator does not report it
  std::vector<TimedHealth> health;  ///< after every observation; not tracking after a divergence
  std::vector<LandmarkHistory> landmarks;
  std::vector<MappedPoint> map;  ///< at the end
  std::vector<Surface> surfaces;
  TrueCamera camera;
  std::optional<Stamp> plan_end;
  std::optional<std::string> no_scale = {};    ///< the reason, if the estimate's scale is unknown
  std::optional<std::string> no_matches = {};  ///< the reason, if the estimator reports no landmarks
  std::optional<std::string> diverged;         ///< the cause, if the filter gave up
  std::optional<std::string> failed = {};      ///< the cause, if the estimator failed as a program
};

/// A run from the first planned motion on, with the quantities that several metrics need, computed once. The
/// run must outlive it.
struct ScoreContext {
  explicit ScoreContext(const Run& run);

  const Run& run;
  std::optional<Stamp> start;         ///< the first frame with a planned waist more than 1 mm from its start;
                                      ///< without a planned waist the first frame with truth
  Trajectory truth_camera, estimate;  ///< from then on
  std::vector<PosePair> pairs;        ///< of these two
  OrAbsent<std::vector<PoseNees>> nees;      ///< of the pairs with a covariance
  std::optional<Absent> no_estimate;         ///< why the estimate cannot be scored, if it cannot
  OrAbsent<std::vector<LoopLandmark>> loop;  ///< early landmarks that were found again
};

}  // namespace sim::score
