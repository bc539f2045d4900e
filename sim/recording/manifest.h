// The list of a recording's files with sizes and hashes, used to find missing, truncated and edited files.
#pragma once

#include <functional>
#include <map>

#include "sim/files/hash.h"

namespace sim::recording {

/// Writes `manifest.csv` into a folder. Memory use does not grow with the number of files. The file gets this
/// name only in finish(): a folder without it is an unfinished recording.
class ManifestWriter {
 public:
  explicit ManifestWriter(const fs::path& folder);
  void add(const std::string& path,
           const files::Hash& hash);  ///< path relative to the folder, with forward slashes
  void finish();

 private:
  fs::path folder_;
  files::HashedFile out_;
};

/// A folder's `manifest.csv`, and the checks against it.
class Manifest {
 public:
  /// Throws FileError if the manifest is missing, invalid, or lists a path outside the folder. Links are
  /// checked when a file is read.
  explicit Manifest(const fs::path& folder);

  /// Throws FileError for the first listed file that is missing or has a different size. Reads no file.
  void check_sizes() const;
  /// Checks every listed file as check() does.
  void check_all() const;
  /// Returns the full path of a listed file, read in pieces to check its hash. Throws FileError.
  fs::path check(const std::string& path) const;
  /// Returns the content of a listed file of at most `most` bytes. Throws FileError if it was changed.
  std::string read(const std::string& path, std::uintmax_t most = files::kMostOfText) const;
  bool lists(const std::string& path) const { return entries_.contains(path); }
  /// Returns the hash of the manifest, and so of the whole recording.
  const std::string& hash() const { return hash_; }

 private:
  struct Entry {
    std::uint64_t bytes = 0;
    std::string hash;
  };
  /// Calls `take` with the pieces of a listed file. Throws FileError if they differ from the recorded ones.
  void read_pieces(const std::string& path, std::uintmax_t most,
                   const std::function<void(std::string_view)>& take) const;

  fs::path folder_;
  std::map<std::string, Entry> entries_;
  std::string hash_;
};

}  // namespace sim::recording
