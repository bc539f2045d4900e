#include "tools/cli/shared/version.h"

#include <opencv2/core/utility.hpp>

#include "sim/files/hash.h"
#include "tools/cli/shared/live.h"

namespace cli {
namespace {

std::string cpuinfo(const std::string& field) {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(field)) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

}  // namespace

const char* const kVersion = GAITSLAM_VERSION;

std::map<std::string, std::string> libraries() {
  std::map<std::string, std::string> all;
  all["Eigen"] = fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
  all["OpenCV"] = cv::getVersionString();
  if (const std::string mujoco = mujoco_version(); !mujoco.empty()) all["MuJoCo"] = mujoco;
  return all;
}

result::ResultPlace result_place(const fs::path& folder, const std::string& models_hash,
                                 const fs::path& models) {
  return {folder, models, kVersion, kRevision, libraries(), models_hash};
}

std::string processor() { return cpuinfo("model name"); }

std::string recording_identity() {
  std::string text = fmt::format("{} {} {}", kRecordingSources, GAITSLAM_BUILD, cpuinfo("vendor_id"));
  for (const auto& [name, version] : libraries()) text += fmt::format(", {} {}", name, version);
  return text;
}

std::string program_identity() {
  const std::string revision = kRevision;
  if (revision != "unknown" && !revision.ends_with('+')) return fmt::format("{} {}", kVersion, revision);
  files::Hash hash;
  hash.add(files::read_text("/proc/self/exe"));
  return fmt::format("{} {}", kVersion, hash.hex());
}

std::string version_text() {
  std::string text = fmt::format("gaitslam {} (revision {})\n", kVersion, kRevision);
  for (const auto& [name, version] : libraries()) text += fmt::format("{} {}\n", name, version);
  return text + (mujoco_version().empty() ? "built without the simulator" : "");
}

}  // namespace cli
