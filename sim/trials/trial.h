// A recording in memory, and one run of the filter on it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/trials/terms.h"

namespace sim::trials {

/// A recording that is read once and that several threads may use at the same time.
struct Recording {
  std::string name;                     ///< "tangent_circle/seed-1"
  std::string walk_ending, walk_cause;  ///< how the walk ended
  std::string hash;                     ///< of the recording's files
  recording::RecordingSetup setup;
  /// In the order of arrival; images are views of `pictures`, which share no counter among threads.
  std::vector<slam::Observation> observations;
  std::vector<cv::Mat> pictures;
  /// The sensor errors in the observations, see errors_of; empty if the sensors are ideal.
  std::string errors;
  recording::Truth truth;  ///< for the score only
};

/// Reads a result folder's recording, images decoded. Throws FileError and ConfigError as replay does.
Recording load(const std::filesystem::path& result_folder);

/// Reads the recording and applies the sensor errors of `scenario` (errors.*, seed) for all trials that share
/// them.
Recording load(const std::filesystem::path& result_folder, const scenario::Scenario& scenario);

/// Reads only the name and the hash of the recording.
Recording load_identity(const std::filesystem::path& result_folder);

/// The keys errors.* and the seed, which determine the sensor errors, as text.
std::string errors_of(const scenario::Scenario& scenario);

/// One run of the filter.
struct Trial {
  std::string ending, cause;   ///< as a result folder's
  score::Metrics metrics;      ///< as a result folder's, bit for bit
  std::optional<Terms> terms;  ///< absent if the filter failed
  double lasted_fraction = 1;  ///< fraction of the recording until the filter failed
};

/// Applies the sensor errors of `scenario` unless the recording contains them, runs its filter and scores it.
/// The scenario must have a slam section. Throws std::logic_error if the recording contains other errors.
Trial run_trial(const Recording& recording, const scenario::ReadScenario& scenario);

}  // namespace sim::trials
