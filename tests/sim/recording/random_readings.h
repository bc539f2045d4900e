// Random vectors, poses and images: generic contents of recordings.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "sim/sensor_errors/random.h"

namespace tests {

inline Eigen::Vector3d random_vector(sim::sensor_errors::Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}

inline Eigen::Isometry3d random_pose(sim::sensor_errors::Random& random) {
  Eigen::Isometry3d X(
      Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized());
  X.translation() = random_vector(random);
  return X;
}

inline cv::Mat random_image(cv::Size size, sim::sensor_errors::Random& random) {
  cv::Mat pixels(size, CV_8UC1);
  for (int row = 0; row < size.height; ++row)
    for (int column = 0; column < size.width; ++column)
      pixels.at<unsigned char>(row, column) = random.bits() & 255;
  return pixels;
}

}  // namespace tests
