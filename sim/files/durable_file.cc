#include "sim/files/durable_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <utility>

namespace sim::files {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw FileError(file, what + ": " + std::strerror(errno));
}

// An open file descriptor, closed when it goes.
class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags)
      : file_(file), fd_(::open(file.c_str(), flags | O_CLOEXEC, 0666)) {
    if (fd_ < 0) fail(file_, "cannot be opened");
  }
  ~Descriptor() { ::close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void write(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail(file_, "cannot be written");
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void sync() const {
    if (::fsync(fd_) != 0) fail(file_, "cannot be forced to the disk");
  }
  void sync_file_system() const {
    if (::syncfs(fd_) != 0) fail(file_, "cannot be forced to the disk");
  }

 private:
  fs::path file_;
  int fd_;
};

fs::path parent_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

void sync_folder(const fs::path& folder) { Descriptor(folder, O_RDONLY | O_DIRECTORY).sync(); }

std::string host() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

// A hidden name with the machine and the process that writes the file.
std::string temporary_prefix(const fs::path& target) {
  return fmt::format(".{}.partial-{}-", target.filename().string(), host());
}

fs::path temporary_of(const fs::path& target) {
  return parent_of(target) / (temporary_prefix(target) + std::to_string(::getpid()));
}

// Whether `name` is the temporary of a process that has ended.
bool is_orphan(const std::string& name, const std::string& prefix) {
  if (!name.starts_with(prefix)) return false;
  pid_t pid = 0;
  const auto [end, error] = std::from_chars(name.data() + prefix.size(), name.data() + name.size(), pid);
  return error == std::errc{} && end == name.data() + name.size() && ::kill(pid, 0) != 0 && errno == ESRCH;
}

void remove_orphans(const fs::path& target) {
  const std::string prefix = temporary_prefix(target);
  std::error_code ignored;  // Another process may be removing them, too.
  for (const auto& entry : fs::directory_iterator(parent_of(target), ignored))
    if (is_orphan(entry.path().filename().string(), prefix)) fs::remove_all(entry.path(), ignored);
}

int rename_with(const fs::path& from, const fs::path& to, unsigned flags) {
  return ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags);
}

// Exchanges the two in one step; where the file system cannot, the old one is renamed first.
void replace_folder(const fs::path& temporary, const fs::path& target) {
  if (rename_with(temporary, target, RENAME_EXCHANGE) == 0) {
    fs::remove_all(temporary);
    return;
  }
  const fs::path aside = temporary.string() + ".old";
  if (::rename(target.c_str(), aside.c_str()) != 0 && errno != ENOENT) fail(target, "cannot be replaced");
  if (::rename(temporary.c_str(), target.c_str()) != 0) fail(target, "cannot be made");
  fs::remove_all(aside);
}

}  // namespace

void write_durably(const fs::path& file, std::string_view bytes) {
  const fs::path temporary = temporary_of(file);
  try {
    {
      const Descriptor out(temporary, O_WRONLY | O_CREAT | O_TRUNC);
      out.write(bytes);
      out.sync();
    }
    if (::rename(temporary.c_str(), file.c_str()) != 0) fail(file, "cannot be written");
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  sync_folder(parent_of(file));
}

DurableFolder::DurableFolder(fs::path target, Existing existing)
    : target_(target.has_filename() ? std::move(target) : target.parent_path()),
      temporary_(temporary_of(target_)),
      existing_(existing) {
  if (existing_ == Existing::refuse && fs::exists(fs::symlink_status(target_)))
    throw FileError(target_, "exists already");
  std::error_code error;
  fs::create_directories(parent_of(target_), error);
  if (error) throw FileError(parent_of(target_), "cannot be made: " + error.message());
  remove_orphans(target_);
  fs::remove_all(temporary_, error);
  if (!fs::create_directory(temporary_, error))
    throw FileError(target_, "cannot be made: " + error.message());
}

DurableFolder::~DurableFolder() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(temporary_, ignored);
}

void DurableFolder::commit() {
  Descriptor(temporary_, O_RDONLY | O_DIRECTORY).sync_file_system();
  if (rename_with(temporary_, target_, RENAME_NOREPLACE) != 0) {
    if (errno == EINVAL && !fs::exists(fs::symlink_status(target_)))
      fs::rename(temporary_, target_);
    else if (existing_ == Existing::refuse)
      fail(target_, "cannot be made");
    else
      replace_folder(temporary_, target_);
  }
  committed_ = true;
  sync_folder(parent_of(target_));
}

}  // namespace sim::files
