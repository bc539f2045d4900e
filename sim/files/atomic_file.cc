#include "sim/files/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using How = FileLock::How;

constexpr int kAttempts = 150;
constexpr useconds_t kPauseUs = 20'000;  // 3 s in all: enough for a killed process to end

// False, with errno, if it cannot be locked.
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

// Replaces the content of a file that was opened and not written yet.
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

// Forces a folder, or its whole file system, to the disk.
void sync_folder(const fs::path& folder, bool whole_file_system = false) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.fd < 0) fail_by_errno(folder, "cannot be opened");
  if ((whole_file_system ? ::syncfs(opened.fd) : ::fsync(opened.fd)) != 0)
    fail_by_errno(folder, "cannot be forced to the disk");
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

fs::path free_name(const fs::path& target) {
  fs::path name = target.string() + ".replaced";
  for (int i = 2; is_there(name); ++i) name = fmt::format("{}.replaced-{}", target.string(), i);
  return name;
}

// Removes what is in the folder except its marker; does not follow links.
void empty_but_marker(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path() == folder / kMarker) continue;
    std::error_code fault;
    fs::remove_all(entry.path(), fault);
    if (fault) throw FileError(entry.path(), "cannot be removed: " + fault.message());
  }
}

// Makes and locks the folder; empties it if a killed process left it.
FileLock begin_partial(const fs::path& partial, const fs::path& target) {
  for (int attempt = 0; attempt <= kAttempts; ++attempt, ::usleep(kPauseUs)) {
    std::error_code error;
    fs::create_directories(parent_of(target), error);
    if (error) fail_by_errno(parent_of(target), "cannot be made", error.value());
    fs::create_directory(partial, error);
    if (error) fail_by_errno(target, "cannot be made", error.value());
    if (!is_real_folder(partial)) throw FileError(target, "cannot be made: " + partial.string() + " exists");
    if (!is_there(partial / kMarker) && !fs::is_empty(partial))
      throw FileError(partial, "was not made by gaitslam, which needs this name: move it away");
    try {
      if (auto lock = FileLock::acquire(partial / kMarker, How::try_exclusive)) {
        if (has_marker(partial)) require_replaceable(partial);  // an old result, exchanged but not removed
        empty_but_marker(partial);
        write_whole(lock->fd(), partial, "");
        return std::move(*lock);
      }
    } catch (const FileError&) {
      if (is_there(partial)) throw;  // else another process has removed it as a leftover
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
  if (existing == Existing::reject && is_there(target)) throw FileError(target, "exists already");
  require_replaceable(target);
  return target;
}

constexpr std::string_view kHeader =
    "# Made by gaitslam, which replaces and removes only what is listed here.\n";
constexpr const char* kWhatToDo = "move it away, or name another folder";

std::string marker_text(const OutputNames& names) {
  std::string text(kHeader);
  for (const std::string& name : names) text += name + "\n";
  return text;
}

// The path within the folder, in the form of the marker.
std::string listed_as(const fs::path& path, const fs::path& folder) {
  return path.lexically_relative(folder).generic_string() + (is_real_folder(path) ? "/" : "");
}

// The text of a marker that lists everything in the folder.
std::string marker_of_all(const fs::path& folder) {
  OutputNames names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path() != folder / kMarker) names.insert(listed_as(entry.path(), folder));
  return marker_text(names);
}

// Locks a partial folder that a killed process left. Returns nothing for other paths and folders in use.
std::optional<FileLock> lock_leftover(const fs::path& path) {
  if (!is_partial(path) || !is_real_folder(path) || !is_real_file(path / kMarker)) return std::nullopt;
  try {
    return FileLock::acquire(path / kMarker, How::try_existing);
  } catch (const FileError&) {  // of another user
    return std::nullopt;
  }
}

std::set<fs::path> entries_of(const fs::path& folder) { return {fs::directory_iterator(folder), {}}; }

// True for the marker, a listed file, or the temporary sibling of such a file.
bool is_listed_file(const fs::path& path, const fs::path& folder, const OutputNames& made) {
  if (!is_real_file(path)) return false;
  const std::string name = path.filename().string();
  const fs::path whole =
      is_partial(path) ? path.parent_path() / name.substr(1, name.rfind(".partial") - 1) : path;
  return whole == folder / kMarker || made.contains(listed_as(whole, folder));
}

std::optional<fs::path> unlisted_below(const fs::path& below, const fs::path& folder,
                                       const OutputNames& made) {
  for (const fs::path& path : entries_of(below)) {
    if (is_listed_file(path, folder, made) || lock_leftover(path)) continue;
    if (!is_real_folder(path) || !made.contains(listed_as(path, folder))) return path;
    if (auto found = has_marker(path) ? unlisted_in(path) : unlisted_below(path, folder, made)) return found;
  }
  return std::nullopt;
}

// The path of a listed name, without the slash of a folder: that would follow a link.
fs::path path_of(const fs::path& folder, std::string_view name) {
  return folder / name.substr(0, name.size() - (name.ends_with('/') ? 1 : 0));
}

bool exists_as_listed(const fs::path& folder, const std::string& name) {
  const fs::path path = path_of(folder, name);
  return name.ends_with('/') ? is_real_folder(path) : is_real_file(path);
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
      return lock;  // else it was renamed or removed before the lock
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
    if (::fsync(lock->fd()) != 0) fail_by_errno(temporary, "cannot be forced to the disk");
    if (replaces && ::fchmod(lock->fd(), replaced.st_mode & ACCESSPERMS) != 0)
      fail_by_errno(file, "cannot be given its permissions");
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
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const auto lock = lock_leftover(entry.path());
    if (lock && (!has_marker(entry.path()) || !unlisted_in(entry.path()))) remove_partial(entry.path());
  }
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
  write_whole(lock_.fd(), path_ / kMarker, marker_of_all(path_));
  sync_folder(path_, true);
  if (::rename(path_.c_str(), target_.c_str()) != 0) {
    if (existing_ == Existing::reject || (errno != ENOTEMPTY && errno != EEXIST))
      fail_by_errno(target_, "cannot be made");
    replace();
  }
  committed_ = true;
  sync_folder(parent_of(target_));
}

// Exchanges the two in one step, or renames the old one first if the file system cannot. The old marker is
// locked until the folder is gone, so that no process takes it for a leftover.
void AtomicFolder::replace() const {
  const auto old = FileLock::acquire(target_ / kMarker, How::try_existing);
  if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) != 0) {
    const fs::path aside = free_name(target_);
    rename_file(target_, aside);
    rename_file(path_, target_);
    rename_file(aside, path_);
  }
  if (!unlisted_in(path_)) return remove_partial(path_);  // the old folder, which has this name now
  const fs::path kept = free_name(target_);
  rename_file(path_, kept);
  throw FileError(target_,
                  fmt::format("was replaced; the one before is kept in {}, because files that were not "
                              "made by gaitslam appeared in it meanwhile",
                              kept.string()));
}

std::optional<OutputNames> listed_in(const fs::path& folder) {
  if (!is_real_folder(folder) || !is_real_file(folder / kMarker)) return std::nullopt;
  const std::string text = read_text(folder / kMarker);
  if (!text.starts_with(kHeader)) return std::nullopt;
  OutputNames names;
  std::istringstream lines(text.substr(kHeader.size()));
  for (std::string line; std::getline(lines, line);) names.insert(line);
  return names;
}

bool has_marker(const fs::path& folder) { return listed_in(folder).has_value(); }

std::optional<fs::path> unlisted_in(const fs::path& folder) {
  if (const auto made = listed_in(folder)) return unlisted_below(folder, folder, *made);
  const std::set<fs::path> entries = entries_of(folder);
  return entries.empty() ? std::nullopt : std::optional(*entries.begin());
}

void require_replaceable(const fs::path& folder) {
  const fs::file_status status = status_of(folder);
  if (!fs::exists(status)) return;
  if (fs::is_symlink(status)) throw FileError(folder, "is a symbolic link, expected a folder or a new name");
  if (!fs::is_directory(status)) throw FileError(folder, "is a file, expected a folder or a new name");
  const auto unlisted = unlisted_in(folder);
  if (!unlisted) return;
  if (has_marker(folder))
    throw FileError(*unlisted, fmt::format("was not made by gaitslam, and {} would be replaced: {}",
                                           folder.string(), kWhatToDo));
  throw FileError(folder,
                  fmt::format("would be replaced with {} in it, and has no list of what gaitslam made "
                              "there (older versions wrote none): {}",
                              unlisted->filename().string(), kWhatToDo));
}

void list_outputs(const fs::path& folder, const std::vector<std::string>& names) {
  OutputNames made = listed_in(folder).value_or(OutputNames{});
  for (const std::string& name : names) {
    const fs::path path = path_of(folder, name);
    if (fs::exists(status_of(path)) && !(made.contains(name) && exists_as_listed(folder, name)))
      throw FileError(
          path,
          fmt::format("was not made by this version of gaitslam, which would replace it: {}", kWhatToDo));
  }
  made.insert(names.begin(), names.end());
  fs::create_directories(folder);
  write_atomically(folder / kMarker, marker_text(made));
}

void unlist_missing(const fs::path& folder, const std::vector<std::string>& names) {
  std::optional<OutputNames> made = listed_in(folder);
  if (!made) return;
  const std::size_t before = made->size();
  for (const std::string& name : names)
    if (!exists_as_listed(folder, name)) made->erase(name);
  if (made->empty())
    fs::remove(folder / kMarker);
  else if (made->size() < before)
    write_atomically(folder / kMarker, marker_text(*made));
}

void add_to_marker(const fs::path& folder, const std::vector<std::string>& names) {
  std::optional<OutputNames> made = listed_in(folder);
  if (!made) return;
  made->insert(names.begin(), names.end());
  write_atomically(folder / kMarker, marker_text(*made));
}

}  // namespace sim::files
