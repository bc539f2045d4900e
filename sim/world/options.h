// What can be set in the simulated world and its camera: plain numbers, the only header of sim/world that
// sim/bench sees.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace sim::world {

/// The scenario's keys world.*.
struct WorldOptions {
  std::string robot = "hrp2";         ///< models/<robot>.xml
  std::string room = "office";        ///< models/<room>.xml: what the head camera sees
  std::uint64_t seed = 1;             ///< of what is painted on the room's surfaces
  double floor_friction = 0.7;        ///< sliding friction between sole and floor
  struct Variation {                  ///< standard deviations from seed to seed, drawn from named streams
    double friction = 0.02;           ///< of floor_friction
    double joint_offset_rad = 0.001;  ///< of each joint's zero
    double mass_fraction = 0.005;     ///< of each link's mass, relative
  } variation;
};

enum class Lens { wide, pinhole };

/// The scenario's keys camera.*.
struct CameraOptions {
  int width_px = 320, height_px = 240;
  double rate_hz = 30;
  Lens lens = Lens::wide;  ///< the paper's camera (about 91.6° across), or an ideal pinhole of 90° across
  int samples = 0;  ///< multisamples of the renderer: 4, or 0 for a denser picture smoothed (twice as fast)
};

/// One draw of what differs between the plant and its nominal model, made by the run from named streams.
struct Draw {
  double floor_friction = 0.7;
  Eigen::VectorXd joint_offset_rad;  ///< true angle minus what the encoder reads, one per joint; empty: none
  Eigen::VectorXd mass_scale;        ///< of the waist, then of the link each joint moves (31); empty: none
};

}  // namespace sim::world
