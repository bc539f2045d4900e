// Writes a recorded run in the file formats of other SLAM programs: the filter's input, noise included, with
// the settings that each program needs and a README with its command line.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "sim/files/atomic_file.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {

/// The robot of a run. It comes from the simulator's model, to which exports have no access.
struct RobotDescription {
  /// The link that carries a sensor, and the head camera's pose in that link's frame in the calibration
  /// posture.
  struct Mounting {
    std::string link;
    Eigen::Isometry3d X_LC = Eigen::Isometry3d::Identity();
  };
  std::string urdf;                ///< its root is the link "waist"
  std::vector<std::string> links;  ///< the other links
  /// Returns the poses of these links in the waist's frame for the encoders' angles (rad). Throws
  /// std::runtime_error if the number of angles is not the robot's.
  std::function<std::vector<Eigen::Isometry3d>(const Eigen::VectorXd& q)> poses;
  std::map<std::string, Mounting> mountings;                    ///< by sensor name
  std::array<std::string, 2> soles{"left_foot", "right_foot"};  ///< the links of the left and right soles
};

/// A recorded run. result: its folder, which contains recording/ and, if a filter was run, estimate_cov.txt.
struct ExportedRun {
  fs::path result;
  std::string name;  ///< the scenario's name
  std::uint64_t seed = 1;
  sensor_errors::ErrorOptions errors;
  bool with_truth = true;  ///< include the true poses and the filter's estimate
  bool undistort = false;  ///< remove the lens distortion even for formats that support lenses
  std::shared_ptr<const RobotDescription> robot = nullptr;  ///< null: viewers draw no robot
  std::function<void(double)> progress = [](double) {};     ///< called with the completed fraction, 0 to 1
  /// Called with a description of data that the rig should provide but the export lacks.
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};

/// The rows of a file of a recording, merged with its frames by time; no rows if there is no such file.
/// Throws FileError.
class RecordedRows {
 public:
  /// file: such as truth/feet.csv; its stamps are in the first column.
  RecordedRows(const recording::Manifest& manifest, const std::string& file);

  /// Calls each(stamp, values) for the rows up to that time, except rows of earlier calls.
  void until(
      slam::Stamp t,
      const std::function<void(slam::Stamp, const std::vector<double>&)>& each = [](auto&&...) {});
  /// Reads the first row, whatever its time.
  void first() {
    if (rows_ && rows_->stamp()) until(*rows_->stamp());
  }

  std::vector<std::string> names;  ///< the titles of the columns after the stamp, without units
  std::vector<double> newest;      ///< values of the last row so far; empty before the first

 private:
  std::optional<recording::StampedRows> rows_;
};

/// Returns the names of the formats.
std::vector<std::string> export_formats();

/// Writes the folder, completely or not at all, in place of a marked one. Memory does not grow with the run's
/// length. Throws std::out_of_range for an unknown format, FileError if a file cannot be read or written.
void export_run(const ExportedRun& run, const std::string& format, const fs::path& folder);

}  // namespace sim::exports
