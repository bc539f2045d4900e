// The robot in the Unified Robot Description Format, which viewers of ROS messages draw.
#pragma once

#include <string>

struct mjModel_;

namespace sim::camera {

/// The name of the root link.
inline constexpr const char* kUrdfRoot = "waist";

/// The bodies below the one with a free joint, which becomes kUrdfRoot: their hinges with axes and limits (m,
/// rad), and the shapes that are drawn. The ankles' bushes are at rest. URDF has no capsules, drawn as
/// cylinders with two spheres, and no ellipsoids, drawn as spheres of the same volume. Throws
/// std::invalid_argument if no body has a free joint.
std::string urdf(const mjModel_& model);

}  // namespace sim::camera
