// XXH3 hashes of bytes and of files while they are written; SHA-256.
#pragma once

#include <fstream>

#include "sim/files/text.h"

namespace sim::files {

/// XXH3 with 128 bits, fed piece by piece.
class Hash {
 public:
  Hash();
  void add(std::string_view bytes);
  /// Adds the number of bytes first, so that ("ab", "c") and ("a", "bc") differ.
  void add_part(std::string_view bytes);
  std::uint64_t bytes() const { return bytes_; }  ///< how many were added
  std::string hex() const;  ///< 32 hexadecimal digits, as the program xxh128sum prints them
 private:
  std::unique_ptr<void, void (*)(void*)> state_;
  std::uint64_t bytes_ = 0;
};

/// A file that is hashed while it is written. All members throw FileError.
class HashedFile {
 public:
  explicit HashedFile(const fs::path& file);
  void write(std::string_view bytes);
  void close();
  const Hash& hash() const { return hash_; }

 private:
  fs::path file_;
  std::ofstream out_;
  Hash hash_;
};

/// Returns the SHA-256 (FIPS 180-4), 32 bytes, which identifies the pages' scripts.
std::string sha256(std::string_view bytes);

}  // namespace sim::files
