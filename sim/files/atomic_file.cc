#include "sim/files/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>

namespace sim::files {
namespace {

using How = FileLock::How;

constexpr int kAttempts = 150;
constexpr useconds_t kPauseUs = 20'000;  // 3 s in all

// Returns false and sets errno if the file cannot be locked.
bool lock_open(int fd, int operation) {
  while (::flock(fd, operation) != 0)
    if (errno != EINTR) return false;
  return true;
}

// Opens a file to lock it: for reading if it cannot be written.
int open_to_lock(const fs::path& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_CREAT, 0666);
  if (fd >= 0 || (errno != EACCES && errno != EROFS)) return fd;
  const int fault = errno, read_only = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  errno = fault;
  return read_only;
}

fs::path parent_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

constexpr const char *kPartial = "partial", *kOld = "old";

fs::path sibling_of(const fs::path& target, const char* kind) {
  return parent_of(target) / fmt::format(".{}.{}", target.filename().string(), kind);
}

fs::file_status status_of(const fs::path& path) {
  std::error_code fault;
  return fs::symlink_status(path, fault);
}

bool is_real_folder(const fs::path& path) { return fs::is_directory(status_of(path)); }
bool is_there(const fs::path& path) { return fs::exists(status_of(path)); }

void rename_file(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) fail_by_errno(to, "cannot be written");
}

using Sync = int(int);

void flush(const fs::path& path, Sync* sync) {
  const Descriptor opened(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (opened.fd < 0) fail_by_errno(path, "cannot be opened");
  if (sync(opened.fd) != 0) fail_by_errno(path, "cannot be flushed to disk");
}

constexpr std::string_view kMarkerText =
    "# Made by gaitslam. With --force it replaces whole results, with everything in them.\n";

// Does not follow links.
void empty_but_marker(const fs::path& folder, Keeps keeps = Keeps::nothing) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool keep = keeps == Keeps::marked_folders && has_marker(entry) &&
                      !entry.path().filename().string().starts_with('.');
    if (entry.path() == folder / kMarker || keep) continue;
    std::error_code fault;
    fs::remove_all(entry.path(), fault);
    if (fault) throw FileError(entry.path(), "cannot be removed: " + fault.message());
  }
}

// Creates the folder, locks its marker and removes everything else in it.
FileLock begin_partial(const fs::path& partial, const fs::path& target, Keeps keeps) {
  for (;;) {
    std::error_code fault;
    fs::create_directories(parent_of(target), fault);
    if (!fault) fs::create_directory(partial, fault);
    if (fault) fail_by_errno(target, "cannot be created", fault.value());
    require_replaceable(partial);
    try {
      auto lock = FileLock::acquire(partial / kMarker, How::soon);
      if (!lock)
        throw FileError(target, "is being written by another process: wait for it, or name another folder");
      empty_but_marker(partial, keeps);
      write_text(partial / kMarker, kMarkerText);
      return std::move(*lock);
    } catch (const FileError&) {
      if (is_there(partial)) throw;  // otherwise another process has renamed or removed it
    }
  }
}

fs::path replaceable(fs::path target) {
  if (!target.has_filename()) target = target.parent_path();  // without a trailing slash
  require_replaceable(target);
  return target;
}

}  // namespace

std::optional<FileLock> FileLock::acquire(const fs::path& file, How how) {
  const bool waits = how == How::shared || how == How::exclusive;
  const int operation = (how == How::shared ? LOCK_SH : LOCK_EX) | (waits ? 0 : LOCK_NB);
  for (int attempts_left = how == How::soon ? kAttempts : 0;;) {
    FileLock lock(open_to_lock(file));
    if (lock.fd() < 0) fail_by_errno(file, "cannot be opened");
    if (!lock_open(lock.fd(), operation)) {
      if (errno != EWOULDBLOCK) fail_by_errno(file, "cannot be locked");
      if (attempts_left-- == 0) return std::nullopt;
      ::usleep(kPauseUs);
      continue;
    }
    struct stat locked {
    }, named{};
    if (::fstat(lock.fd(), &locked) == 0 && ::lstat(file.c_str(), &named) == 0 &&
        locked.st_dev == named.st_dev && locked.st_ino == named.st_ino)
      return lock;  // otherwise it was renamed or removed before it was locked
  }
}

void write_all(int fd, const fs::path& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_by_errno(file, "cannot be written");
    bytes.remove_prefix(std::size_t(n));
  }
}

void require_regular(const fs::path& file) {
  std::error_code fault;
  const fs::file_status status = fs::status(file, fault);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(file, "cannot be written: it is not a regular file");
}

// A process that is killed in between leaves the old result complete, as .<target>.old.
void publish(const fs::path& written, const fs::path& target) {
  const fs::path old = sibling_of(target, kOld);
  flush(written, is_real_folder(written) ? ::syncfs : ::fsync);
  if (has_marker(target)) {
    remove_marked(old);
    rename_file(target, old);
  }
  rename_file(written, target);
  flush(parent_of(target), ::fsync);
  remove_marked(old);
}

void write_atomically(const fs::path& file, std::string_view bytes) {
  require_regular(file);
  struct stat replaced {};
  const bool replaces = ::stat(file.c_str(), &replaced) == 0;
  const fs::path temporary = sibling_of(file, kPartial);
  const auto lock = FileLock::acquire(temporary, How::exclusive);
  try {
    if (::ftruncate(lock->fd(), 0) != 0) fail_by_errno(file, "cannot be written");
    write_all(lock->fd(), file, bytes);
    if (replaces && ::fchmod(lock->fd(), replaced.st_mode & ACCESSPERMS) != 0)
      fail_by_errno(file, "cannot set its permissions");
    publish(temporary, file);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

bool has_marker(const fs::path& folder) {
  return is_real_folder(folder) && fs::is_regular_file(status_of(folder / kMarker));
}

void require_replaceable(const fs::path& folder) {
  const fs::file_status status = status_of(folder);
  if (!fs::exists(status)) return;
  if (fs::is_symlink(status)) throw FileError(folder, "is a symbolic link, expected a folder or a new name");
  if (!fs::is_directory(status)) throw FileError(folder, "is a file, expected a folder or a new name");
  std::error_code gone;
  if (!has_marker(folder) && !fs::is_empty(folder, gone) && !gone)
    throw FileError(folder, "was not created by gaitslam: move it away, or name another folder");
}

void mark_folder(const fs::path& folder) {
  require_replaceable(folder);
  if (has_marker(folder)) return;
  std::error_code fault;
  fs::create_directories(folder, fault);
  if (fault) fail_by_errno(folder, "cannot be created", fault.value());
  write_text(folder / kMarker, kMarkerText);
}

void remove_marked(const fs::path& folder) {
  if (!has_marker(folder)) return;
  try {
    empty_but_marker(folder);
  } catch (const std::exception&) {
    return;
  }
  std::error_code ignored;
  fs::remove(folder / kMarker, ignored);
  fs::remove(folder, ignored);  // fails if another process has made it again
}

void remove_leftovers(const fs::path& folder) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with('.') || !(name.ends_with(".partial") || name.ends_with(".old"))) continue;
    if (has_marker(entry)) try {
        if (const auto lock = FileLock::acquire(entry.path() / kMarker, How::try_exclusive))
          remove_marked(entry);
      } catch (const FileError&) {  // another user's, or removed by another process
      }
  }
}

AtomicFolder::AtomicFolder(fs::path target, Keeps keeps)
    : target_(replaceable(std::move(target))),
      path_(sibling_of(target_, kPartial)),
      keeps_(keeps),
      lock_(begin_partial(path_, target_, keeps)) {}

AtomicFolder::~AtomicFolder() {
  if (!committed_ && keeps_ == Keeps::nothing) remove_marked(path_);
}

void AtomicFolder::commit() {
  publish(path_, target_);
  committed_ = true;
}

}  // namespace sim::files
