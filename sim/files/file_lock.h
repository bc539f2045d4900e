// Locks on files, by which processes know of each other: the lock of a process that was killed is gone.
#pragma once

#include <filesystem>
#include <optional>
#include <utility>

#include "sim/files/file_error.h"

namespace sim::files {

/// A locked file, open (flock). The end of its life, or of the process, releases the lock; a program that
/// this process starts does not inherit it.
class FileLock {
 public:
  enum class Mode { shared, exclusive };
  enum class IfHeld { wait, give_up };
  enum class IfAbsent { make, give_up };

  /// Locks the file that has this name now. Nothing when another holds the lock, or when the file is not
  /// there, as far as these are to be given up for. A file that this process cannot write is locked as well.
  /// A symbolic link is not followed. Throws FileError.
  static std::optional<FileLock> take(const std::filesystem::path& file, Mode mode, IfHeld if_held,
                                      IfAbsent if_absent = IfAbsent::make);
  /// Locks a folder exclusively, without a file in it; nothing when another process holds it. Where the file
  /// system cannot lock folders this always succeeds. Throws FileError.
  static std::optional<FileLock> take_folder(const std::filesystem::path& folder);

  ~FileLock();
  FileLock(FileLock&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  FileLock& operator=(FileLock&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }

  int fd() const { return fd_; }

 private:
  explicit FileLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace sim::files
