// The readings of ideal sensors in one run, stored in a folder of the EuRoC/ASL layout (README.md) and read
// back bit for bit. Stamps in files are slam::Stamp plus kEpoch, because readers of this layout expect 19
// digits. Positions are in m, angles in rad.
#pragma once

#include <functional>

#include "sim/files/trajectory_file.h"
#include "sim/rig/rig.h"
#include "sim/score/types.h"
#include "sim/sensor_errors/sensor_errors.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace sim::recording {

inline constexpr slam::Stamp kEpoch{1'000'000'000'000'000'000};
/// Returns the stamp in files, ns.
constexpr std::int64_t file_stamp(slam::Stamp t) { return (kEpoch + t).count(); }

/// The sensors: data known to the filter before the first observation, and data for other readers.
struct RecordingSetup {
  slam::Calibration calibration;
  Eigen::Isometry3d X_WC_start = Eigen::Isometry3d::Identity();  ///< camera at t = 0, from plan or legs
  double camera_rate_hz = 30, imu_rate_hz = 200;                 ///< imu: also encoders and forces
  std::vector<rig::RigSensor> rig;  ///< additional sensors; RigReading::sensor is an index in this list
  std::vector<std::string> joints;  ///< names, in the order of the encoders
};

/// True and planned poses at a frame.
struct TruePoses {
  slam::Stamp t{0};
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();  ///< camera
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();  ///< waist
  std::optional<Eigen::Isometry3d> X_PB = {};              ///< waist as planned; absent without a plan
  std::optional<Eigen::Isometry3d> X_WB_desired = {};      ///< waist on the commanded path, in a steered walk
};

using score::TrueFeet, score::TrueFoot;

/// True motion of the chest IMU.
struct TrueMotion {
  slam::Stamp t{0};
  Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v_WG = Eigen::Vector3d::Zero();  ///< m/s in W
};

using slam::BodyReading;

/// Writes a recording during a run. Memory use does not grow with its length. Throws FileError if a file
/// cannot be written, and std::logic_error for readings that ideal sensors cannot give: inertial readings
/// with gaps, different numbers of gyro and accelerometer readings, stamps that do not increase, or a joint
/// too many.
class RecordingWriter {
 public:
  /// `folder` is created; it must not exist yet.
  RecordingWriter(const fs::path& folder, const RecordingSetup& setup);
  ~RecordingWriter();

  /// png: the observation's image from encode_png(), if that has already been called. rig_pngs: the same for
  /// each reading of the rig, empty for a reading without an image.
  void add(const slam::Observation& ideal, std::string_view png = {},
           const std::vector<std::string>& rig_pngs = {});
  void add(const BodyReading& reading);  ///< at any rate; body readings of an observation are not written
  void add(const TruePoses& poses);      ///< once per frame
  void add(const TrueMotion& motion);    ///< at any rate
  void add(const TrueFeet& feet);        ///< at any rate
  /// Adds the torques of the servos (N·m), one per joint; at any rate.
  void add(slam::Stamp t, const Eigen::VectorXd& torques);
  void add(const score::Surface& surface);

  /// Adds all steps that a steered walk was able to correct. Other walks have no such file.
  void add(const std::vector<score::StepCorrection>& steps);

  /// Adds another small file, which the manifest lists.
  void add(const std::string& name, std::string_view text);

  /// Closes all files and writes the manifest. Readers reject folders without a manifest as unfinished.
  void finish();

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Reads a recording's observations one after another, never its truth. For missing, truncated, edited or
/// malformed data, throws FileError with file, line and column.
class RecordingReader {
 public:
  explicit RecordingReader(const fs::path& folder);
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;

  const RecordingSetup& setup() const;
  /// Returns the next observation, or nothing after the last. Images and points of rig sensors are checked
  /// against the manifest. They are left out if `wants` is false for the sensor (RigReading::sensor).
  std::optional<slam::Observation> next(const std::function<bool(int)>& wants = {});
  /// Returns the progress of next(), 0 to 1.
  double part() const;
  /// Returns a single hash for the whole recording.
  const std::string& hash() const;

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Ground truth of a run, for the score.
struct Truth {
  std::vector<files::TimedPose> camera, waist, waist_plan;  ///< X_WC, X_WB, X_PB at the frames
  /// The point in C whose positions are in `camera`; absent if `camera` has poses.
  std::optional<Eigen::Vector3d> positions_of = {};
  std::vector<TrueFeet> feet;
  std::vector<score::TrueForce> forces;
  std::vector<score::Surface> surfaces;
  std::vector<files::TimedPose> waist_desired;         ///< commanded X_WB; empty unless the walk was steered
  std::vector<score::StepCorrection> corrected_steps;  ///< empty unless the walk was steered
};

/// Reads the truth of a recording, after the filter has finished. Throws FileError as RecordingReader does.
Truth read_truth(const fs::path& folder);

/// Reads the observations that a live run or a replay gives the filter, bit for bit. Throws whatever
/// RecordingReader and SensorErrors throw.
class FilterInput {
 public:
  FilterInput(const fs::path& recording, const sensor_errors::ErrorOptions& errors, std::uint64_t seed)
      : reader_(recording), errors_(errors, seed, reader_.setup().rig) {}

  const RecordingSetup& setup() const { return reader_.setup(); }
  /// Returns the next observation in the order of arrival, or nothing after the last.
  std::optional<slam::Observation> next();
  /// Returns next(), skipping observations that the filter rejects because their stamps do not increase.
  std::optional<slam::Observation> next_in_order();
  /// Returns the progress of reading, 0 to 1.
  double part() const { return reader_.part(); }

 private:
  RecordingReader reader_;
  sensor_errors::SensorErrors errors_;
  std::deque<slam::Observation> arrived_;
  bool ended_ = false;
  std::optional<slam::Stamp> last_;
};

}  // namespace sim::recording
