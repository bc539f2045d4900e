// Recordings from the cache: found, or made by walking.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/bench/result.h"
#include "sim/bench/scenario.h"
#include "sim/tune/recording_cache.h"
#include "tools/cli/backend.h"

namespace cli {

class Recordings {
 public:
  /// models: the folder of the robot's and room's models. Throws FileError, std::invalid_argument.
  explicit Recordings(std::filesystem::path models);

  /// The name of this scenario's recording in the cache.
  std::string key(const sim::bench::Scenario& scenario) const;

  /// Found in the cache, every byte checked; nothing if it is not there.
  std::optional<sim::tune::CachedRecording> find(const sim::bench::Scenario& scenario) const;

  /// Found, or made by this process. Throws what a run throws.
  sim::tune::CachedRecording get(const sim::bench::ReadScenario& read,
                                 const sim::bench::Progress& progress) const;

  /// Makes each of them that is not there. How each made one's process ended; no complaint and exit code 0
  /// for those that were there.
  std::vector<Ended> make(const std::vector<sim::bench::Scenario>& scenarios, const Backend& backend) const;

  const sim::tune::CachePlace& place() const { return cache_.place(); }

 private:
  std::filesystem::path models_;
  std::string models_hash_, program_;
  sim::tune::RecordingCache cache_;
};

}  // namespace cli
