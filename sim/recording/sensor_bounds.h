// What no sensor states or reads, in files of this program and of others: refused before it is used.
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "sim/files/csv.h"

namespace YAML {
class Node;
}

namespace sim::recording {

/// Throws FileError where a map of a sensor.yaml has a key twice, or its rate_hz is none of a sensor.
void require_plausible(const std::filesystem::path& file, const YAML::Node& root);

/// The fields 1 to 3 and 4 to 6 of a row of an IMU. Throw FileError where a reading is beyond any sensor.
Eigen::Vector3d angular_rate(const files::CsvReader& row);  ///< rad/s
Eigen::Vector3d acceleration(const files::CsvReader& row);  ///< m/s^2

}  // namespace sim::recording
