// Scenario keys of the simulated world, and the quantities drawn for each seed. The only header of
// sim/physics that sim/scenario includes.
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "sim/physics/actors.h"

namespace sim::physics {

/// Default sliding friction between sole and floor.
inline constexpr double kFloorFriction = 0.15;

/// A push against the waist: a constant horizontal force for some time.
struct Push {
  static constexpr const char* kName = "push";
  double time_s = 0;
  double impulse_ns = 0;  ///< N s
  double direction_rad = 0;
  double duration_s = 0.1;

  static void keys(auto&& key) {
    number<&Push::time_s>(key, 0, 1e6, "start of the push");
    number<&Push::impulse_ns>(key, -1e4, 1e4, "impulse of the constant horizontal force on the waist");
    degrees<&Push::direction_rad>(
        key, -36000, 36000, "direction of the force from the waist's heading: 0 is ahead, 90 to the left");
    number<&Push::duration_s>(key, 0.001, 100, "duration of the force");
  }
};

/// A rectangle of the floor, in W, with different friction.
struct FloorPatch {
  static constexpr const char* kName = "patch";
  double x_min_m = 0, x_max_m = 0, y_min_m = 0, y_max_m = 0;
  double friction = kFloorFriction;

  static void keys(auto&& key) {
    number<&FloorPatch::x_min_m>(key, -1e4, 1e4, "smallest x of the rectangle in the world");
    number<&FloorPatch::x_max_m>(key, -1e4, 1e4, "largest x of the rectangle in the world");
    number<&FloorPatch::y_min_m>(key, -1e4, 1e4, "smallest y of the rectangle in the world");
    number<&FloorPatch::y_max_m>(key, -1e4, 1e4, "largest y of the rectangle in the world");
    number<&FloorPatch::friction>(key, 0.01, 5, "sliding friction of sole on floor in the rectangle");
  }

  /// Returns a problem that involves several keys, if any.
  std::optional<std::string> problem() const {
    if (x_min_m >= x_max_m) return "is empty, expected x_min_m below x_max_m";
    if (y_min_m >= y_max_m) return "is empty, expected y_min_m below y_max_m";
    return std::nullopt;
  }
};

/// The name of one of the bench's own models, or a path: with a slash, or to a file .xml.
struct NameOrPath : std::string {
  using std::string::string;
  NameOrPath(const std::string& text) : std::string(text) {}
  bool is_path() const { return find('/') != npos || ends_with(".xml"); }
};

/// The scenario's keys world.*. If floor patches overlap, the last one applies.
struct WorldOptions {
  NameOrPath robot = "hrp2", room = "office";
  std::uint64_t seed = 1;
  double floor_friction = kFloorFriction;
  std::vector<FloorPatch> floor_patches;
  std::vector<Push> pushes;
  std::vector<Actor> actors;

  struct Start {
    double x_m = 0, y_m = 0, yaw_rad = 0;

    bool is_default() const { return x_m == 0 && y_m == 0 && yaw_rad == 0; }
    /// W, which is under the robot at its start, in the frame of the room's file.
    Eigen::Isometry3d X_RW() const {
      return Eigen::Translation3d(x_m, y_m, 0) * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
    }
    static void keys(auto&& key) {
      number<&Start::x_m>(key, -1000, 1000, "start of the robot in the room's file");
      number<&Start::y_m>(key, -1000, 1000, "start of the robot in the room's file, to the left");
      degrees<&Start::yaw_rad>(key, -360, 360, "heading of the robot at the start in the room");
    }
  } start;

  struct Light {
    double level = 1, turn_rad = 0;

    static void keys(auto&& key) {
      number<&Light::level>(
          key, 0.01, 2,
          "brightness of the lamps, relative to the room's file; windows and screens keep shining");
      degrees<&Light::turn_rad>(key, -360, 360,
                                "turn of the lamps' light about the vertical, as at another time of day");
    }
  } light;

  struct Moved {
    std::uint64_t seed = 0;
    double largest_m = 0.3, largest_rad = 30 * std::numbers::pi / 180;

    static void keys(auto&& key) {
      value<&Moved::seed>(key, "seed of the moves of furniture with space around it; 0: as in the file");
      number<&Moved::largest_m>(key, 0, 10, "largest distance by which a piece is moved, if seed is not 0");
      degrees<&Moved::largest_rad>(key, 0, 180,
                                   "largest turn of a piece about the vertical, if seed is not 0");
    }
  } moved;

  struct LightsOff {
    double from_s = 0, duration_s = 0;

    static void keys(auto&& key) {
      number<&LightsOff::from_s>(key, 0, 1e6, "start of the darkness");
      number<&LightsOff::duration_s>(key, 0, 1e6, "duration of the darkness; 0: the lamps stay on");
    }
  } lights_off;

  struct Variation {
    std::uint64_t seed = 0;
    double friction = 0.01;
    double joint_offset_rad = 0.001;
    double mass_fraction = 0.005;
    double com_m = 0.001;
    double posture_rad = 0.001;
    double servo_fraction = 0.02;
    double floor_height_m = 0.001;

    static void keys(auto&& key) {
      value<&Variation::seed>(key,
                              "seed of these variations, for the same robot in other runs; 0: the run's");
      number<&Variation::friction>(key, 0, 1e3, "standard deviation of floor_friction over seeds");
      number<&Variation::joint_offset_rad>(key, 0, 0.1, "standard deviation of each joint's zero over seeds");
      number<&Variation::mass_fraction>(key, 0, 0.2,
                                        "standard deviation of each link's mass over seeds, relative");
      number<&Variation::com_m>(
          key, 0, 0.1, "standard deviation of each link's center of mass over seeds, along each axis");
      number<&Variation::posture_rad>(key, 0, 0.1,
                                      "standard deviation of each joint's angle at the start over seeds");
      number<&Variation::servo_fraction>(key, 0, 0.2,
                                         "standard deviation of each servo's gain over seeds, relative");
      number<&Variation::floor_height_m>(key, 0, 0.01,
                                         "standard deviation of the floor's height, in waves of 1 to 4 m");
    }
  } variation;

  /// Returns the actors, which the scenario places in the room, in W.
  std::vector<Actor> actors_in_W() const {
    std::vector<Actor> all = actors;
    for (Actor& actor : all) place(actor, start.X_RW().inverse(), -start.yaw_rad);
    return all;
  }

  /// Returns the brightness of the lamps at a time, relative to the room's model.
  double light_at(double t_s) const {
    constexpr double kLeft = 0.15;  // while the lamps are off
    const bool off = t_s >= lights_off.from_s && t_s < lights_off.from_s + lights_off.duration_s;
    return light.level * (off ? kLeft : 1);
  }

  static void keys(auto&& key) {
    value<&WorldOptions::robot>(
        key, "robot: a folder below models/robots, or the path of one, relative to the scenario's file");
    value<&WorldOptions::room>(key,
                               "room seen by the head camera, which the robot must not touch: "
                               "models/<room>.xml, or the path of an MJCF "
                               "file, relative to the scenario's file");
    value<&WorldOptions::seed>(key, "seed of the patterns painted on the room's surfaces");
    number<&WorldOptions::floor_friction>(key, 0.01, 5,
                                          "sliding friction of sole on floor; the default is the robot's");
    value<&WorldOptions::floor_patches>(key, "rectangles of the floor with different friction");
    value<&WorldOptions::pushes>(key, "pushes against the waist");
    value<&WorldOptions::actors>(key, "people and doors that move, which the robot must not touch");
    part<&WorldOptions::start, &WorldOptions::light, &WorldOptions::moved, &WorldOptions::lights_off>(key);
    part<&WorldOptions::variation>(key);
  }
};

/// A wave of the floor's height: amplitude_m cos(k_1_m . (x, y) + phase_rad).
struct FloorWave {
  double amplitude_m = 0;
  Eigen::Vector2d k_1_m = Eigen::Vector2d::Zero();
  double phase_rad = 0;
};

/// The differences between the plant and its nominal model, drawn from named streams. A vector is empty if
/// nothing differs.
struct PlantVariation {
  double floor_friction = kFloorFriction;
  /// For each joint: the true angle minus the encoder's reading, and the start angle minus the commanded one.
  Eigen::VectorXd joint_offset_rad, posture_rad;
  Eigen::VectorXd servo_scale;  ///< factor of each servo's gain
  /// Mass factors of the base and then of each joint's link.
  Eigen::VectorXd mass_scale;
  Eigen::Matrix3Xd com_offset_m;  ///< in the links' axes
  std::vector<FloorWave> floor;   ///< their sum is the floor's height
};

}  // namespace sim::physics
