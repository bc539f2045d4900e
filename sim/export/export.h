// A recorded run in the file formats of other SLAM programs: the filter's input, noise included, with the
// settings that each program needs and a README with its command line.
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

/// The robot of a run. The simulator's model supplies it, which exports do not see.
struct RobotDescription {
  /// The link that carries a sensor, and the head camera in its frame in the posture of the calibration.
  struct Mounting {
    std::string link;
    Eigen::Isometry3d X_LC = Eigen::Isometry3d::Identity();
  };
  std::string urdf;                ///< its root is the link "waist"
  std::vector<std::string> links;  ///< the others
  /// The poses of these links in the waist's frame, by the angles (rad) of the encoders. Throws
  /// std::runtime_error for another number of angles than the robot has.
  std::function<std::vector<Eigen::Isometry3d>(const Eigen::VectorXd& q)> poses;
  std::map<std::string, Mounting> mountings;                    ///< by the names of the sensors
  std::array<std::string, 2> soles{"left_foot", "right_foot"};  ///< the links of left and right sole
};

/// A recorded run. result: its folder, with recording/ and, if a filter was run, estimate_cov.txt.
struct ExportedRun {
  fs::path result;
  std::string name;  ///< of the scenario
  std::uint64_t seed = 1;
  sensor_errors::ErrorOptions errors;
  bool with_truth = true;  ///< include the true poses and the filter's estimate
  bool undistort = false;  ///< remove the lens distortion also for formats that know lenses
  std::shared_ptr<const RobotDescription> robot = nullptr;  ///< null: viewers draw none
  std::function<void(double)> progress = [](double) {};     ///< called with the completed fraction, 0 to 1
  /// Called with what the export lacks, although the rig promises it.
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};

/// The rows of mav0/<sensor>/data.csv of a recording, merged with its frames by time; none without such a
/// file. Throws FileError.
class RecordedRows {
 public:
  RecordedRows(const fs::path& recording, const std::string& sensor);

  /// Calls each(stamp, values) for the rows until then that no earlier call has had.
  void until(
      slam::Stamp t,
      const std::function<void(slam::Stamp, const std::vector<double>&)>& each = [](auto&&...) {});

  std::vector<std::string> names;  ///< the titles of the columns after the stamp, without units
  std::vector<double> newest;      ///< the values of the last row until then; empty before the first

 private:
  std::optional<recording::StampedRows> rows_;
};

/// Returns the names of the formats.
std::vector<std::string> export_formats();

/// Writes the folder, completely or not at all. Memory does not grow with the run's length. Throws
/// std::out_of_range for an unknown format, FileError if a file cannot be read or written.
void export_run(const ExportedRun& run, const std::string& format, const fs::path& folder,
                files::Existing existing);

}  // namespace sim::exports
