// The input of the score: truth, plan and estimate of one run at the stamps of the frames, and what several
// metrics need of them: the drift of the walk by its feet, and the landmarks against the true room.
#pragma once

#include <array>
#include <functional>
#include <string_view>

#include "sim/score/statistics.h"
#include "sim/score/trajectory.h"
#include "sim/score/types.h"

namespace sim::score {

/// Returns the ground part of a nearly upright pose: x, y (m) and yaw (rad).
Eigen::Vector3d ground_pose(const Eigen::Isometry3d& X);

/// The origin of a contribution.
enum class FootPhase {
  start,     ///< the robot starts beside the plan's start
  put_down,  ///< the foot first touches the ground beside its planned place, as seen from the other foot
  landing,   ///< it moves on the ground before it first carries 40 % of the weight
  support,   ///< until it last carries that much
  lift_off,  ///< until it leaves the ground
  body,      ///< at the end the waist is beside its planned place over the foot
};
inline constexpr std::array<std::string_view, 6> kFootPhases{"start",   "put_down", "landing",
                                                             "support", "lift_off", "body"};

/// One contribution (x m, y m, yaw rad). moved: motion of the point of the sole below the ankle, axes of W;
/// for put_down the true minus the planned place as seen from the other foot; for start and body as drift.
/// drift: the share of the waist's final drift, axes of W; zero for a foot that moves while the other one
/// carries the robot.
struct FootRow {
  Stamp begin{0}, end{0};
  bool left = false;  ///< foot
  FootPhase phase = FootPhase::support;
  Eigen::Vector3d moved = Eigen::Vector3d::Zero(), creep = moved, drift = moved;
};

/// Returns the contributions of a whole walk in order of time. samples: at least one, in order of time;
/// weight_n: of the robot; waist_truth, waist_plan: ground poses at the last.
std::vector<FootRow> decompose_drift(const std::vector<TrueFeet>& samples, double weight_n,
                                     const Eigen::Vector3d& waist_truth, const Eigen::Vector3d& waist_plan);

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
  std::vector<Eigen::Vector3d> grid;  ///< the same for pixels spread over the whole image
};

/// A landmark that was found again after the camera had been elsewhere.
struct LoopLandmark {
  int id = 0;
  Stamp found{0};  ///< its first match after that
};

/// A landmark of the filter's final map.
struct MappedPoint {
  int id = 0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< m
};

/// The sensors of Run::innovations, in its order. They are named as in
/// slam::SensorInnovation; the metrics nis_<sensor>_... and the columns of frames.csv follow.
inline constexpr std::array kSensors{std::string_view("vision"), std::string_view("gyro"),
                                     std::string_view("plan_velocity"), std::string_view("height")};

/// The sensors of FrameUse, named as in slam::kSensorNames.
inline constexpr std::array kUsedSensors{std::string_view("vision"), std::string_view("gyro"),
                                         std::string_view("plan_velocity"), std::string_view("height"),
                                         std::string_view("accelerometer")};

/// The sensors with readings in the frame of that time, and those with readings that were used.
struct FrameUse {
  Stamp t{0};
  std::array<bool, kUsedSensors.size()> readings{}, accepted{};
  std::size_t searched = 0, found = 0;  ///< landmarks
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

/// How an estimator kept up with the frames, in simulated time.
struct Timeliness {
  std::vector<double> latency_ms;  ///< of each answer: from the stamp of its frame until it takes effect
  std::vector<double> took_ms;     ///< of each answer
  double period_ms = 0;            ///< of the frames
  std::size_t dropped = 0;         ///< frames
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
  bool truth_has_poses = true;              ///< else positions of the estimate's point, in another world
  Trajectory truth_waist, plan_waist;       ///< X_WB, X_PB
  std::optional<DesiredPath> desired;       ///< absent without a planned walk
  std::vector<StepCorrection> corrections;  ///< empty unless the walk was steered
  bool steered = false;
  std::vector<FootRow> feet;      ///< of decompose_drift(); empty without feet
  std::vector<TrueForce> forces;  ///< at equal distances; empty if they are not known
  /// Part of the ticks with a joint's torque at its limit; absent: the robot has no limits.
  std::optional<double> torque_limited;
  /// X_WC while it tracked, the covariance as in pose_nees(); absent: the estimator was not run.
  std::optional<std::vector<files::TumRow>> estimate;
  Trajectory
      odometry;  ///< by the same sensors without images; empty if that did not run beside the estimator
  Trajectory smoothed;  ///< the poses of the estimate, given all observations; empty without a smoother
  std::array<std::vector<StampedInnovation>, kSensors.size()> innovations;
  std::vector<FrameUse> use;             ///< of each answer; empty if the estimator does not report it
  std::vector<TimedHealth> health;       ///< after every observation; not tracking after a divergence
  std::optional<Timeliness> timeliness;  ///< absent without a time model
  std::vector<LandmarkHistory> landmarks;
  std::vector<MappedPoint> map;  ///< at the end
  std::vector<Surface> surfaces;
  TrueCamera camera;
  std::optional<Stamp> plan_end;
  std::optional<std::string> no_scale = {};    ///< the reason, if the estimate's scale is unknown
  std::optional<std::string> no_matches = {};  ///< the reason, if the estimator reports no landmarks
  std::optional<std::string> diverged;         ///< the cause, if the filter gave up
  std::optional<std::string> failed = {};      ///< the cause, if the estimator failed as a program
  bool fitted = false;   ///< to the truth by least squares: the NEES aligns the first poses instead
  double scaled_by = 1;  ///< by that fit
};

/// A run from the first planned motion on, with what several metrics need. The run must outlive it.
struct ScoreContext {
  explicit ScoreContext(const Run& run);

  const Run& run;
  std::optional<Stamp> start;         ///< the first frame with a planned waist more than 1 mm from its start;
                                      ///< without a planned waist the first frame with truth
  Trajectory truth_camera, estimate;  ///< from then on
  std::vector<PosePair> pairs;        ///< of these two
  OrAbsent<std::vector<PoseNees>> nees;      ///< of the pairs with a covariance
  std::optional<Absent> no_estimate;         ///< why the estimate cannot be scored, if it cannot
  OrAbsent<std::vector<LoopLandmark>> loop;  ///< of loop_landmarks()
};

inline constexpr std::size_t kLandmarksOfLoop = 3;  ///< found again, they close a loop

/// Returns the landmarks that were found again after the camera had been elsewhere, the first one first, or
/// why the walk has no loop. Elsewhere: the landmark's surface point, which is the first point of the room on
/// the ray through its first pixel, was out of the true camera's field of view for at least 5 s in one
/// stretch, and at a moment of it also every other point that the last image before the stretch shows. As
/// long as a part of that image stays in view, the map in view connects the two places. Found again: a match
/// within 3 px of the point's true projection was accepted after that. Occlusion does not matter.
OrAbsent<std::vector<LoopLandmark>> loop_landmarks(const Run& run);

/// Returns the distance (m) of each of the map's landmarks with a history from its surface point, see
/// loop_landmarks(), if it has one.
std::vector<double> landmark_errors(const Run& run);

}  // namespace sim::score
