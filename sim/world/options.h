// What can be set in the simulated world and its camera: plain numbers, the only header of sim/world that
// sim/bench sees.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace sim::world {

/// Sliding friction between sole and floor: calibrated, see models/README.md.
inline constexpr double kFloorFriction = 0.15;

/// A push against the waist: an even horizontal force of so long a time.
struct Push {
  double time_s = 0;         ///< when it begins
  double impulse_ns = 0;     ///< N s
  double direction_rad = 0;  ///< in which it goes, by the waist's heading: 0 ahead, left positive
  double duration_s = 0.1;
};

/// A rectangle of the floor, in W, with a friction of its own.
struct FloorPatch {
  double x_min_m = 0, x_max_m = 0, y_min_m = 0, y_max_m = 0;
  double friction = kFloorFriction;
};

/// The scenario's keys world.*.
struct WorldOptions {
  std::string robot = "hrp2";   ///< models/<robot>.xml
  std::string room = "office";  ///< models/<room>.xml: what the head camera sees
  std::uint64_t seed = 1;       ///< of what is painted on the room's surfaces
  struct LightsOff {            ///< a while without the room's lamps; windows and screens shine on
    double from_s = 0, duration_s = 0;
    double left_fraction = 0.15;  ///< of the light that surfaces get
  } lights_off;
  double floor_friction = kFloorFriction;  ///< sliding friction between sole and floor
  std::vector<FloorPatch> floor_patches;   ///< where the friction is another; of several, the last one
  std::vector<Push> pushes;
  struct Variation {                  ///< standard deviations from seed to seed, drawn from named streams
    double friction = 0.01;           ///< of floor_friction
    double joint_offset_rad = 0.001;  ///< of each joint's zero
    double mass_fraction = 0.005;     ///< of each link's mass, relative
    double com_m = 0.001;             ///< of each link's centre of mass, along each axis
    double posture_rad = 0.001;       ///< of each joint's angle at the start
    double servo_fraction = 0.02;     ///< of each servo's gain, relative
    double floor_height_m = 0.001;    ///< of the floor's height, in waves of 1 to 4 m
  } variation;
};

enum class Lens { wide, pinhole };

/// The scenario's keys camera.*.
struct CameraOptions {
  int width_px = 320, height_px = 240;
  double rate_hz = 30;
  Lens lens = Lens::wide;  ///< the paper's camera (about 91.6° across), or an ideal pinhole of 90° across
  int samples = 0;  ///< multisamples of the renderer: 4, or 0 for a denser picture smoothed (twice as fast)
  double exposure_s = 0;  ///< how long each row gathers light (motion blur)
  double readout_s = 0;   ///< from the first row's exposure to the last row's (rolling shutter)
  int subframes = 8;      ///< pictures drawn for a frame when exposure_s or readout_s is not 0
};

/// A wave of the floor's height: amplitude_m cos(k_1_m . (x, y) + phase_rad).
struct FloorWave {
  double amplitude_m = 0;
  Eigen::Vector2d k_1_m = Eigen::Vector2d::Zero();
  double phase_rad = 0;
};

/// One draw of what differs between the plant and its nominal model, made by the run from named streams. A
/// vector that is empty: no difference.
struct Draw {
  double floor_friction = kFloorFriction;
  Eigen::VectorXd joint_offset_rad;  ///< true angle minus what the encoder reads, one per joint
  Eigen::VectorXd mass_scale;        ///< of the waist, then of the link each joint moves (31)
  Eigen::Matrix3Xd com_offset_m;     ///< of the same links, in their axes
  Eigen::VectorXd posture_rad;       ///< true angle at the start minus the one asked for, one per joint
  Eigen::VectorXd servo_scale;       ///< of each servo's gain, one per joint
  std::vector<FloorWave> floor;      ///< their sum is the floor's height
};

}  // namespace sim::world
