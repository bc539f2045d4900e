// The physics: the robot in its room (moved only by its joint servos), its sensor readings and its true pose.
#pragma once

#include <array>
#include <chrono>

#include "sim/controllers/controller.h"
#include "sim/physics/clearance.h"
#include "sim/physics/model.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/options.h"
#include "sim/physics/robot.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace sim::physics {

/// A point of the floor.
struct FloorPoint {
  double z = 0;  ///< m
  int geom = -1;
};

/// All shapes of a model that do not move: planes, boxes, height fields and other primitives. The model must
/// outlive this object.
class Floor {
 public:
  explicit Floor(const mjModel_& on_floor);

  /// Returns whether the floor is the plane z = 0 with the robot's own friction.
  bool is_plain() const { return plain_; }
  /// Returns the highest point of the floor at a place, or nothing off the floor. Positions in `data` must
  /// have been computed.
  std::optional<FloorPoint> at(const mjData_& data, const Eigen::Vector2d& p_W) const;
  /// Returns at().z, or 0 off the floor.
  double height(const mjData_& data, const Eigen::Vector2d& p_W) const;
  /// Returns the sliding friction of the floor at a place, relative to the robot's.
  double friction(const mjData_& data, const Eigen::Vector2d& p_W) const;
  /// Returns how many shapes are neither planes nor height fields.
  std::size_t solids() const;

 private:
  const mjModel_& model_;
  std::vector<int> geoms_;
  bool plain_ = false;
};

/// Many solid shapes make each physics step slow, because each is compared with each contact of the robot.
inline constexpr std::size_t kMostSolids = 100;

/// The slope and the edges that the built-in controller walks with `slope: true`: 7 degrees. On 8 and on 3 cm
/// it falls.
inline constexpr double kSteepest_deg = 7.5, kHighestEdge_m = 0.02;

/// A planned footstep onto a place where the floor is not z = 0, or is too steep.
struct UnevenStep {
  double t_s = 0;
  int command = 0;  ///< index into WalkOptions::commands
  bool left = false;
  std::string geom;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< on the floor
};

/// Returns the plan's first footstep onto such a place. P is W. slopes: only if it is too steep.
std::optional<UnevenStep> first_uneven_step(walking::PatternGenerator plan, const Model& on_floor,
                                            bool slopes = false);

/// Load and creep of one foot over an interval. Creep is motion within the friction cone: MuJoCo's softened
/// friction allows it, but a real sole would not creep. Sliding beyond the cone is not included.
struct SoleContact {
  double load = 0;                                  ///< N, mean vertical force
  Eigen::Vector2d creep = Eigen::Vector2d::Zero();  ///< m in W, mean of the pads in contact
  double creep_yaw = 0;                             ///< rad
};

/// The contacts of a robot's soles with its floor.
class Soles {
 public:
  /// Finds the pads: geoms of the feet that touch the floor.
  Soles(mjModel_& model, double friction, std::vector<FloorPatch> patches, std::vector<FloorWave> waves);

  /// Gives each pad the friction and unevenness of the floor below it: on a bump a pad is longer by the
  /// bump's height. The slopes of these bumps (below 1 %) are neglected.
  void apply_floor(mjModel_& model, const mjData_& data) const;

  const Floor& floor() const { return floor_; }

  /// Returns the height of the lowest pad above the floor, m.
  double lowest_pad(const mjModel_& model, const mjData_& data) const;

  /// Adds load and creep of this step. Call it after the step's contact forces have been computed.
  void add_contact_forces(const mjModel_& model, const mjData_& data);

  /// Returns load and creep since the last call: left sole, right sole.
  std::array<SoleContact, 2> since_last();

 private:
  struct Pad {
    int geom = 0, foot = 0;  // foot: 0 left, 1 right
    double z = 0;            // in the sole's frame, on an even floor
  };
  void add_contact_forces(const mjModel_& model, const mjData_& data, std::size_t foot);

  Floor floor_;
  std::vector<Pad> pads_;
  double friction_;
  std::vector<FloorPatch> patches_;
  std::vector<FloorWave> waves_;
  std::array<SoleContact, 2> sum_;
  int steps_ = 0;
};

/// The sliding friction at a point (m, in W).
double friction_at(const Eigen::Vector2d& p_W, double elsewhere, const std::vector<FloorPatch>& patches);

/// The floor's height at a point, m.
double height_at(const Eigen::Vector2d& p_W, const std::vector<FloorWave>& waves);

/// Attitude and velocity of the IMU (axes G) at one instant.
struct ImuState {
  std::chrono::nanoseconds t{0};
  Eigen::Matrix3d R_WG = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v_WG = Eigen::Vector3d::Zero();  ///< m/s in W
};

/// Means over (begin, end], in the axes that G has after half of the turn.
struct ImuReading {
  std::chrono::nanoseconds begin{0}, end{0};
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();            ///< rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s², +g up at rest
};

/// Returns the reading that integrates exactly from one state to the next, like an IMU with internal sculling
/// compensation: gyro = Log(R_0ᵀ R_1)/dt, specific force = R_½ᵀ ((v_1 − v_0)/dt − g), R_½ = R_0 Exp(½
/// Log(R_0ᵀ R_1)). For an empty interval it is zero. gravity: m/s² in W.
ImuReading reading_between(const ImuState& from, const ImuState& to, const Eigen::Vector3d& gravity);

/// Condition of the robot. All but `ok` are final. `collided`: one foot touched the other, or the robot
/// touched something in the room other than its floor.
enum class Condition { ok, fell, collided, physics_failed };
struct Status {
  Condition condition = Condition::ok;
  std::string cause;  ///< cause of any condition other than ok
};

/// One robot in one room. Only contact, gravity and the servos act on it; if it touches the room, the walk
/// ends. World W: x ahead and z up, under the robot's waist at the start of the plan.
class World {
 public:
  /// The robot stands at the joint angles that its encoders read as q. Its waist is at X_WB, moved vertically
  /// until the lower pad of a sole touches the floor (z = 0 except for unevenness).
  World(const WorldOptions& options, const PlantVariation& draw, const walking::JointVector& q,
        const Eigen::Isometry3d& X_WB, const Models& models);

  /// Sets the servos' targets until the next command. Gains, if given, stay in effect after that.
  void command(const controllers::JointCommands& commands);

  /// Fixes the waist at X_WB, at rest, until release(), while the joints move.
  void hold(const Eigen::Isometry3d& X_WB) { held_ = X_WB; }
  void release() { held_.reset(); }

  /// Weight of the robot, N.
  double weight() const;

  /// Makes contact between the feet like any other contact: it no longer ends the walk.
  void let_feet_touch() { feet_may_touch_ = true; }

  /// Advances the physics by 1 ms. Afterwards, positions and sensors apply to the new time.
  const Status& step();

  const Status& status() const { return status_; }
  std::chrono::nanoseconds time() const { return time_; }

  /// Makes now t = 0: readings and contacts are counted from here, and the pushes follow this clock.
  void start_clock(std::vector<Push> pushes);

  /// Returns the encoders' readings and the wrenches on the soles at the end of the last tick, from force
  /// sensors or else from the legs' torques; no IMU.
  walking::SensorReadings leg_readings() const;

  /// Poses of the head camera (optical axes: x right, y down, z ahead) and the chest IMU, from the encoders.
  struct Mounts {
    Eigen::Isometry3d X_BC, X_CG;
  };
  Mounts mounts_by_encoders() const;

  /// Velocities (rad/s) and torques (N·m) of the joints.
  walking::JointVector velocities() const;
  walking::JointVector torques() const;

  /// Returns readings for the stabilizer, with gyro and accelerometer as means since the last call (or the
  /// start). Readings of a moved IMU are turned into the chest's axes by its mount and the encoders.
  walking::SensorReadings sensor_readings();

  /// Gyro and accelerometer as means since the last call of imu_since_last() (or the start).
  ImuReading imu_since_last() { return reading_since(last_recorded_); }

  /// Load and creep of the left and the right sole since the last call (or the start).
  std::array<SoleContact, 2> sole_contacts_since_last() { return soles_.since_last(); }

  /// Returns whether the torque of a leg's joint has been at its limit since the last call (or the start), or
  /// nothing if the robot has no limits.
  std::optional<bool> torque_limited_since_last();

  /// True poses in W. This is ground truth: only for the score, never for the filter, stabilizer or plan.
  Eigen::Isometry3d X_WB() const;                                     ///< waist
  Eigen::Isometry3d X_WC() const { return camera_in_world(*data_); }  ///< head camera, optical axes
  Eigen::Isometry3d X_WG() const { return X_WS(ids_.imu); }           ///< chest IMU
  Eigen::Vector3d v_WG() const { return imu_state().v_WG; }           ///< velocity of the chest IMU, m/s in W
  Eigen::Isometry3d X_WL() const { return X_WS(ids_.sole[0]); }       ///< left sole, below the ankle
  Eigen::Isometry3d X_WR() const { return X_WS(ids_.sole[1]); }       ///< right sole
  Eigen::Isometry3d X_W(const Place& place) const;                    ///< axes forward, left, up of a sensor
  ImuState imu_state(const Place& place) const;                       ///< state of an additional IMU
  Eigen::Vector3d gravity() const;                                    ///< m/s² in W
  Eigen::Vector3d com() const;                                        ///< center of mass of the whole robot

  /// For the renderer only.
  const mjModel_* model() const { return model_.get(); }
  const mjData_* data() const { return data_.get(); }

 private:
  struct Ids {
    int waist = 0, camera = 0, imu = 0;
    std::array<int, 2> sole{}, foot{}, force{}, torque{};  // left, right; the last two in sensordata
    std::vector<int> position, velocity, body;             // by joint
  };

  void find_ids();
  void apply(const PlantVariation& draw);
  void place(const walking::JointVector& q, const Eigen::Isometry3d& X_WB);
  void push();
  void limit_torques();
  double damping_torque(int joint) const;
  double added_torque(int joint) const;
  void place_held();
  std::string fall_text(const Eigen::Isometry3d& X_WB) const;
  Status check() const;
  void look_around();
  ImuState imu_state() const;
  ImuReading reading_since(ImuState& last) const;  // and updates `last`
  Eigen::Isometry3d X_WS(int site) const;
  walking::Wrench wrench(std::size_t foot) const;
  const mjData_& pose_by_encoders(const walking::JointVector& encoders) const;
  Eigen::Matrix3d imu_in_chest(const walking::JointVector& encoders) const;
  Eigen::Isometry3d camera_in_world(const mjData_& data) const;

  walking::Robot robot_;
  Model model_;
  Data data_;
  Ids ids_;
  Soles soles_;
  std::optional<RoomClearance> room_;      // absent if the room is a bare floor
  std::chrono::nanoseconds next_look_{0};  // nothing can touch the room before this time
  std::vector<Push> pushes_;
  double floor_friction_;
  walking::JointVector offset_;                              // true angle minus the encoder's
  Eigen::VectorXd servo_scale_;                              // factor of each servo's gain; empty: 1
  walking::JointVector desired_velocity_, target_velocity_;  // rad/s; the last command's, the target's
  std::optional<Eigen::Isometry3d> held_;
  std::chrono::nanoseconds time_{0};
  Status status_;
  bool at_limit_ = false, feet_may_touch_ = false, settling_ = true;  // settling_: before start_clock()
  struct {
    double value = 0;
    int joint = 0;
  } largest_share_;  // largest torque relative to its limit since the start
  std::vector<int> limited_ms_ =
      std::vector<int>(robot_.joints.size());  // by joint: time with its torque at the limit since the start
  std::optional<LegLoads> leg_loads_;          // for robots without force sensors
  Data by_encoders_;                           // work space of pose_by_encoders()
  std::optional<Eigen::Matrix3d> R_HG_;  // a moved IMU in the chest's frame at the last sensor_readings()
  ImuState last_read_, last_recorded_;   // at the last call of sensor_readings() and imu_since_last()
};

}  // namespace sim::physics
