// The cache of recordings: each walk is recorded once and then used by every run, sweep and tuning.
#pragma once

#include <functional>

#include "sim/files/atomic_file.h"

namespace sim::recording {

/// The folder of the cache and the size to which it is limited.
struct CachePlace {
  fs::path folder;
  std::uintmax_t most_bytes = 20'000'000'000;
};

/// Returns the folder ($GAITSLAM_CACHE, otherwise $XDG_CACHE_HOME/gaitslam, otherwise $HOME/.cache/gaitslam)
/// and the size ($GAITSLAM_CACHE_GB). Throws std::invalid_argument if the size is not a number or no folder
/// is set.
CachePlace cache_place();

/// A recording in use: no process removes it while this object lives.
struct CachedRecording {
  /// A result folder of the walk without a filter: recording/, about.json, scenario.yaml.
  fs::path folder;
  bool made = false;  ///< recorded by the call that returned it
  files::FileLock lock;
};

/// Keeps each recording in a folder <key>/ that appears whole or not at all. Processes may share a cache,
/// even if some of them can only read it.
class Cache {
 public:
  /// Creates a complete result folder at a path that does not exist yet.
  using Make = std::function<void(const fs::path&)>;
  /// Receives a description of each damaged file.
  using Say = std::function<void(const std::string&)>;

  explicit Cache(CachePlace place) : place_(std::move(place)) {}

  /// Returns the recording of that key after checking every byte, or nullopt if it is missing or damaged.
  std::optional<CachedRecording> find(const std::string& key, const Say& say) const;

  /// Returns the recording with that key. If it is missing or damaged it is recorded while other processes
  /// wait, and the least recently used recordings beyond the cache's size are removed. Throws FileError, and
  /// whatever `make` throws.
  CachedRecording get(const std::string& key, const Make& make, const Say& say) const;

  struct Entry {
    std::string key;
    std::uintmax_t bytes = 0;
    std::int64_t last_used_ns = 0;  ///< since 1970
  };
  /// Returns the entries (folders with the program's marker), least recently used first.
  std::vector<Entry> list() const;

  struct Cleaned {
    std::size_t removed = 0, kept = 0;  ///< kept: in use
    std::uintmax_t bytes = 0;           ///< bytes removed
  };
  /// Removes the least recently used entries until the others take at most this many bytes. Keeps entries in
  /// use.
  Cleaned clean(std::uintmax_t most_bytes) const;

  const CachePlace& place() const { return place_; }

 private:
  fs::path lock_file(const std::string& key) const;
  bool is_whole(const std::string& key, const Say& say) const;
  void make_entry(const std::string& key, const Make& make) const;
  Entry read_entry(const std::string& key) const;
  bool remove_if_unused(const std::string& key) const;

  CachePlace place_;
};

}  // namespace sim::recording
