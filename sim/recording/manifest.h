// The list of a recording's files with sizes and hashes, which names the file that is missing, truncated or
// edited.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "sim/files/hash.h"
#include "sim/files/text.h"

namespace sim::recording {

/// Writes `manifest.csv` into a folder. It has that name only after finish(), so that a folder without one is
/// an unfinished recording. Memory does not grow with the number of files.
class ManifestWriter {
 public:
  explicit ManifestWriter(const std::filesystem::path& folder);
  void add(const std::string& path,
           const files::Hash& hash);  ///< path relative to the folder, with forward slashes
  void finish();

 private:
  std::filesystem::path folder_;
  files::HashedFile out_;
};

/// A folder's `manifest.csv`, and the checks against it.
class Manifest {
 public:
  /// Throws FileError: no manifest (the recording was never finished), one that cannot be read, or one that
  /// lists a file outside the folder, be it by a link.
  explicit Manifest(const std::filesystem::path& folder);

  /// Every listed file is there and has its size (contents are not read). Throws FileError naming the first
  /// that is not.
  void check_sizes() const;
  /// The file is listed and its content is what was recorded; reads it in pieces. Returns its full path.
  std::filesystem::path check(const std::string& path) const;
  /// The whole content of a listed file, `most` bytes at most. Throws FileError unless it is what was
  /// recorded.
  std::string read(const std::string& path, std::uintmax_t most = files::kMostOfText) const;
  bool lists(const std::string& path) const { return entries_.contains(path); }
  /// The manifest's own hash, which stands for the whole recording.
  const std::string& hash() const { return hash_; }

 private:
  struct Entry {
    std::uint64_t bytes = 0;
    std::string hash;
  };
  /// Calls `take` with the pieces of a listed file, then throws FileError unless they are what was recorded.
  void read_pieces(const std::string& path, std::uintmax_t most,
                   const std::function<void(std::string_view)>& take) const;

  std::filesystem::path folder_;
  std::map<std::string, Entry> entries_;
  std::string hash_;
};

}  // namespace sim::recording
