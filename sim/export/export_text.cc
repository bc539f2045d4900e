#include "sim/export/export_text.h"

#include <fmt/format.h>

#include "sim/recording/recording.h"

namespace sim::exports {

std::string written_seconds(slam::Stamp t) {
  return fmt::format("{}.{:09}", recording::file_stamp(t) / 1'000'000'000,
                     recording::file_stamp(t) % 1'000'000'000);
}

std::string real(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view between) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}{}, {}, {}, {}{}", row ? between : "", before, real(X(row, 0)), real(X(row, 1)),
                        real(X(row, 2)), real(X(row, 3)), after);
  return text;
}

std::string tum_text(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(recording::kEpoch + pose.t, pose.X);
  return text;
}

LensModel lens_model(const slam::CameraIntrinsics& camera) {
  if (const auto* k = std::get_if<slam::Equidistant>(&camera.lens))
    return {true, {k->k1, k->k2, k->k3, k->k4}};
  return {false, {}};
}

}  // namespace sim::exports
