// Random vectors, poses and images: generic contents of recordings; and the comparison of observations.
#pragma once

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "sim/sensor_errors/random.h"
#include "slam/observation.h"

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

inline void append(std::vector<double>& all, const auto& values) {
  all.insert(all.end(), values.data(), values.data() + values.size());
}

/// All that an observation has besides its image.
inline std::vector<double> numbers_of(const slam::Observation& o) {
  const auto ns = [](slam::Stamp t) { return static_cast<double>(t.count()); };
  std::vector<double> all{ns(o.t), static_cast<double>(o.gyro.size()), o.plan ? 1.0 : 0.0};
  for (const auto* readings : {&o.gyro, &o.accelerometer})
    for (const slam::InertialSample& reading : *readings) {
      all.insert(all.end(), {ns(reading.begin), ns(reading.end)});
      append(all, reading.value);
    }
  if (!o.plan) return all;
  append(all, o.plan->X_PC.matrix());
  for (const auto& v : {o.plan->v_PC_C, o.plan->w_PC_C, o.plan->p_CF}) append(all, v);
  all.push_back(static_cast<double>(o.plan->support));
  if (!o.plan->legs) return all;
  append(all, o.plan->legs->X_OC.matrix());
  append(all, o.plan->legs->p_CS);
  return all;
}

inline void expect_same(const slam::Observation& a, const slam::Observation& b) {
  EXPECT_EQ(numbers_of(a), numbers_of(b));
  ASSERT_EQ(a.image.size(), b.image.size());
  ASSERT_EQ(a.image.type(), b.image.type());
  EXPECT_TRUE(a.image.empty() || cv::norm(a.image, b.image, cv::NORM_INF) == 0);
}

}  // namespace tests
