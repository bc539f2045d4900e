// Recorded walks of a suite, kept in memory so that many settings of the filter can be tried and scored on
// them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/regression/suite.h"
#include "sim/score/metrics.h"
#include "sim/score/run.h"
#include "sim/tracking/tracking.h"

/// One recording, decoded.
struct RecordedWalk {
  explicit RecordedWalk(const std::filesystem::path& result_folder);

  /// Replaces the images, frame by frame, by those of another walk, until that one ends.
  void take_images_of(const RecordedWalk& other);

  std::uint64_t seed;
  sim::recording::RecordingSetup setup;
  std::vector<slam::Observation> observations;
  sim::recording::Truth truth;
};

/// A setting of the filter: changes "key=value" to the scenario.
struct Variant {
  std::string name;
  std::vector<std::string> changes;
};

/// Reads "name: [key=value]...". Throws std::invalid_argument.
Variant read_variant(std::string_view line);

/// A setting tried on one walk.
struct Trial {
  sim::tracking::Tracked tracked;
  sim::score::Run run;
  sim::score::Metrics metrics;
  double filter_ms = 0;  ///< CPU, mean of a frame
};

/// Replays the walk with the scenario's file under these changes.
Trial try_on(const RecordedWalk& walk, const std::filesystem::path& scenario,
             const std::vector<std::string>& changes);

/// The runs of one scenario of a suite.
struct RecordedEntry {
  std::string name;
  std::filesystem::path scenario;
  std::vector<std::string> changes;            ///< key=value
  std::vector<std::filesystem::path> folders;  ///< result folders with a recording, one per seed
};

/// Runs `program record` (gaitslam) for what its cache lacks. Throws std::runtime_error if that fails.
std::vector<RecordedEntry> record_suite(const sim::regression::Suite& suite, const std::string& program);
