// Poses in MJCF: read in the file's own conventions of angles, written as quaternions.
#pragma once

#include <Eigen/Geometry>

#include "sim/model_file/element.h"

namespace sim::model_file {

/// How a file writes angles.
struct Angles {
  bool degrees = true;
  std::string sequence = "xyz";  ///< of euler angles; capitals: about fixed axes
};

/// Returns the pose of a body, geom, site, camera or frame in its parent. Throws FileError.
Eigen::Isometry3d place_of(const Element& element, const Angles& angles);
/// Replaces the element's pose, in whatever form the file gives it.
void set_place(Element& element, const Eigen::Isometry3d& X);

}  // namespace sim::model_file
