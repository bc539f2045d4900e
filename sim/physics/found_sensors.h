// Finds a robot's sensors in its model by the names of links, sites and cameras.
#pragma once

#include "sim/physics/compiled.h"
#include "sim/rig/rig.h"

namespace sim::physics {

/// Sensors of a model, each mounted on a link that moves; the preferred one first.
struct FoundSensors {
  std::vector<rig::Mount> cameras, imus, lidars;
};

/// Returns the sensors on the given links and on everything fixed to them. Names of common products count
/// more than "camera", and earlier links more than later ones. A link or site looks along its x axis or, if
/// that axis points to the right of the robot or the z axis ahead, along its z axis. Cameras that look
/// backward are left out.
FoundSensors find_sensors(const CompiledRobot& robot, const std::vector<std::string>& links);

/// Returns the mount with this pose on a link.
rig::Mount mount_on(const std::string& link, const Eigen::Isometry3d& X);

/// Returns the keys of a mount as YAML, without braces.
std::string text_of(const rig::Mount& mount);

}  // namespace sim::physics
