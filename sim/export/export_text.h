// How numbers and poses are written in the files of other programs.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::exports {

/// "1000000000.033000000"
std::string written_seconds(slam::Stamp t);

/// The shortest decimals that bring the same bits back, with a decimal point: some readers take 1 for an
/// integer and refuse it.
std::string real(double x);

/// Four rows of four numbers, each row between `before` and `after`, `between` them: "[1.0, 0.0, ...]\n[...".
std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view between);

/// "t tx ty tz qx qy qz qw" with the stamps of the exports.
std::string tum_text(const std::vector<files::TimedPose>& poses);

/// The lens of an exported camera in the words of other programs.
struct LensModel {
  bool equidistant;         ///< else a pinhole without distortion
  std::array<double, 4> k;  ///< all zero without distortion
};
LensModel lens_model(const slam::CameraIntrinsics& camera);

}  // namespace sim::exports
