// The pads under the soles, the only contacts with the floor: friction, height, load and creep.
#pragma once

#include <array>

#include "sim/physics/options.h"

struct mjModel_;
struct mjData_;

namespace sim::physics {

/// Load and creep of one foot over an interval. Creep is the motion below the friction cone that MuJoCo's
/// softened friction allows and a real sole would not show; sliding beyond the cone is not part of it.
struct SoleContact {
  double load = 0;                                  ///< N, mean vertical force
  Eigen::Vector2d creep = Eigen::Vector2d::Zero();  ///< m in W, of the mean of the pads in contact
  double creep_yaw = 0;                             ///< rad
};

/// The ten pads of a robot on its floor.
class Soles {
 public:
  /// Finds the pads: geoms of RLEG_SOLE and LLEG_SOLE that collide. Throws std::runtime_error without any.
  Soles(mjModel_& model, double friction, std::vector<FloorPatch> patches, std::vector<FloorWave> waves);

  /// Gives each pad the friction and the height of the floor below it: the floor of the simulator is a plane,
  /// a pad over a bump is longer by its height. The bumps' slopes (below 1 %) are neglected.
  void apply_floor(mjModel_& model, const mjData_& data) const;

  /// Height of the lowest pad above the plane, m.
  double lowest_pad(const mjModel_& model, const mjData_& data) const;

  /// Adds load and creep of this step; call it once the step's contact forces have been computed.
  void add_contact_forces(const mjModel_& model, const mjData_& data);

  /// Since the last call: of the left sole, then of the right one.
  std::array<SoleContact, 2> since_last();

 private:
  struct Pad {
    int geom = 0, foot = 0;  // foot: 0 left, 1 right
    double z = 0;            // in the sole, on an even floor
  };
  void add_contact_forces(const mjModel_& model, const mjData_& data, std::size_t foot);

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

}  // namespace sim::physics
