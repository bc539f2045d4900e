// A recording held in memory, and a trial of the filter on it: what tuning and sweeps do thousands of times.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/score/evaluate.h"
#include "sim/stream/recording.h"
#include "sim/tune/terms.h"

namespace sim::tune {

/// A recording read once, for any number of threads to try filters on: nothing of it changes.
struct Recording {
  std::string name;               ///< "tangent_circle/seed-1"
  bench::ReadScenario scenario;   ///< as it was walked
  std::string walk_ending, hash;  ///< how the walk ended; of the recording's files
  stream::RecordingSetup setup;
  /// In the order of arrival; images are views of `pictures`, which share no counter among threads.
  std::vector<slam::Observation> observations;
  std::vector<cv::Mat> pictures;
  /// The sensor errors that the observations have in them already; empty: those of ideal sensors.
  std::string errors;
  stream::Truth truth;  ///< for the score alone

  std::size_t bytes() const;  ///< of the pictures
};

/// Reads a result folder's recording, images decoded. Throws FileError and ConfigError as replay does.
Recording load(const std::filesystem::path& result_folder);

/// Likewise, with the sensor errors of `scenario` (errors.*, seed) applied once for all trials that share
/// them.
Recording load(const std::filesystem::path& result_folder, const bench::Scenario& scenario);

/// Its name and hash alone.
Recording load_identity(const std::filesystem::path& result_folder);

/// What shapes the sensor errors, as text: the keys errors.* and the seed.
std::string errors_of(const bench::Scenario& scenario);

/// One run of the filter.
struct Trial {
  std::string ending, cause;   ///< as a result folder's
  score::Metrics metrics;      ///< as a result folder's, bit for bit
  std::optional<Terms> terms;  ///< absent where the filter failed
  double lasted_fraction = 1;  ///< of the recording until it failed
};

/// Sensor errors, filter and score of `scenario` on the recording, from memory. The scenario must have a slam
/// section; where the recording has errors in it already, its own must be the same (std::logic_error).
Trial run_trial(const Recording& recording, const bench::ReadScenario& scenario);

}  // namespace sim::tune
