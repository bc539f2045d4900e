#include "sim/recording/cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/recording/manifest.h"

namespace sim::recording {
namespace {

using files::FileError;
using files::FileLock;
using nlohmann::ordered_json;

std::optional<std::string> environment(const char* name) {
  const char* const value = std::getenv(name);
  return value && *value ? std::optional<std::string>(value) : std::nullopt;
}

// Leaves out timing.*, which differ between two recordings of the same walk. Another process may be removing
// the folder.
std::uintmax_t size_of(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code gone;
  for (fs::recursive_directory_iterator at(folder, gone), end; !gone && at != end; at.increment(gone))
    if (std::error_code no; at->is_regular_file(no) && at->path().stem() != "timing")
      bytes += at->file_size(no);
  return bytes;
}

void require_writable(const fs::path& folder, const char* but) {
  if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0 && errno != ENOENT)
    throw FileError(folder, "{}{}; set GAITSLAM_CACHE to another folder", but, std::strerror(errno));
}

}  // namespace

CachePlace cache_place() {
  CachePlace place;
  if (const auto own = environment("GAITSLAM_CACHE"))
    place.folder = *own;
  else if (const auto xdg = environment("XDG_CACHE_HOME"))
    place.folder = fs::path(*xdg) / "gaitslam";
  else if (const auto home = environment("HOME"))
    place.folder = fs::path(*home) / ".cache/gaitslam";
  else
    throw std::invalid_argument(
        "no folder for recordings: none of GAITSLAM_CACHE, XDG_CACHE_HOME and HOME is set");
  place.folder = fs::absolute(place.folder);
  if (const auto text = environment("GAITSLAM_CACHE_GB")) {
    const auto gigabytes = files::parse_finite(*text);
    if (!gigabytes || *gigabytes < 0 || *gigabytes > 1e9)
      throw std::invalid_argument(
          fmt::format("GAITSLAM_CACHE_GB is '{}', expected a number of gigabytes", *text));
    place.most_bytes = std::uintmax_t(*gigabytes * 1e9);
  }
  return place;
}

fs::path Cache::lock_file(const std::string& key) const { return place_.folder / (key + ".lock"); }

bool Cache::is_whole(const std::string& key, const Say& say) const {
  const fs::path entry = place_.folder / key;
  if (!fs::exists(entry)) return false;
  try {
    const Manifest manifest(entry / "result/recording");
    manifest.check_all();
    const files::Json stored = files::read_json(entry / "entry.json");
    if (stored.at("recording").text() == manifest.hash()) return true;
    say(fmt::format("{}: contains a recording other than the stored one", entry.string()));
  } catch (const FileError& damage) {
    say(damage.what());
  }
  return false;
}

void Cache::make_entry(const std::string& key, const Make& make) const {
  files::AtomicFolder folder(place_.folder / key);
  const fs::path result = folder.path() / "result";
  make(result);
  const ordered_json entry{{"format_version", 6},
                           {"recording", Manifest(result / "recording").hash()},
                           {"bytes", size_of(folder.path())}};
  files::write_text(folder.path() / "entry.json", files::json_text(entry, 2) + "\n");
  folder.commit();
}

std::optional<CachedRecording> Cache::find(const std::string& key, const Say& say) const {
  if (!fs::exists(place_.folder / key)) return std::nullopt;
  std::optional<FileLock> shared = FileLock::acquire(lock_file(key), FileLock::How::shared);
  if (!is_whole(key, say)) return std::nullopt;
  ::futimens(shared->fd(), nullptr);
  return CachedRecording{place_.folder / key / "result", false, std::move(*shared)};
}

CachedRecording Cache::get(const std::string& key, const Make& make, const Say& say) const {
  constexpr int kAttempts = 5;  // other processes may keep removing it
  const Say nothing = [](const std::string&) {};
  std::error_code fault;
  fs::create_directories(place_.folder, fault);
  if (fault) files::fail_by_errno(place_.folder, "cannot be created", fault.value());
  bool made = false;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (auto found = find(key, made ? say : nothing)) {
      found->made = made;
      if (made) clean(place_.most_bytes);
      return std::move(*found);
    }
    require_writable(place_.folder, "lacks an intact copy of this recording, and cannot store one: ");
    const std::optional<FileLock> alone = FileLock::acquire(lock_file(key), FileLock::How::exclusive);
    if (is_whole(key, say)) continue;  // recorded by another process in the meantime
    make_entry(key, make);
    made = true;
  }
  throw FileError(place_.folder / key, "was recorded, but then removed or damaged by another process");
}

Cache::Entry Cache::read_entry(const std::string& key) const {
  struct stat status {};
  ::stat(lock_file(key).c_str(), &status);
  const std::int64_t last_used = status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec;
  try {
    return {key, files::read_json(place_.folder / key / "entry.json").at("bytes").whole(), last_used};
  } catch (const FileError&) {  // damaged
    return {key, size_of(place_.folder / key), last_used};
  }
}

std::vector<Cache::Entry> Cache::list() const {
  std::vector<Entry> entries;
  std::error_code none;
  for (const auto& folder : fs::directory_iterator(place_.folder, none)) try {
      if (const std::string key = folder.path().filename();
          key.size() == 32 && key.find_first_not_of("0123456789abcdef") == key.npos &&
          files::has_marker(folder.path()))
        entries.push_back(read_entry(key));
    } catch (const FileError&) {
      if (fs::exists(folder.path())) throw;  // otherwise another process has removed it
    }
  std::ranges::sort(entries, {}, [](const Entry& entry) { return std::tie(entry.last_used_ns, entry.key); });
  return entries;
}

bool Cache::remove_if_unused(const std::string& key) const {
  const auto alone = FileLock::acquire(lock_file(key), FileLock::How::try_exclusive);
  if (!alone) return false;
  // It is renamed before it is removed, so that no entry is ever incomplete. If this process is killed, the
  // next one removes the leftover. The lock file is removed too: a lock on a removed file is void.
  const fs::path aside = place_.folder / fmt::format(".{}.old", key);
  std::error_code fault;
  fs::rename(place_.folder / key, aside, fault);
  if (fault) return false;
  files::remove_marked(aside);
  fs::remove(lock_file(key), fault);
  return true;
}

Cache::Cleaned Cache::clean(std::uintmax_t most_bytes) const {
  Cleaned cleaned;
  require_writable(place_.folder, "cannot be written: ");
  files::remove_leftovers(place_.folder);
  const std::vector<Entry> entries = list();
  std::uintmax_t total = 0;
  for (const Entry& entry : entries) total += entry.bytes;
  for (const Entry& entry : entries) {
    if (total <= most_bytes) break;
    if (!remove_if_unused(entry.key)) {
      ++cleaned.kept;
      continue;
    }
    ++cleaned.removed;
    cleaned.bytes += entry.bytes;
    total -= entry.bytes;
  }
  return cleaned;
}

}  // namespace sim::recording
