// The shutter of the simulated camera: the exposure of each row of a frame, and the robot's poses during it.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <chrono>
#include <deque>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/camera/options.h"

namespace sim::camera {

/// Row v of H of a frame stamped t is exposed from t + readout ((v + 1/2) / H - 1/2) - exposure/2 on for the
/// exposure: the stamp is the middle of the middle row's exposure. Pictures are drawn at evenly spaced
/// moments, light between two of them being interpolated.
class Shutter {
 public:
  explicit Shutter(const CameraOptions& options);

  /// When pictures are to be drawn, s from the stamp; one, at 0, for a shutter that takes no time.
  const std::vector<double>& moments() const { return moments_; }
  /// Time from the stamp to the end of the exposure, in whole milliseconds.
  std::chrono::milliseconds lead() const;
  /// The share of each moment's picture (rows) in each image row (columns); each column sums to 1.
  const cv::Mat1f& shares() const { return shares_; }
  /// The frame, of one picture for each moment.
  cv::Mat1b expose(const std::vector<cv::Mat>& pictures) const;

 private:
  std::vector<double> moments_;
  cv::Mat1f shares_;
};

/// The robot's positions of the last moments, a millisecond apart or less.
class RecentMotion {
 public:
  explicit RecentMotion(std::chrono::nanoseconds kept) : kept_(kept) {}

  /// Adds positions at a later moment than all before.
  void add(std::chrono::nanoseconds t, const mjModel& model, const mjData& data);
  /// Positions at a moment (s), interpolated between the nearest two; outside them the first or the last that
  /// is still kept. Needs at least one.
  Eigen::VectorXd at(double t_s, const mjModel& model) const;

 private:
  struct Pose {
    double t_s;
    Eigen::VectorXd q;
  };
  std::chrono::nanoseconds kept_;
  std::deque<Pose> poses_;
};

}  // namespace sim::camera
