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

inline cv::Mat random_image(cv::Size size, sim::sensor_errors::Random& random, int type = CV_8UC1) {
  cv::Mat pixels(size, type);
  for (int row = 0; row < size.height; ++row)
    for (int i = 0; i < size.width * static_cast<int>(pixels.elemSize()); ++i)
      pixels.ptr(row)[i] = random.bits() & 255;
  return pixels;
}

inline void append(std::vector<double>& all, const auto& values) {
  all.insert(all.end(), values.data(), values.data() + values.size());
}

/// All that an observation has besides its images.
inline std::vector<double> numbers_of(const slam::Observation& o) {
  const auto ns = [](slam::Stamp t) { return static_cast<double>(t.count()); };
  std::vector<double> all{ns(o.t), static_cast<double>(o.gyro.size()), o.plan ? 1.0 : 0.0};
  for (const auto* readings : {&o.gyro, &o.accelerometer})
    for (const slam::InertialSample& reading : *readings) {
      all.insert(all.end(), {ns(reading.begin), ns(reading.end)});
      append(all, reading.value);
    }
  for (const slam::RigReading& reading : o.rig) {
    all.insert(all.end(), {double(reading.sensor), ns(reading.t), ns(reading.begin)});
    for (const auto& v : {reading.gyro, reading.accelerometer}) append(all, v);
    for (const slam::LidarPoint& p : reading.points)
      all.insert(all.end(), {p.x_m, p.y_m, p.z_m, p.intensity, double(p.offset_ns)});
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

inline void expect_same(const cv::Mat& a, const cv::Mat& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.type(), b.type());
  EXPECT_TRUE(a.empty() || cv::norm(a, b, cv::NORM_INF) == 0);
}

inline void expect_same(const slam::Observation& a, const slam::Observation& b) {
  EXPECT_EQ(numbers_of(a), numbers_of(b));
  expect_same(a.image, b.image);
  ASSERT_EQ(a.rig.size(), b.rig.size());
  for (std::size_t i = 0; i < a.rig.size(); ++i) expect_same(a.rig[i].image, b.rig[i].image);
}

}  // namespace tests
