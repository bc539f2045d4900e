#include "sim/files/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace sim::files {
namespace {

namespace fs = std::filesystem;

// Whether the open file still has that name: it may have been renamed or removed before it was locked.
bool has_name(int fd, const fs::path& file) {
  struct stat locked {
  }, named{};
  return ::fstat(fd, &locked) == 0 && ::lstat(file.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
         locked.st_ino == named.st_ino;
}

// 0 when it is locked now, else errno.
int try_flock(int fd, int operation) {
  while (::flock(fd, operation) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

/// Opens a file to lock it; where nothing can be written, one that is there.
int open_to_lock(const fs::path& file, FileLock::IfAbsent if_absent) {
  const int make = if_absent == FileLock::IfAbsent::make ? O_CREAT : 0;
  const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | make, 0666);
  if (fd >= 0 || (errno != EACCES && errno != EROFS)) return fd;
  const int fault = errno, read_only = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  errno = fault;
  return read_only;
}

[[noreturn]] void fail_with(int fault, const fs::path& file, const std::string& what) {
  throw FileError(file, what + ": " + std::strerror(fault));
}

}  // namespace

FileLock::~FileLock() {
  if (fd_ >= 0) ::close(fd_);
}

std::optional<FileLock> FileLock::take(const fs::path& file, Mode mode, IfHeld if_held, IfAbsent if_absent) {
  const int operation =
      (mode == Mode::shared ? LOCK_SH : LOCK_EX) | (if_held == IfHeld::give_up ? LOCK_NB : 0);
  for (;;) {
    FileLock lock(open_to_lock(file, if_absent));
    if (lock.fd_ < 0 && errno == ENOENT && if_absent == IfAbsent::give_up) return std::nullopt;
    if (lock.fd_ < 0) fail_with(errno, file, "cannot be opened");
    const int fault = try_flock(lock.fd_, operation);
    if (fault == EWOULDBLOCK) return std::nullopt;
    if (fault != 0) fail_with(fault, file, "cannot be locked");
    if (has_name(lock.fd_, file)) return lock;
  }
}

std::optional<FileLock> FileLock::take_folder(const fs::path& folder) {
  FileLock lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.fd_ < 0) fail_with(errno, folder, "cannot be opened");
  if (try_flock(lock.fd_, LOCK_EX | LOCK_NB) == EWOULDBLOCK) return std::nullopt;
  return lock;
}

}  // namespace sim::files
