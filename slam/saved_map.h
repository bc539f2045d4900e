// The map of a filter as it is kept between runs.
#pragma once

#include "slam/vision/landmark.h"

namespace slam {

/// A landmark's stamps before the first frame: it is from an earlier session.
inline constexpr Stamp kEarlierSession = -std::chrono::hours(1);

/// Points and inverse depths in the frame of the session that made the map: W under that session's start.
struct SavedMap {
  int sessions = 0;                 ///< number of runs that contributed to it
  CameraIntrinsics camera;          ///< camera of its patches
  std::vector<Landmark> landmarks;  ///< Landmark::at is an index in x
  Eigen::VectorXd x;                ///< parameters of all landmarks, without gaps
  Eigen::MatrixXd P;                ///< their covariance, symmetric
};

}  // namespace slam
