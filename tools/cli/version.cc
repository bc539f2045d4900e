#include "tools/cli/version.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <opencv2/core/utility.hpp>

#include "tools/cli/live.h"

namespace cli {

const char* const kVersion = GAITSLAM_VERSION;

std::map<std::string, std::string> libraries() {
  std::map<std::string, std::string> all;
  all["Eigen"] = fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
  all["OpenCV"] = cv::getVersionString();
  if (const std::string mujoco = mujoco_version(); !mujoco.empty()) all["MuJoCo"] = mujoco;
  return all;
}

std::string version_text() {
  std::string text = fmt::format("gaitslam {} (revision {})\n", kVersion, kRevision);
  for (const auto& [name, version] : libraries()) text += fmt::format("{} {}\n", name, version);
  return text + (mujoco_version().empty() ? "built without the simulator" : "");
}

}  // namespace cli
