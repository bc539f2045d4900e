// Finds recordings in the cache, or makes them by simulating the walk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "sim/tune/recording_cache.h"
#include "tools/cli/jobs/run_all.h"

namespace cli {

class Recordings {
 public:
  /// models: the folder of the models of robot and rooms. Throws FileError, std::invalid_argument.
  explicit Recordings(std::filesystem::path models);

  /// The name of the recording of this scenario in the cache.
  std::string key(const sim::scenario::Scenario& scenario) const;

  /// The recording from the cache, every byte of it checked; nothing if it is missing.
  std::optional<sim::tune::CachedRecording> find(const sim::scenario::Scenario& scenario) const;

  /// The recording from the cache, made by this process if it is missing. Throws what a run throws.
  sim::tune::CachedRecording get(const sim::scenario::ReadScenario& read,
                                 const sim::result::Progress& progress) const;

  /// Makes each recording that is missing, and returns how its process ended; no complaint and exit code 0
  /// for a recording that existed.
  std::vector<Ended> make(const std::vector<sim::scenario::ReadScenario>& scenarios,
                          const Backend& backend) const;

  const sim::tune::CachePlace& place() const { return cache_.place(); }

 private:
  std::filesystem::path models_;
  std::string models_hash_, program_;
  sim::tune::RecordingCache cache_;
};

}  // namespace cli
