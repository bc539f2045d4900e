#include "sim/files/durable_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>

#include "sim/files/owned_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using Mode = FileLock::Mode;
using IfHeld = FileLock::IfHeld;
using IfAbsent = FileLock::IfAbsent;

constexpr int kAttempts = 150;
constexpr useconds_t kPauseUs = 20'000;  // 3 s in all: a process that was killed, or looks for leftovers, is done by then

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw FileError(file, what + ": " + std::strerror(errno));
}

// Replaces what is in an open file.
void write_whole(int fd, const fs::path& file, std::string_view bytes) {
  if (::ftruncate(fd, 0) != 0) fail(file, "cannot be written");
  for (off_t at = 0; !bytes.empty();) {
    const ssize_t n = ::pwrite(fd, bytes.data(), bytes.size(), at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file, "cannot be written");
    at += n;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

fs::path parent_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

fs::path partial_of(const fs::path& target) {
  return parent_of(target) / fmt::format(".{}.partial", target.filename().string());
}

// Forces a folder to the disk; with everything on its file system where that is asked for.
void sync_folder(const fs::path& folder, bool whole_file_system = false) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) fail(folder, "cannot be opened");
  const int result = whole_file_system ? ::syncfs(fd) : ::fsync(fd);
  ::close(fd);
  if (result != 0) fail(folder, "cannot be forced to the disk");
}

int rename_with(const fs::path& from, const fs::path& to, unsigned flags) {
  return ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags);
}

std::optional<mode_t> permissions_of(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return std::nullopt;
  return found.st_mode & ACCESSPERMS;
}

void set_permissions(int fd, const fs::path& file, mode_t permissions) {
  if (::fchmod(fd, permissions) != 0) fail(file, "cannot be given its permissions");
}

bool is_there(const fs::path& path) {
  std::error_code fault;
  return fs::exists(fs::symlink_status(path, fault));
}

// The folder from which a partial one is begun: new, empty, or with the marker of one that was left.
void make_partial(const fs::path& partial, const fs::path& target) {
  std::error_code error;
  fs::create_directories(parent_of(target), error);
  if (error) throw FileError(parent_of(target), "cannot be made: " + error.message());
  fs::create_directory(partial, error);
  if (error || !fs::is_directory(fs::symlink_status(partial)))
    throw FileError(target, "cannot be made: " + (error ? error.message() : partial.string() + " is there"));
  if (!is_there(partial / kMarker) && !fs::is_empty(partial))
    throw FileError(partial, "was not made by gaitslam, which needs this name: move it away");
}

// Throws where an old result was left in place of the partial one and others put files into it.
void clear_partial(const fs::path& partial) {
  if (has_marker(partial)) require_own(partial);
  empty_but_marker(partial);
}

// Nothing where another process has the lock, or removes the folder as a leftover.
std::optional<FileLock> try_lock(const fs::path& partial) {
  try {
    return FileLock::take(partial / kMarker, Mode::exclusive, IfHeld::give_up);
  } catch (const FileError&) {
    if (is_there(partial)) throw;
    return std::nullopt;
  }
}

FileLock begin_partial(const fs::path& partial, const fs::path& target) {
  for (int attempt = 0;; ++attempt) {
    make_partial(partial, target);
    if (auto lock = try_lock(partial)) {
      clear_partial(partial);
      if (::ftruncate(lock->fd(), 0) != 0) fail(partial, "cannot be written");
      return std::move(*lock);
    }
    if (attempt == kAttempts)
      throw FileError(target, "is being written by another process: wait for it, or name another folder");
    ::usleep(kPauseUs);
  }
}

// Removes a folder whose marker is locked by this process. What cannot be removed stays, with the marker by
// which it is known.
void remove_partial(const fs::path& partial) {
  try {
    empty_but_marker(partial);
  } catch (const std::exception&) {
    return;
  }
  std::error_code ignored;
  fs::remove(partial / kMarker, ignored);
  fs::remove(partial, ignored);  // not where another process has begun anew
}

fs::path without_slash(const fs::path& target) {
  return target.has_filename() ? target : target.parent_path();
}

fs::path checked_target(fs::path target, Existing existing) {
  target = without_slash(target);
  if (existing == Existing::refuse && is_there(target)) throw FileError(target, "exists already");
  require_own(target);
  return target;
}

// A name beside the folder that nothing has.
fs::path free_name(const fs::path& target, const std::string& ending) {
  for (int i = 1;; ++i) {
    const fs::path name =
        fmt::format("{}.{}{}", target.string(), ending, i == 1 ? "" : fmt::format("-{}", i));
    if (!is_there(name)) return name;
  }
}

}  // namespace

void require_regular(const fs::path& file) {
  std::error_code fault;
  const fs::file_status status = fs::status(file, fault);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(file, "cannot be written: it is no regular file");
}

void write_durably(const fs::path& file, std::string_view bytes) {
  require_regular(file);
  const auto replaced = permissions_of(file);
  const fs::path temporary = partial_of(file);
  const auto lock = FileLock::take(temporary, Mode::exclusive, IfHeld::wait);
  try {
    // Ours to read and write until it has its name, so that a next process can use what is left of this one.
    if (replaced) set_permissions(lock->fd(), temporary, *replaced | S_IRUSR | S_IWUSR);
    write_whole(lock->fd(), temporary, bytes);
    if (::fsync(lock->fd()) != 0) fail(temporary, "cannot be forced to the disk");
    if (::rename(temporary.c_str(), file.c_str()) != 0) fail(file, "cannot be written");
    if (replaced) set_permissions(lock->fd(), file, *replaced);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  sync_folder(parent_of(file));
}

PartialFolder::PartialFolder(const fs::path& target)
    : path_(partial_of(target)), lock_(begin_partial(path_, target)) {}

PartialFolder::~PartialFolder() {
  if (!released_) remove_partial(path_);
}

void remove_leftovers(const fs::path& folder) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const fs::path partial = entry.path();
    if (!is_partial(partial) || !fs::is_directory(entry.symlink_status(none))) continue;
    try {
      const auto lock =
          FileLock::take(partial / kMarker, Mode::exclusive, IfHeld::give_up, IfAbsent::give_up);
      if (lock && (!has_marker(partial) || !foreign_in(partial))) remove_partial(partial);
    } catch (const std::runtime_error&) {  // of another user
    }
  }
}

DurableFolder::DurableFolder(fs::path target, Existing existing)
    : target_(checked_target(std::move(target), existing)), existing_(existing), partial_(target_) {}

void DurableFolder::commit() {
  write_whole(partial_.lock().fd(), path() / kMarker, marker_of_all(path()));
  sync_folder(path(), true);
  if (rename_with(path(), target_, RENAME_NOREPLACE) != 0) {
    const int fault = errno;
    if (fault == EINVAL && !is_there(target_))
      fs::rename(path(), target_);
    else if (existing_ == Existing::refuse)
      errno = fault, fail(target_, "cannot be made");
    else
      replace();
  }
  partial_.release();
  sync_folder(parent_of(target_));
}

// Exchanges the two in one step; where the file system cannot, the old one is renamed first. The old one's
// marker is locked until it is gone, so that nobody takes it for a partial folder that was left.
void DurableFolder::replace() {
  std::error_code fault;
  if (fs::is_empty(target_, fault) && ::rename(path().c_str(), target_.c_str()) == 0) return;
  const auto old = FileLock::take(target_ / kMarker, Mode::exclusive, IfHeld::wait, IfAbsent::give_up);
  if (rename_with(path(), target_, RENAME_EXCHANGE) == 0) return discard_old();
  const fs::path aside = free_name(target_, "replaced");
  if (::rename(target_.c_str(), aside.c_str()) != 0) fail(target_, "cannot be replaced");
  if (::rename(path().c_str(), target_.c_str()) != 0) fail(target_, "cannot be made");
  if (::rename(aside.c_str(), path().c_str()) != 0) fail(aside, "cannot be removed");
  discard_old();
}

// The old folder, which now has the name of the partial one.
void DurableFolder::discard_old() const {
  if (!foreign_in(path())) return remove_partial(path());
  const fs::path kept = free_name(target_, "replaced");
  fs::rename(path(), kept);
  throw FileError(target_,
                  fmt::format("was replaced; the one before is kept in {}, because files that were not "
                              "made by gaitslam appeared in it meanwhile",
                              kept.string()));
}

}  // namespace sim::files
