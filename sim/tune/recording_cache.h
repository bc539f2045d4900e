// The cache of recordings: each is made once and used by every run, sweep and tuning that needs it. Its
// folder has a limited size.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/atomic_file.h"

namespace sim::tune {

/// The folder of the cache and the size that it is kept to.
struct CachePlace {
  std::filesystem::path folder;
  std::uintmax_t most_bytes = 20'000'000'000;
};

/// The folder is $GAITSLAM_CACHE, else $XDG_CACHE_HOME/gaitslam, else $HOME/.cache/gaitslam; the size is
/// $GAITSLAM_CACHE_GB. Throws std::invalid_argument when that is no size, or none of the folders is set.
CachePlace cache_place();

/// A recording in use: no process removes it while this object lives.
struct CachedRecording {
  /// A result folder of the walk without a filter: recording/, about.json, scenario.yaml.
  std::filesystem::path folder;
  bool made = false;  ///< by the call that returned it
  files::FileLock lock;
};

/// Holds each recording in a folder <key>/ that appears whole or not at all. Several processes may use one
/// cache at the same time, and those that cannot write there what it holds.
class RecordingCache {
 public:
  /// Makes a complete result folder at the path it is given, which is not there yet.
  using Make = std::function<void(const std::filesystem::path&)>;
  /// Called with a description of each damaged file.
  using Say = std::function<void(const std::string&)>;

  explicit RecordingCache(CachePlace place) : place_(std::move(place)) {}

  /// The recording of that key, every byte of it checked; nothing if it is absent or damaged.
  std::optional<CachedRecording> find(const std::string& key, const Say& say) const;

  /// The recording of that key, made first if it is absent or damaged; while another process makes it, waits
  /// for that. After making one, removes the least recently used until the cache keeps to its size. Throws
  /// FileError, and what `make` throws.
  CachedRecording get(const std::string& key, const Make& make, const Say& say) const;

  struct Entry {
    std::string key, scenario;
    std::uint64_t seed = 0;
    std::uintmax_t bytes = 0;
    std::int64_t last_used_ns = 0;  ///< since 1970
    bool in_use = false;
  };
  /// All entries, the least recently used first. An entry has the cache's marker (sim/files/output_manifest.h);
  /// what else is in the folder is not the cache's.
  std::vector<Entry> list() const;
  /// The number of folders that are named like entries and have no marker.
  std::size_t others() const;

  struct Cleaned {
    std::size_t removed = 0, in_use = 0;  ///< entries; in_use: kept only because they are in use
    std::size_t foreign = 0;              ///< kept because files of others are in them
    std::uintmax_t bytes = 0;             ///< removed
  };
  /// Removes the least recently used entries, never one in use nor one with files of others in it, until the
  /// others take at most that much.
  Cleaned clean(std::uintmax_t most_bytes) const;

  const CachePlace& place() const { return place_; }

 private:
  std::filesystem::path lock_file(const std::string& key) const;
  bool is_own(const std::string& key) const;
  bool is_whole(const std::string& key, const Say& say) const;
  void make_entry(const std::string& key, const Make& make) const;
  Entry read_entry(const std::string& key) const;
  bool remove_if_unused(const std::string& key) const;

  CachePlace place_;
};

}  // namespace sim::tune
