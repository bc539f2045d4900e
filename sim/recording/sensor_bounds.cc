#include "sim/recording/sensor_bounds.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>

#include "sim/files/text.h"

namespace sim::recording {
namespace {

constexpr double kLeastRate = 1e-3, kLargestRate = 1e6;  // Hz
constexpr double kLargestReading = 1e7;  // rad/s, m/s^2: ten times the largest spike that a scenario may have

[[noreturn]] void fail(const std::filesystem::path& file, const YAML::Mark& mark, const std::string& why) {
  throw files::FileError(file, static_cast<std::size_t>(mark.line) + 1,
                         static_cast<std::size_t>(mark.column) + 1, why);
}

void require_keys_once(const std::filesystem::path& file, const YAML::Node& map) {
  std::map<std::string, int> lines;
  for (const auto& entry : map) {
    const std::string& key = entry.first.Scalar();
    const YAML::Mark mark = entry.first.Mark();
    const auto [first, is_new] = lines.emplace(key, mark.line + 1);
    if (!is_new && entry.first.IsScalar())
      fail(file, mark, fmt::format("{}: given twice, first in line {}, expected once", key, first->second));
  }
}

void require_rate(const std::filesystem::path& file, const YAML::Node& rate) {
  const auto hz = files::parse_finite(rate.Scalar());
  if (!hz || *hz < kLeastRate || *hz > kLargestRate)
    fail(file, rate.Mark(),
         fmt::format("rate_hz: expected a number of Hz from {} to {:.0f}, found \"{}\"", kLeastRate,
                     kLargestRate, rate.Scalar()));
}

Eigen::Vector3d reading(const files::CsvReader& row, std::size_t first, const char* sensor,
                        const char* unit) {
  const Eigen::Vector3d values = row.vector(first);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const double value = values[static_cast<Eigen::Index>(axis)]; std::abs(value) > kLargestReading)
      row.fail(first + axis, fmt::format("{0}: {1} {2}, expected from -{3:.0f} to {3:.0f} {2}", sensor, value,
                                         unit, kLargestReading));
  return values;
}

}  // namespace

void require_plausible(const std::filesystem::path& file, const YAML::Node& root) {
  if (!root.IsMap()) return;
  require_keys_once(file, root);
  for (const char* pose : {"T_BS", "T_SB", "T_WC_start"})
    if (root[pose] && root[pose].IsMap()) require_keys_once(file, root[pose]);
  if (root["rate_hz"]) require_rate(file, root["rate_hz"]);
}

Eigen::Vector3d angular_rate(const files::CsvReader& row) { return reading(row, 1, "gyroscope", "rad/s"); }
Eigen::Vector3d acceleration(const files::CsvReader& row) {
  return reading(row, 4, "accelerometer", "m/s^2");
}

}  // namespace sim::recording
