// Readings of cameras, lidars and further IMUs in a run: what each sees of the walk, at its own rate.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "sim/camera/head_camera.h"
#include "sim/live/ordered_worker.h"
#include "sim/physics/world.h"
#include "sim/rig/rig.h"
#include "sim/scenario/scenario.h"
#include "slam/observation.h"

namespace sim::live {

/// A reading and its image, encoded for the recording.
struct RigFrame {
  slam::RigReading reading;
  std::string png;
  double render_ms = 0, encode_ms = 0;  ///< CPU time
};

/// The readings of a sensor at a time, once they are encoded.
using RigFrames = std::future<std::vector<RigFrame>>;

/// The places of the items of a scenario's rig on the robot; of a depth camera the head camera's.
std::vector<physics::Place> places(const std::vector<rig::Item>& rig, const mjModel_& model);

/// The head camera as a sensor; further ones have their index in the rig.
inline constexpr int kHeadCamera = -1;

/// Cameras and lidars, the head camera first, each with its own threads, to draw and to encode, when images
/// are drawn beside the walk. A camera's image k is stamped at the millisecond nearest to k / rate, a lidar's
/// sweep k at its start; it is complete when its shutter has closed, or at its end. The same positions give
/// the same readings. A scenario without a camera has no readings.
class RigReadings {
 public:
  RigReadings(const scenario::Scenario& scenario, const physics::Models& models, bool beside);
  ~RigReadings();
  /// How long before now positions are needed, for frames of this period.
  std::chrono::nanoseconds reach(std::chrono::nanoseconds frame_period) const;
  /// Starts all readings that are complete by `end` and not started before.
  std::vector<std::future<RigFrames>> start(std::chrono::nanoseconds end,
                                            const std::shared_ptr<const camera::RecentMotion>& motion);
  /// Frees textures.
  void close();

 private:
  class Sensor;
  std::vector<std::unique_ptr<Sensor>> sensors_;
};

/// The further IMUs: read at each of their periods.
class RigImus {
 public:
  RigImus(const std::vector<rig::Item>& rig, const std::vector<physics::Place>& places,
          const physics::World& world);
  /// To be called at each millisecond: appends the readings that end now.
  void read(const physics::World& world, std::vector<slam::RigReading>& readings);

 private:
  struct Imu {
    int sensor;
    physics::Place place;
    std::chrono::nanoseconds period;
    physics::ImuState last;
  };
  std::vector<Imu> imus_;
};

}  // namespace sim::live
