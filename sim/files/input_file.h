// The one place in which files from outside are opened.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "sim/files/file_error.h"

namespace sim::files {

/// Why a pipe, a device or a socket is refused.
inline constexpr const char* kNotRegular =
    "is not a regular file, expected one: pipes, devices and sockets are not read";

/// A regular file, or a link to one, that is read piece by piece. What the process was started with and is
/// named as such (/dev/stdin, and /dev/fd/N, which a shell passes for <(...)) may be a pipe. All members
/// throw FileError.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& file);

  std::uintmax_t size() const { return size_; }  ///< bytes; 0 of a pipe
  /// The next bytes, none at the end of the file; they live until the next call.
  std::string_view next();

 private:
  struct Close {
    void operator()(std::FILE* in) const { std::fclose(in); }
  };
  std::filesystem::path file_;
  std::unique_ptr<std::FILE, Close> in_;
  std::uintmax_t size_ = 0;
  std::string piece_;
};

}  // namespace sim::files
