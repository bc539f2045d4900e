// Measures the filter's noises of a robot by comparing its start and its leg odometry with the truth.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

namespace sim::live {

/// Sums of squared errors over walks. X_WC: the true pose of the head camera.
class LegNoises {
 public:
  /// The walk's start. X_WC_known: the pose that the robot assumes.
  void start(const Eigen::Isometry3d& X_WC_known, const Eigen::Isometry3d& X_WC);
  /// A frame of the walk, dt_s after the previous one. X_OC: by leg odometry.
  void add(const Eigen::Isometry3d& X_OC, const Eigen::Isometry3d& X_WC, double dt_s);
  /// The walk's end. Fits the constant error of the stride to it. stride_s: the duration of two steps.
  void end(double stride_s);
  void add(const LegNoises& other);
  /// Returns the scenario's key slam with the noises, as in robot.yaml.
  std::string yaml() const;

 private:
  struct Errors {
    double squares = 0, count = 0;
    void add(double error) { squares += error * error, ++count; }
    void add(const Eigen::Vector3d& error) { squares += error.squaredNorm(), count += 3; }
    void add(const Errors& other) { squares += other.squares, count += other.count; }
    double rms() const;
  };
  struct Frame {
    Eigen::Vector3d by_legs, error;  // velocity of the camera along its axes
    double height_error_m, dt_s;
  };

  std::array<Errors, 3> start_m_, start_rad_;  // by axis
  Errors height_m_, lasting_m_, position_m_, velocity_m_s_, stride_, sway_m_s_;
  Eigen::Isometry3d X_OC_, X_WC_;  // of the last frame
  std::vector<Frame> frames_;      // of the present walk
  bool started_ = false;
};

}  // namespace sim::live
