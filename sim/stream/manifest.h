// The list of a recording's files with sizes and hashes: what is truncated, edited or missing is found and
// named.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "sim/stream/file_error.h"

namespace sim::stream {

/// XXH3 with 128 bits, fed piece by piece.
class Hash {
 public:
  Hash();
  void add(std::string_view bytes);
  std::uint64_t bytes() const { return bytes_; }  ///< how many were added
  std::string hex() const;  ///< 32 hexadecimal digits, as the program xxh128sum prints them
 private:
  struct Free {
    void operator()(void* state) const;
  };
  std::unique_ptr<void, Free> state_;
  std::uint64_t bytes_ = 0;
};

/// A file being written, hashed as it is. Throws FileError when it cannot be.
class HashedFile {
 public:
  explicit HashedFile(const std::filesystem::path& file);
  void write(std::string_view bytes);
  void close();
  const Hash& hash() const { return hash_; }

 private:
  std::filesystem::path file_;
  std::ofstream out_;
  Hash hash_;
};

/// Writes `manifest.csv` into a folder. It appears under that name by finish() alone, so that a folder
/// without one is an incomplete recording. Memory does not grow with the number of files.
class ManifestWriter {
 public:
  explicit ManifestWriter(const std::filesystem::path& folder);
  void add(const std::string& path, const Hash& hash);  ///< path relative to the folder, with forward slashes
  void finish();

 private:
  std::filesystem::path folder_;
  HashedFile out_;
};

/// A folder's `manifest.csv`, and the checks against it.
class Manifest {
 public:
  /// Throws FileError: no manifest (the recording was never finished), or one that cannot be read.
  explicit Manifest(const std::filesystem::path& folder);

  /// Every listed file is there and has its size (contents are not read). Throws FileError naming the first
  /// that is not.
  void check_sizes() const;
  /// The file is listed and its content is what was recorded; reads it in pieces. Returns its full path.
  std::filesystem::path check(const std::string& path) const;
  /// The file's whole content, checked likewise.
  std::string read(const std::string& path) const;
  bool lists(const std::string& path) const { return entries_.contains(path); }
  /// One hash for the whole recording: the manifest's own.
  const std::string& hash() const { return hash_; }

 private:
  struct Entry {
    std::uint64_t bytes = 0;
    std::string hash;
  };
  /// Calls `take` with the pieces of a listed file; then complains unless they were what was recorded.
  void read_pieces(const std::string& path, const std::function<void(std::string_view)>& take) const;

  std::filesystem::path folder_;
  std::map<std::string, Entry> entries_;
  std::string hash_;
};

}  // namespace sim::stream
