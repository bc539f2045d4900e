// Numbers, poses and calibrations in the notations of the exported files.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/export/export_context.h"

namespace sim::exports {

/// "1000000000.033000000"
inline std::string written_seconds(slam::Stamp t) {
  return fmt::format("{}.{:09}", recording::file_stamp(t) / 1'000'000'000,
                     recording::file_stamp(t) % 1'000'000'000);
}

/// The fewest digits that round-trip, with a decimal point: some readers reject the integer 1.
inline std::string real(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

/// Four rows of four numbers, each row between `before` and `after`, `between` them: "[1.0, 0.0, ...]\n[...".
inline std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                               std::string_view between) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}{}, {}, {}, {}{}", row ? between : "", before, real(X(row, 0)), real(X(row, 1)),
                        real(X(row, 2)), real(X(row, 3)), after);
  return text;
}

/// "t tx ty tz qx qy qz qw" with the stamps of the exports.
inline std::string tum_text(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(recording::kEpoch + pose.t, pose.X);
  return text;
}

/// The motion of a recorded walk, as the program under test can know it.
struct WalkMotion {
  std::vector<double> speeds_m_s;   ///< planned, of the moving camera, from frame to frame
  std::vector<double> turns_rad_s;  ///< rates of the chest gyro
};

/// Returns the value at this fraction, 0 to 1, of the sorted values; 0 without values.
double percentile(std::vector<double> values, double fraction);

/// The images that OpenVINS tracks.
struct TrackedImages {
  int every;            ///< one of so many
  double frequency_hz;  ///< for OpenVINS, which drops images earlier than its period after the last one
};
/// OpenVINS's window of 11 images should span a walk of 0.15 m. Between two images the faster tenth of the
/// turns should move no corner by more than a tenth of the image's width, as optical flow follows only small
/// steps.
TrackedImages tracked_images(const slam::CameraIntrinsics& camera, double rate_hz, const WalkMotion& motion);

/// Writes mav0/ in the EuRoC/ASL layout, times.txt, and for two gray eyes times_stereo.txt: the stamps that
/// both have. images_within_imu: without the images before the first reading and after the last one.
WalkMotion write_mav0(const ExportContext& out, bool images_within_imu = false);

/// Returns whether the second gray camera sees enough of what the head camera sees to be its stereo partner.
/// Warns if there is one that does not.
bool has_stereo(const ExportContext& out);

/// Returns settings of ORB-SLAM3 (v1.0) for images of a camera; of the head camera with IMU and, if there is
/// a stereo pair, stereo. depth: a depth camera registered to it, for settings without IMU.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth, bool inertial);

}  // namespace sim::exports
