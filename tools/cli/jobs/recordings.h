// Finds recordings in the cache, or makes them by simulating the walk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/recording/cache.h"
#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "tools/cli/jobs/backend.h"

namespace cli {

class Recordings {
 public:
  /// models: the folder of the models of robot and rooms. Throws FileError, std::invalid_argument.
  explicit Recordings(std::filesystem::path models);

  /// The name of the scenario's recording in the cache.
  std::string key(const sim::scenario::Scenario& scenario) const;

  /// Returns the recording from the cache after checking every byte, or nullopt if it is missing.
  std::optional<sim::recording::CachedRecording> find(const sim::scenario::Scenario& scenario) const;

  /// Returns the recording from the cache; this process records it if it is missing. Throws what a run
  /// throws.
  sim::recording::CachedRecording get(const sim::scenario::ReadScenario& read,
                                      const sim::result::Progress& progress) const;

  /// Makes each recording that is missing, and returns how its process ended; no complaint and exit code 0
  /// for a recording that existed.
  std::vector<Ended> make(const std::vector<sim::scenario::ReadScenario>& scenarios,
                          const Backend& backend) const;

  const sim::recording::CachePlace& place() const { return cache_.place(); }

 private:
  std::filesystem::path models_;
  std::string models_hash_, program_;
  sim::recording::Cache cache_;
};

}  // namespace cli
