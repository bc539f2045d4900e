// The input of the score: truth, plan and estimate of one run at the stamps of the frames. Also quantities
// derived for several metrics: the walk's drift at the feet, and the landmarks compared with the true room.
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

/// The source of a contribution.
enum class FootPhase {
  start,     ///< the robot does not start at the plan's start
  put_down,  ///< the foot first touches the ground away from its planned place, as seen from the other foot
  landing,   ///< the foot moves on the ground until it first carries 40 % of the weight
  support,   ///< until it last carries that much
  lift_off,  ///< until it leaves the ground
  body,      ///< at the end, the waist is away from its planned place above the foot
};
inline constexpr std::array<std::string_view, 6> kFootPhases{"start",   "put_down", "landing",
                                                             "support", "lift_off", "body"};

/// One contribution (x m, y m, yaw rad). moved: motion of the sole's point below the ankle, axes of W; for
/// put_down, the true minus the planned place as seen from the other foot; for start and body the same as
/// drift. drift: contribution to the waist's final drift, axes of W; zero for a foot that moves while the
/// other one carries the robot.
struct FootRow {
  Stamp begin{0}, end{0};
  bool left = false;  ///< foot
  FootPhase phase = FootPhase::support;
  Eigen::Vector3d moved = Eigen::Vector3d::Zero(), creep = moved, drift = moved;
};

/// Returns the contributions of a whole walk in chronological order. samples: at least one, in chronological
/// order. weight_n: the robot's. waist_truth, waist_plan: ground poses at the last sample.
std::vector<FootRow> decompose_drift(const std::vector<TrueFeet>& samples, double weight_n,
                                     const Eigen::Vector3d& waist_truth, const Eigen::Vector3d& waist_plan);

/// The pixel of a landmark in one image.
struct StampedPixel {
  Stamp t{0};
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A landmark and its matches since its initialization.
struct LandmarkHistory {
  int id = 0;
  StampedPixel first_seen;
  std::vector<StampedPixel> accepted;  ///< matches that entered an update, in chronological order
};

/// The true camera.
struct TrueCamera {
  /// Returns the pixel of a point in W, or nothing if it is behind the camera or outside the image.
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W)>
      project;
  /// The unit vector in C along which a pixel looks.
  std::function<Eigen::Vector3d(const Eigen::Vector2d& pixel)> bearing;
  std::vector<Eigen::Vector3d> grid;  ///< bearings of pixels spread over the whole image
};

/// A landmark that was found again after the camera had been elsewhere.
struct LoopLandmark {
  int id = 0;
  Stamp found{0};  ///< first match after that
};

/// A landmark of the filter's final map.
struct MappedPoint {
  int id = 0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< m
};

/// The sensors of Run::innovations, in its order, with the names of slam::SensorInnovation. The metrics
/// nis_<sensor>_... and the columns of frames.csv use the same names.
inline constexpr std::array kSensors{std::string_view("vision"), std::string_view("gyro"),
                                     std::string_view("plan_velocity"), std::string_view("height")};

/// The sensors of FrameUse, with the names of slam::kSensorNames.
inline constexpr std::array kUsedSensors{std::string_view("vision"), std::string_view("gyro"),
                                         std::string_view("plan_velocity"), std::string_view("height"),
                                         std::string_view("accelerometer")};

/// The sensors with readings in the frame at that time, and the sensors whose readings were used.
struct FrameUse {
  Stamp t{0};
  std::array<bool, kUsedSensors.size()> readings{}, accepted{};
  std::size_t searched = 0, found = 0;  ///< number of landmarks
};

/// A sensor's normalized innovation squared in the frame at that time; lagged: see slam::Nis.
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

/// An estimator's timing relative to the frames, in simulated time.
struct Timeliness {
  std::vector<double> latency_ms;  ///< for each answer: from its frame's stamp until it takes effect
  std::vector<double> took_ms;     ///< for each answer
  double period_ms = 0;            ///< period of the frames
  std::size_t dropped = 0;         ///< number of frames
};

/// The use of a map of an earlier session.
struct LoadedMap {
  bool refused = false;                 ///< the estimator started a new map instead
  std::size_t matches = 0, reused = 0;  ///< number of accepted matches, and of matches with its landmarks
};

/// The commanded path, placed in W at the start.
struct DesiredPath {
  Trajectory waist;                                       ///< commanded X_WB at the stamps of the true waist
  Eigen::Isometry3d end = Eigen::Isometry3d::Identity();  ///< commanded X_WB at the end
  std::vector<std::pair<Stamp, Stamp>> laps;  ///< start and end of each lap, if the walk repeats commands
};

/// One run. W is the plan's world P at t = 0.
struct Run {
  Trajectory truth_camera, plan_camera;  ///< X_WC, X_PC
  bool truth_has_poses = true;           ///< false: positions of the estimate's point, in a different world
  Trajectory truth_waist, plan_waist;    ///< X_WB, X_PB
  std::optional<DesiredPath> desired;    ///< absent without a planned walk
  std::vector<StepCorrection> corrections;  ///< empty unless the walk was steered
  bool steered = false;
  std::vector<FootRow> feet;      ///< from decompose_drift(); empty without feet
  std::vector<TrueForce> forces;  ///< at equal intervals; empty if unknown
  /// Fraction of the ticks with the torque of a leg's joint at its limit; absent if the robot has no limits.
  std::optional<double> torque_limited;
  /// X_WC while the estimator tracked, with the covariance as in pose_nees(); absent if the estimator was not
  /// run.
  std::optional<std::vector<files::TumRow>> estimate;
  Trajectory odometry;  ///< from the same sensors without images; empty if not run along with the estimator
  Trajectory smoothed;  ///< the poses estimated from all observations; empty without a smoother
  std::array<std::vector<StampedInnovation>, kSensors.size()> innovations;
  std::vector<FrameUse> use;             ///< for each answer; empty if the estimator does not report it
  std::vector<TimedHealth> health;       ///< after every observation; not tracking after a divergence
  std::optional<Timeliness> timeliness;  ///< absent without a time model
  std::optional<LoadedMap> loaded_map = {};
  std::optional<std::size_t> map_bytes = {};  ///< size of the saved map
  std::vector<LandmarkHistory> landmarks;
  std::vector<MappedPoint> map;  ///< final map
  std::vector<Surface> surfaces;
  /// Returns the surfaces of people and doors that move, at a time; absent without any.
  std::function<std::vector<Surface>(Stamp t)> actors = {};
  TrueCamera camera;
  std::optional<Stamp> plan_end;
  std::optional<std::string> no_scale = {};    ///< why the estimate's scale is unknown, if so
  std::optional<std::string> no_matches = {};  ///< why the estimator reports no landmarks, if so
  std::optional<std::string> diverged;         ///< why the filter gave up, if so
  std::optional<std::string> failed = {};      ///< why the estimator failed as a program, if so
  bool fitted = false;   ///< fitted to the truth by least squares, so the NEES is computed after aligning the
                         ///< first poses
  double scaled_by = 1;  ///< scale factor of that fit
};

/// A run from its first planned motion, with what several metrics need. The run must outlive this object.
struct ScoreContext {
  explicit ScoreContext(const Run& run);

  const Run& run;
  std::optional<Stamp> start;         ///< the first frame with a planned waist more than 1 mm from its start;
                                      ///< without a planned waist, the first frame with truth
  Trajectory truth_camera, estimate;  ///< from then on
  std::vector<PosePair> pairs;        ///< pairs of these two
  OrAbsent<std::vector<PoseNees>> nees;      ///< for the pairs with a covariance
  std::optional<Absent> no_estimate;         ///< why the estimate cannot be scored, if so
  OrAbsent<std::vector<LoopLandmark>> loop;  ///< from loop_landmarks()
};

/// A loop is closed when this many landmarks are found again.
inline constexpr std::size_t kLandmarksOfLoop = 3;

/// Returns the landmarks that were found again after the camera had been elsewhere, the earliest first, or
/// why the walk has no loop. A landmark's surface point is the first point of the room on the ray through its
/// first pixel; a landmark on an actor has none. The camera was elsewhere if this point was out of the true
/// camera's field of view for at least 5 s without interruption and, at some moment of that time, so was
/// every other point seen in the last image before it. (As long as part of that image stays in view, the map
/// in view connects the two places.) The landmark was found again if, after that, a match within 3 px of the
/// point's true projection was accepted. Occlusion does not matter.
OrAbsent<std::vector<LoopLandmark>> loop_landmarks(const Run& run);

/// Returns the fraction of the camera's grid that shows actors from X_WC at a time. The run must have actors.
double moving_fraction(const Run& run, const Eigen::Isometry3d& X_WC, Stamp t);
/// Returns the fraction of the landmarks whose first pixel shows an actor; nothing without landmarks.
std::optional<double> moving_landmarks_fraction(const Run& run);

/// Returns, for each of the map's landmarks with a history, the distance (m) to its surface point if it has
/// one; see loop_landmarks().
std::vector<double> landmark_errors(const Run& run);

}  // namespace sim::score
