// A recording in memory, and a trial of the filter on it, as tunings and sweeps run them by the thousand.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/run.h"
#include "sim/tune/terms.h"

namespace sim::tune {

/// A recording that is read once and that any number of threads may use at the same time.
struct Recording {
  std::string name;                                              ///< "tangent_circle/seed-1"
  scenario::ReadScenario scenario;                               ///< of the walk
  scenario::Ending walk_ending = scenario::Ending::not_started;  ///< of the walk
  std::string hash;                                              ///< of the recording's files
  recording::RecordingSetup setup;
  /// In the order of arrival; images are views of `pictures`, which share no counter among threads.
  std::vector<slam::Observation> observations;
  std::vector<cv::Mat> pictures;
  /// The sensor errors that the observations contain; empty: the observations are those of ideal sensors.
  std::string errors;
  recording::Truth truth;  ///< for the score alone

  std::size_t bytes() const;  ///< of the pictures
};

/// Reads a result folder's recording, images decoded. Throws FileError and ConfigError as replay does.
Recording load(const std::filesystem::path& result_folder);

/// Reads the recording and applies the sensor errors of `scenario` (errors.*, seed), once for all trials that
/// share them.
Recording load(const std::filesystem::path& result_folder, const scenario::Scenario& scenario);

/// Reads the name and the hash of the recording alone.
Recording load_identity(const std::filesystem::path& result_folder);

/// The keys errors.* and the seed, which determine the sensor errors, as text.
std::string errors_of(const scenario::Scenario& scenario);

/// One run of the filter.
struct Trial {
  scenario::Ended ended;       ///< as in a result folder
  score::Metrics metrics;      ///< as a result folder's, bit for bit
  std::optional<Terms> terms;  ///< absent where the filter failed
  double lasted_fraction = 1;  ///< fraction of the recording until the filter failed
};

/// Applies the sensor errors of `scenario`, runs its filter and scores it. The scenario must have a slam
/// section, and the same sensor errors as the recording if that contains errors (else std::logic_error).
Trial run_trial(const Recording& recording, const scenario::ReadScenario& scenario);

}  // namespace sim::tune
