// The one place in which files from outside are opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include "sim/files/file_error.h"

namespace sim::files {

/// Why a pipe, a device or a socket is refused.
inline constexpr const char* kNotRegular =
    "is not a regular file, expected one: pipes, devices and sockets are not read";

// The most bytes that a file of a kind may have: more than the program writes for an hour of walk at the
// highest rates, or than a person writes.
inline constexpr std::uintmax_t kMostOfYaml = 1 << 20, kMostOfJson = 64 << 20, kMostOfImage = 256 << 20;
/// Files that are read into memory as a whole, such as trajectories and logs.
inline constexpr std::uintmax_t kMostOfText = std::uintmax_t{2} << 30;
/// Files that are read row by row.
inline constexpr std::uintmax_t kMostOfRows = std::uintmax_t{16} << 30;

/// A regular file, or a link to one, that is read piece by piece. What the process was started with and is
/// named as such (/dev/stdin, and /dev/fd/N, which a shell passes for <(...)) may be a pipe. All members
/// throw FileError.
class InputFile {
 public:
  /// A file of more than `most` bytes is refused, before it is read where its size is known.
  InputFile(const std::filesystem::path& file, std::uintmax_t most);

  std::uintmax_t size() const { return size_; }  ///< bytes; 0 of a pipe
  /// The next bytes, none at the end of the file; they live until the next call.
  std::string_view next();

 private:
  /// An open file of the operating system, closed with this.
  struct Descriptor {
    explicit Descriptor(int opened) : fd(opened) {}
    Descriptor(Descriptor&& other) noexcept : fd(std::exchange(other.fd, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
      std::swap(fd, other.fd);
      return *this;
    }
    ~Descriptor();
    int fd;  ///< below zero: none
  };
  std::filesystem::path file_;
  Descriptor in_;
  std::uintmax_t most_, size_ = 0, read_ = 0;
  std::unique_ptr<char[]> piece_;
};

}  // namespace sim::files
