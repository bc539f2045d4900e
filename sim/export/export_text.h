// Numbers, poses and calibrations as the exported files write them.
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

/// Returns "t tx ty tz qx qy qz qw" with the stamps of the exports.
inline std::string tum_text(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(recording::kEpoch + pose.t, pose.X);
  return text;
}

/// The motion of a recorded walk, from data that the program under test also has.
struct WalkMotion {
  std::vector<double> speeds_m_s;   ///< planned speeds of the moving camera, from frame to frame
  std::vector<double> turns_rad_s;  ///< rates of the chest gyro
};

/// Returns the value at this fraction (0 to 1) of the sorted values, or 0 if there are none.
double percentile(std::vector<double> values, double fraction);

/// The images that OpenVINS tracks.
struct TrackedImages {
  int every;            ///< one image in so many
  double frequency_hz;  ///< for OpenVINS, which drops images less than a period after the last one
};
/// OpenVINS's window of 11 images should span 0.15 m of the walk. Between two images, 90 % of the turns
/// should move corners by at most a tenth of the image's width, because optical flow follows only small
/// steps.
TrackedImages tracked_images(const slam::CameraIntrinsics& camera, double rate_hz, const WalkMotion& motion);

/// Writes mav0/ in the EuRoC/ASL layout, times.txt, and, for two gray cameras, times_stereo.txt with the
/// stamps that both have. images_within_imu: leaves out images before the first IMU reading and after the
/// last one.
WalkMotion write_mav0(const ExportContext& out, bool images_within_imu = false);

/// Returns whether the second gray camera sees enough of the head camera's view to be its stereo partner.
/// Warns if there is a second camera that does not see enough.
bool has_stereo(const ExportContext& out);

/// Returns settings of ORB-SLAM3 (v1.0) for a camera's images. Settings for the head camera include the IMU
/// and, if there is a stereo pair, stereo. depth: a depth camera registered to the camera, for settings
/// without IMU.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth, bool inertial);

}  // namespace sim::exports
