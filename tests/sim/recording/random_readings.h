// Random vectors, poses, images, observations and a rig, as generic contents of recordings; the comparison of
// observations; and the cases of wrong files.
#pragma once

#include <opencv2/imgcodecs.hpp>

#include "sim/rig/rig.h"
#include "sim/sensor_errors/random.h"
#include "slam/observation.h"
#include "tests/sim/files/temporary_folder.h"

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
    for (int i = 0; i < size.width * int(pixels.elemSize()); ++i) pixels.ptr(row)[i] = random.bits() & 255;
  return pixels;
}

/// An image, encoded by OpenCV.
inline std::string encoded(const std::string& ending, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(ending, image, bytes);
  return {bytes.begin(), bytes.end()};
}

/// Observations as in a run: a frame every 33 ms, and readings every 5 ms, split at frames. Some have no
/// image or plan. begin: start of the first reading.
inline std::vector<slam::Observation> observations(sim::sensor_errors::Random& random, int count,
                                                   cv::Size size, slam::Stamp begin, bool legs = false) {
  std::vector<slam::Observation> all;
  for (int k = 0; k < count; ++k) {
    slam::Observation& o = all.emplace_back();
    o.t = slam::Stamp(33'000'000ll * k);
    while (begin < o.t) {
      const slam::Stamp tick{(begin.count() / 5'000'000 + 1) * 5'000'000},
          end = std::min(o.t, begin.count() < 0 ? slam::Stamp{0} : tick);
      o.gyro.push_back({begin, end, random_vector(random)});
      o.accelerometer.push_back({begin, end, random_vector(random)});
      begin = end;
    }
    if (k % 5 != 3) o.image = random_image(size, random);
    if (k % 7 == 4) continue;
    o.plan = slam::PlannedMotion{random_pose(random), random_vector(random), random_vector(random),
                                 random_vector(random), static_cast<slam::Support>(random.bits() % 3)};
    if (legs)
      o.legs = slam::LegMotion{random_pose(random), random_vector(random),
                               Eigen::Isometry3d(Eigen::Translation3d(0.1 * k, 0, 0))};
    if (legs && k % 3 == 1) o.command = slam::CommandedVelocity{o.t - slam::Stamp(k), 0.1 * k, 0.2, 0.3};
  }
  return all;
}

/// One sensor of each kind, without errors.
inline std::vector<sim::rig::RigSensor> rig_of(sim::sensor_errors::Random& random, cv::Size size) {
  std::vector<sim::rig::RigSensor> all;
  for (const char* name : {"cam1", "rgb0", "depth0", "lidar0", "imu1"}) {
    sim::rig::RigSensor s;
    s.name = name, s.kind = static_cast<sim::rig::Kind>(all.size());
    s.rate_hz = 10 + random.uniform();
    s.X_CS = random_pose(random);
    if (is_camera(s)) s.camera = {size.width, size.height, 19 + random.uniform(), 20, 15, 12, slam::Lens()};
    all.push_back(s);
  }
  all[2].aligned_with = "rgb0", all[2].baseline_m = 0.05;
  all[2].furthest_m = all[3].furthest_m = 66;
  return all;
}

/// Adds readings of rig_of(): from the cameras twice per frame or not at all; stamped before, at and after
/// the frame.
inline void add_rig(std::vector<slam::Observation>& all, sim::sensor_errors::Random& random, cv::Size size,
                    bool empty_sweep = false) {
  slam::Stamp begin{-1'000'000};
  for (std::size_t k = 0; k < all.size(); ++k) {
    slam::Observation& o = all[k];
    const auto add = [&](int sensor, slam::Stamp t) -> slam::RigReading& {
      slam::RigReading& reading = o.rig.emplace_back();
      reading.sensor = sensor, reading.t = t;
      return reading;
    };
    for (const auto& [sensor, type] : {std::pair(0, CV_8UC1), {1, CV_8UC3}, {2, CV_16UC1}})
      for (const int ms : {-7, sensor == 0 ? 0 : 3})
        if (k % 4 != 2)
          add(sensor, o.t + std::chrono::milliseconds(ms)).image = random_image(size, random, type);
    auto& points = add(3, o.t - slam::Stamp(10)).points;
    for (int i = 0; i < (k == 1 && empty_sweep ? 0 : 3); ++i) {
      const Eigen::Vector3f p = random_vector(random).cast<float>();
      points.push_back({p.x(), p.y(), p.z(), float(random.uniform()), 1000 * i});
    }
    for (; begin + slam::Stamp(10'000'000) <= o.t; begin += slam::Stamp(10'000'000)) {
      slam::RigReading& reading = add(4, begin + slam::Stamp(10'000'000));
      reading.begin = begin;
      reading.gyro = random_vector(random), reading.accelerometer = random_vector(random);
    }
  }
}

inline void append(std::vector<double>& all, const auto& values) {
  all.insert(all.end(), values.data(), values.data() + values.size());
}

/// All numbers of an observation except its images.
inline std::vector<double> numbers_of(const slam::Observation& o) {
  const auto ns = [](slam::Stamp t) { return double(t.count()); };
  std::vector<double> all{ns(o.t), double(o.gyro.size()), o.plan ? 1.0 : 0.0};
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
  for (const slam::BodyReading& reading : o.body) {
    all.push_back(ns(reading.t));
    append(all, reading.q);
    for (const auto& foot : {reading.left, reading.right}) append(all, foot.force), append(all, foot.torque);
  }
  if (o.plan) {
    append(all, o.plan->X_PC.matrix());
    for (const auto& v : {o.plan->v_PC_C, o.plan->w_PC_C, o.plan->p_CF}) append(all, v);
    all.push_back(double(o.plan->support));
  }
  if (o.legs)
    append(all, o.legs->X_OC.matrix()), append(all, o.legs->p_CS), append(all, o.legs->X_CG->matrix());
  if (const auto& c = o.command) all.insert(all.end(), {ns(c->t), c->ahead_m_s, c->left_m_s, c->turn_rad_s});
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

/// A file, the replacement in it, and a part of the resulting error.
struct BadFile {
  std::string name, from, to, words;
};
/// The cases below a title of bad_files.txt: "# expect: words" and "name: from -> to", with \n for a line
/// feed.
inline std::vector<BadFile> bad_files(const std::string& title) {
  std::istringstream in(*sim::files::titled_lines(
      sim::files::read_text(GAITSLAM_SOURCE_DIR "/tests/sim/recording/bad_files.txt"), title));
  std::vector<BadFile> all;
  for (std::string words, edit; std::getline(in, words) && std::getline(in, edit);) {
    const std::size_t name = edit.find(": "), to = edit.rfind(" -> ");
    EXPECT_LT(name, to) << edit;
    all.push_back({edit.substr(0, name), replaced(edit.substr(name + 2, to - name - 2), "\\n", "\n"),
                   replaced(edit.substr(to + 4), "\\n", "\n"), words.substr(sizeof "# expect:")});
  }
  EXPECT_GT(all.size(), 20u);
  return all;
}

}  // namespace tests
