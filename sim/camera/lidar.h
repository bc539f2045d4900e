// The lidar: rays cast from a walking robot on the shapes of the room and of the robot itself.
#pragma once

#include "sim/camera/head_camera.h"
#include "sim/physics/model.h"
#include "sim/rig/rig.h"
#include "slam/observation.h"

namespace sim::camera {

/// Returns the direction in the lidar's axes (forward, left, up) of a ray, numbered from t = 0. Two
/// rotations, as by two prisms, never repeat a pair of angles. The first, one turn per sweep, is the
/// azimuth. The second moves the sine of the elevation evenly up and down, 120 sqrt(2) cycles per sweep, so
/// that equal solid angles get equally many rays. Sweeps of 20 000 rays leave gaps of a degree, which later
/// sweeps fill.
Eigen::Vector3d ray_direction(const rig::Lidar& options, std::int64_t number);

/// Returns the time of a ray since t = 0; rays are evenly spaced.
std::chrono::nanoseconds ray_time(const rig::Lidar& options, std::int64_t number);

/// Casts the rays of sweeps, without sensor errors. The same motion gives the same bytes.
class Lidar {
 public:
  Lidar(physics::Model robot_in_room, const physics::Place& place, const rig::Lidar& options,
        std::uint64_t texture_seed = 1);

  /// Returns the points of the rays at begin <= t < end, each in the lidar's frame at its own time. Offsets
  /// count from `begin`; `motion` must cover this time. The link that carries the lidar is invisible. Other
  /// links are posed at the middle of the millisecond. Surfaces that return no light or are out of range
  /// give no point. The intensity is the gray level of the surface in white light (its picture averaged over
  /// 4x4 texels) times the cosine of the angle of incidence.
  std::vector<slam::LidarPoint> scan(const RecentMotion& motion, std::chrono::nanoseconds begin,
                                     std::chrono::nanoseconds end);

 private:
  struct Hit {
    int geom = -1;
    double distance = 0;
  };
  Eigen::Isometry3d pose(const RecentMotion& motion, double t_s);
  void set_box(Eigen::Index shape);
  Hit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& along);
  double intensity(int geom, const Eigen::Vector3d& point, const Eigen::Vector3d& along) const;

  physics::Model model_;
  physics::Data data_;
  physics::Place place_;
  rig::Lidar options_;
  std::vector<int> shapes_;                               // the geoms that rays can meet
  Eigen::Array<float, Eigen::Dynamic, 3> lower_, upper_;  // corners of the boxes around them, m in W
  Eigen::ArrayXf enters_, leaves_;                        // distances along a ray to the boxes
  std::vector<cv::Mat1b> pictures_;                       // pictures of the model's textures
};

}  // namespace sim::camera
