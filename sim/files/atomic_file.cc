#include "sim/files/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace sim::files {
namespace {

using How = FileLock::How;

constexpr int kAttempts = 150;
constexpr useconds_t kPauseUs = 20'000;  // 3 s in all: enough for a killed process to end

// Returns false and sets errno if the file cannot be locked.
bool lock_open(int fd, int operation) {
  while (::flock(fd, operation) != 0)
    if (errno != EINTR) return false;
  return true;
}

// Opens a file to lock it: for reading if it cannot be written.
int open_to_lock(const fs::path& file, int make) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | make, 0666);
  if (fd >= 0 || (errno != EACCES && errno != EROFS)) return fd;
  const int fault = errno, read_only = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  errno = fault;
  return read_only;
}

// Replaces the content of a file that has been opened but not yet written.
void write_whole(int fd, const fs::path& file, std::string_view bytes) {
  if (::ftruncate(fd, 0) != 0) fail_by_errno(file, "cannot be written");
  write_all(fd, file, bytes);
}

fs::path parent_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

fs::path partial_of(const fs::path& target) {
  return parent_of(target) / fmt::format(".{}.partial", target.filename().string());
}

// Flushes a folder, or its whole file system, to disk.
void sync_folder(const fs::path& folder, bool whole_file_system = false) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.fd < 0) fail_by_errno(folder, "cannot be opened");
  if ((whole_file_system ? ::syncfs(opened.fd) : ::fsync(opened.fd)) != 0)
    fail_by_errno(folder, "cannot be flushed to disk");
}

void rename_file(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) fail_by_errno(to, "cannot be written");
}

fs::file_status status_of(const fs::path& path) {
  std::error_code fault;
  return fs::symlink_status(path, fault);
}

bool is_real_folder(const fs::path& path) { return fs::is_directory(status_of(path)); }
bool is_real_file(const fs::path& path) { return fs::is_regular_file(status_of(path)); }
bool is_there(const fs::path& path) { return fs::exists(status_of(path)); }

constexpr std::string_view kMarkerStart = "# Made by gaitslam",
                           kMarkerText =
                               "# Made by gaitslam, which moves this folder to earlier-<n> before "
                               "it is replaced.\n";
constexpr const char* kWhatToDo = "move it away, or name another folder";

// The first folder earlier-<n> in the folder that contains none of these names. It is created if missing.
fs::path earlier_without(const fs::path& folder, const std::vector<std::string>& names) {
  for (int n = 1;; ++n) {
    const fs::path earlier = folder / fmt::format("earlier-{}", n);
    if (::mkdir(earlier.c_str(), 0777) != 0 && errno != EEXIST) fail_by_errno(earlier, "cannot be created");
    if (is_real_folder(earlier) &&
        std::ranges::none_of(names, [&](const std::string& name) { return is_there(earlier / name); }))
      return earlier;
  }
}

// Renames the folder to its target. An existing target moves to earlier-<n>, in one step if the file system
// can exchange them. The old marker is locked so that no process takes it for a leftover.
void put_in_place(const fs::path& partial, const fs::path& target) {
  if (::rename(partial.c_str(), target.c_str()) == 0) return sync_folder(parent_of(target));
  if (errno != ENOTEMPTY && errno != EEXIST) fail_by_errno(target, "cannot be created");
  const auto old = FileLock::acquire(target / kMarker, How::try_existing);
  const std::string name = target.filename();
  const fs::path earlier = earlier_without(parent_of(target), {name});
  if (::renameat2(AT_FDCWD, partial.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) {
    rename_file(partial, earlier / name);
  } else {
    rename_file(target, earlier / name);
    rename_file(partial, target);
  }
  sync_folder(earlier);
  sync_folder(parent_of(target));
}

// The final name of a partial folder or file.
fs::path target_of(const fs::path& partial) {
  const std::string name = partial.filename();
  return partial.parent_path() / name.substr(1, name.rfind(".partial") - 1);
}

// Gives a complete folder that a killed process left behind its name, or sets it aside if the name is taken.
void recover(const fs::path& partial) {
  const fs::path target = target_of(partial);
  rename_file(partial, is_there(target)
                           ? earlier_without(parent_of(target), {target.filename()}) / target.filename()
                           : target);
}

// Removes everything in the folder except its marker. Does not follow links.
void empty_but_marker(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path() == folder / kMarker) continue;
    std::error_code fault;
    fs::remove_all(entry.path(), fault);
    if (fault) throw FileError(entry.path(), "cannot be removed: " + fault.message());
  }
}

// Creates and locks the folder. Empties it if a killed process left it behind.
FileLock begin_partial(const fs::path& partial, const fs::path& target) {
  for (int attempt = 0; attempt <= kAttempts; ++attempt, ::usleep(kPauseUs)) {
    std::error_code error;
    fs::create_directories(parent_of(target), error);
    if (error) fail_by_errno(parent_of(target), "cannot be created", error.value());
    fs::create_directory(partial, error);
    if (error) fail_by_errno(target, "cannot be created", error.value());
    if (!is_real_folder(partial))
      throw FileError(target, "cannot be created: " + partial.string() + " exists");
    if (!is_there(partial / kMarker) && !fs::is_empty(partial))
      throw FileError(partial, "was not created by gaitslam, which needs this name: move it away");
    try {
      if (auto lock = FileLock::acquire(partial / kMarker, How::try_exclusive)) {
        if (has_marker(partial)) {
          recover(partial);
          continue;
        }
        empty_but_marker(partial);
        write_whole(lock->fd(), partial, "");
        return std::move(*lock);
      }
    } catch (const FileError&) {
      if (is_there(partial)) throw;  // otherwise another process removed it as a leftover
    }
  }
  throw FileError(target, "is being written by another process: wait for it, or name another folder");
}

// Removes a folder that this process has locked. What cannot be removed stays, with the marker.
void remove_partial(const fs::path& partial) {
  try {
    empty_but_marker(partial);
  } catch (const std::exception&) {
    return;
  }
  std::error_code ignored;
  fs::remove(partial / kMarker, ignored);
  fs::remove(partial, ignored);  // fails if another process has made it again
}

fs::path checked_target(fs::path target, Existing existing) {
  if (!target.has_filename()) target = target.parent_path();  // without a trailing slash
  if (existing == Existing::reject && is_there(target)) throw FileError(target, "already exists");
  require_replaceable(target);
  return target;
}

// Locks a partial folder that a killed process left behind. Returns nothing for other paths and folders in
// use.
std::optional<FileLock> lock_leftover(const fs::path& path) {
  if (!is_partial(path) || !is_real_folder(path) || !is_real_file(path / kMarker)) return std::nullopt;
  try {
    return FileLock::acquire(path / kMarker, How::try_existing);
  } catch (const FileError&) {  // another user's
    return std::nullopt;
  }
}

}  // namespace

std::optional<FileLock> FileLock::acquire(const fs::path& file, How how) {
  const bool waits = how == How::shared || how == How::exclusive;
  const int operation = (how == How::shared ? LOCK_SH : LOCK_EX) | (waits ? 0 : LOCK_NB);
  for (;;) {
    FileLock lock(open_to_lock(file, how == How::try_existing ? 0 : O_CREAT));
    if (lock.fd() < 0 && errno == ENOENT && how == How::try_existing) return std::nullopt;
    if (lock.fd() < 0) fail_by_errno(file, "cannot be opened");
    if (!lock_open(lock.fd(), operation)) {
      if (errno == EWOULDBLOCK) return std::nullopt;
      fail_by_errno(file, "cannot be locked");
    }
    struct stat locked {
    }, named{};
    if (::fstat(lock.fd(), &locked) == 0 && ::lstat(file.c_str(), &named) == 0 &&
        locked.st_dev == named.st_dev && locked.st_ino == named.st_ino)
      return lock;  // otherwise it was renamed or removed before it was locked
  }
}

std::optional<FileLock> FileLock::acquire_folder(const fs::path& folder) {
  FileLock lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.fd() < 0) fail_by_errno(folder, "cannot be opened");
  if (!lock_open(lock.fd(), LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK) return std::nullopt;
  return lock;
}

void write_all(int fd, const fs::path& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_by_errno(file, "cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void require_regular(const fs::path& file) {
  std::error_code fault;
  const fs::file_status status = fs::status(file, fault);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(file, "cannot be written: it is not a regular file");
}

void write_atomically(const fs::path& file, std::string_view bytes) {
  require_regular(file);
  struct stat replaced {};
  const bool replaces = ::stat(file.c_str(), &replaced) == 0;
  const fs::path temporary = partial_of(file);
  const auto lock = FileLock::acquire(temporary, How::exclusive);
  try {
    write_whole(lock->fd(), temporary, bytes);
    if (::fsync(lock->fd()) != 0) fail_by_errno(temporary, "cannot be flushed to disk");
    if (replaces && ::fchmod(lock->fd(), replaced.st_mode & ACCESSPERMS) != 0)
      fail_by_errno(file, "cannot set its permissions");
    rename_file(temporary, file);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  sync_folder(parent_of(file));
}

bool is_partial(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') && name.ends_with(".partial");
}

void remove_leftovers(const fs::path& folder) {
  std::error_code none;
  std::vector<fs::path> entries;  // recovery adds entries to the folder
  for (const auto& entry : fs::directory_iterator(folder, none)) entries.push_back(entry.path());
  for (const fs::path& entry : entries)
    if (const auto lock = lock_leftover(entry)) has_marker(entry) ? recover(entry) : remove_partial(entry);
}

AtomicFolder::AtomicFolder(fs::path target, Existing existing)
    : target_(checked_target(std::move(target), existing)),
      path_(partial_of(target_)),
      existing_(existing),
      lock_(begin_partial(path_, target_)) {}

AtomicFolder::~AtomicFolder() {
  if (!committed_) remove_partial(path_);
}

void AtomicFolder::commit() {
  if (existing_ == Existing::reject && is_there(target_)) throw FileError(target_, "already exists");
  sync_folder(path_, true);  // before the marker is written: it makes the folder count as complete
  write_whole(lock_.fd(), path_ / kMarker, kMarkerText);
  if (::fsync(lock_.fd()) != 0) fail_by_errno(path_ / kMarker, "cannot be flushed to disk");
  committed_ = true;  // a complete folder is kept if it cannot be renamed
  put_in_place(path_, target_);
}

bool has_marker(const fs::path& folder) {
  return is_real_folder(folder) && is_real_file(folder / kMarker) &&
         read_text(folder / kMarker).starts_with(kMarkerStart);
}

void require_replaceable(const fs::path& folder) {
  const fs::file_status status = status_of(folder);
  if (!fs::exists(status)) return;
  if (fs::is_symlink(status)) throw FileError(folder, "is a symbolic link, expected a folder or a new name");
  if (!fs::is_directory(status)) throw FileError(folder, "is a file, expected a folder or a new name");
  if (has_marker(folder) || fs::is_empty(folder)) return;
  throw FileError(folder, "was not created by gaitslam, which would replace it: {}", kWhatToDo);
}

void claim_outputs(const fs::path& folder, const std::vector<std::string>& names) {
  if (has_marker(folder)) return;
  for (const std::string& name : names)
    if (is_there(folder / name))
      throw FileError(folder / name, "was not created by gaitslam, which would replace it: {}", kWhatToDo);
  fs::create_directories(folder);
  write_atomically(folder / kMarker, kMarkerText);
}

std::optional<fs::path> set_aside(const fs::path& folder, const std::vector<std::string>& names) {
  if (std::ranges::none_of(names, [&](const std::string& name) { return is_there(folder / name); }))
    return std::nullopt;
  const fs::path earlier = earlier_without(folder, names);
  for (const std::string& name : names)
    if (is_there(folder / name)) rename_file(folder / name, earlier / name);
  sync_folder(earlier);
  sync_folder(folder);
  return earlier;
}

void write_output(const fs::path& file, std::string_view bytes) {
  if (is_real_file(file) && read_text(file) == bytes) return;
  set_aside(parent_of(file), {file.filename()});
  write_atomically(file, bytes);
}

}  // namespace sim::files
