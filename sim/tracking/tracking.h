// Tracking in a live or replayed run: ideal observations in, estimates and reports out.
#pragma once

#include <ctime>

#include "sim/estimators/estimator.h"
#include "sim/scenario/scenario.h"

namespace sim::tracking {

/// Returns the CPU time (ms) by a clock, or of the calling thread.
double cpu_ms(clockid_t clock);
inline double thread_cpu_ms() { return cpu_ms(CLOCK_THREAD_CPUTIME_ID); }

/// The estimate after a frame and its report, see estimators::Answer.
struct TrackedFrame {
  std::optional<estimators::PoseEstimate> estimate;
  slam::FrameReport report;
  slam::Stamp took{0};    ///< simulated time of the answer, by estimator.time
  slam::Stamp effect{0};  ///< when it takes effect, if the image is complete at its stamp
};

/// A period in which tracking was lost or a sensor was suspect.
struct TrackingFault {
  slam::Stamp from{0};
  std::optional<slam::Stamp> to;  ///< absent if it did not end
  std::string cause;
};

/// The map at a time.
struct TimedMap {
  slam::Stamp t{0};
  std::vector<slam::MapPoint> points;
};

/// The output of an estimator in a run.
struct Tracked {
  std::vector<TrackedFrame> frames;    ///< up to and including a divergence
  std::vector<slam::MapPoint> map;     ///< at the end
  std::vector<TimedMap> maps;          ///< one per second
  std::vector<slam::Stamp> untracked;  ///< observations after it diverged or failed
  std::vector<slam::Stamp> dropped;    ///< number of observations that arrived while the estimator was busy
  std::optional<std::string> failed = {};  ///< why it failed as a program
  std::string log = {};                    ///< standard error of an external estimator
  /// The poses from the same sensors without images (estimator: odometry). Empty if the estimator is itself
  /// odometry, lacks plan and legs, or diverged.
  std::vector<estimators::PoseEstimate> odometry = {};
  std::vector<estimators::PoseEstimate> smoothed = {};  ///< see estimators::Estimator
  std::optional<slam::SavedMap> saved_map = {};         ///< see estimators::Estimator

  /// Returns why the estimate did not reach the end: it diverged, it was still lost, or the estimator failed.
  std::optional<scenario::Ended> failure() const;
  /// Returns the estimates, each once. Rejected observations give no new estimate, nor does an external
  /// estimator that is lost or not ready.
  std::vector<estimators::PoseEstimate> estimates() const;
  std::vector<TrackingFault> losses() const;
  /// Returns when a sensor contradicted all others, with the last cause of each period.
  std::vector<TrackingFault> suspicions() const;
};

/// Sensor errors and then the scenario's estimator, in the simulated time of estimator.time. Live runs and
/// replays share it and get the same bits.
class Tracking {
 public:
  /// The scenario must have a slam section. Throws std::invalid_argument if an external estimator cannot be
  /// started. session: without a map, the file slam.map.load is read, if any.
  Tracking(const scenario::Scenario& scenario, const slam::Calibration& calibration,
           const Eigen::Isometry3d& X_WC_start, double camera_rate_hz = 30,
           const std::vector<rig::RigSensor>& rig = {}, const std::vector<std::string>& joints = {},
           const estimators::Session& session = {});
  /// Runs an estimator other than the scenario's.
  Tracking(const scenario::Scenario& scenario, std::unique_ptr<estimators::Estimator> estimator,
           const std::vector<rig::RigSensor>& rig = {});
  /// Applies the scenario's sensor errors to an ideal observation and processes the observations that have
  /// arrived by then. Leaves out rig readings that the estimator does not use. An estimator that has diverged
  /// or failed gets no more observations.
  void process(slam::Observation ideal);
  /// Processes an observation that already includes its sensor errors. A busy estimator gets it later. If it
  /// is dropped, the estimator gets only the readings of its IMUs, encoders and force sensors, with the next
  /// observation.
  void step(const slam::Observation& arrived);
  /// Advances simulated time: a waiting observation is processed if the estimator is free by then.
  void advance(slam::Stamp now);
  /// All answers, in order; each takes effect at its time.
  const std::vector<TrackedFrame>& answers() const { return tracked_.frames; }
  /// Returns the newest frame, or nullptr before the first.
  const TrackedFrame* newest() const { return tracked_.frames.empty() ? nullptr : &tracked_.frames.back(); }
  /// Returns whether the estimator uses the readings of a sensor of the rig.
  bool uses(int sensor) const { return estimator_ && estimator_->uses(sensor); }
  /// Returns whether the estimator has failed; its newest frame is its last answer.
  bool failed() const { return tracked_.failed.has_value(); }
  /// Returns the CPU time (ms) of the estimator since the last call, also in another process.
  double cpu_ms() { return std::exchange(cpu_ms_, 0); }
  /// Returns whether there is a new answer since the last call.
  bool has_answered() { return std::exchange(answers_, tracked_.frames.size()) < tracked_.frames.size(); }
  /// Returns the image of the last observation that has arrived; empty if it has none.
  const cv::Mat& image() const { return image_; }
  /// Returns the number of landmarks after the last observation.
  int landmarks() const { return newest() ? newest()->report.landmarks : 0; }
  /// The map after the last observation.
  std::vector<slam::MapPoint> map() const;
  /// Processes observations that are still delayed, ends the estimator and returns the result.
  Tracked finish();

 private:
  struct Waiting {
    slam::Observation observation;
    slam::Stamp arrival{0};
  };
  void answer(const slam::Observation& arrived, slam::Stamp arrival);
  void ask(const slam::Observation& arrived, slam::Stamp arrival);
  void drop(const slam::Observation& arrived);
  void add_missed(slam::Observation& observation);
  bool is_imu(const slam::RigReading& reading) const;
  std::vector<estimators::PoseEstimate> odometry() const;

  /// Returns the frame of the estimator's answers in W. A map that it refused does not matter.
  Eigen::Isometry3d X_WM() const { return refused_map_ ? frames_->told.inverse() : frames_->X_WR; }

  struct Frames {
    Eigen::Isometry3d X_WR;  ///< the room, which is the frame of maps
    Eigen::Isometry3d told;  ///< W in the frame of the map, as the estimator is told
  };
  std::optional<Frames> frames_;  ///< absent if W is the room's frame, and there is no loaded map
  bool refused_map_ = false;
  std::filesystem::path memory_;  ///< of an external program; empty: none
  bool in_memory_ = false;        ///< an earlier session left files there
  std::vector<rig::RigSensor> rig_;
  sensor_errors::SensorErrors errors_;
  scenario::EstimatorTime time_;
  struct {
    slam::Stamp now{0}, free{0};  // the last arrival; when the estimator is free again
  } clock_;
  std::optional<Waiting> waiting_;                    // newest observation that found the estimator busy
  slam::Observation missed_;                          // dropped observations' readings, without images
  slam::Stamp given_ = slam::Stamp::min();            // newest stamp that the estimator has received
  std::unique_ptr<estimators::Estimator> estimator_;  ///< null if it failed to start
  cv::Mat image_;
  double cpu_ms_ = 0;
  std::size_t answers_ = 0;
  struct {
    std::optional<estimators::Start> start;
    std::vector<slam::Observation> arrived;  // without images
  } odometry_input_;                         // for Tracked::odometry
  Tracked tracked_;
};

}  // namespace sim::tracking
