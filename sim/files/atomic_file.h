// Files and folders that appear complete or not at all, even if the process is killed; inter-process locks.
#pragma once

#include <set>

#include "sim/files/text.h"

namespace sim::files {

/// A locked file (flock). The end of its life or of the process releases it; children do not inherit it.
class FileLock {
 public:
  /// shared, exclusive: make the file if it is missing and wait for the lock. try_exclusive does not wait;
  /// try_existing does not make the file either.
  enum class How { shared, exclusive, try_exclusive, try_existing };

  /// Locks the file that has this name now, also one that this process cannot write; does not follow a
  /// symbolic link. Returns nothing if `how` gives up. Throws FileError.
  static std::optional<FileLock> acquire(const std::filesystem::path& file, How how);
  /// Locks a folder without a file in it; nothing if another process has the lock. Always succeeds if the
  /// file system cannot lock folders. Throws FileError.
  static std::optional<FileLock> acquire_folder(const std::filesystem::path& folder);

  int fd() const { return file_.fd; }

 private:
  explicit FileLock(int fd) : file_(fd) {}
  Descriptor file_;
};

/// Writes these bytes to an open file, at its position. file: its name, for FileError.
void write_all(int fd, const std::filesystem::path& file, std::string_view bytes);

/// Throws a FileError if this name, or the target of a link of this name, exists and is not a regular file.
void require_regular(const std::filesystem::path& file);

/// Writes `bytes` to a temporary sibling (.<file>.partial), forces it to the disk and renames it to `file`;
/// keeps an existing file's permissions. Throws FileError, as require_regular() does; `file` is then
/// unchanged.
void write_atomically(const std::filesystem::path& file, std::string_view bytes);

/// Returns whether a path is the name of a temporary sibling made here (".X.partial").
bool is_partial(const std::filesystem::path& path);

/// Removes the partial folders in `folder` that killed processes left, except those of other users.
void remove_leftovers(const std::filesystem::path& folder);

/// Treatment of an existing folder of the same name. replace: if the program made everything in it.
enum class Existing { reject, replace };

/// A folder that is filled as a hidden sibling, .<target>.partial, and gets its name by commit(), with a
/// marker that lists all files in it. Its marker is locked while this object lives, so
/// that a second process is rejected and a leftover is recognized. Without commit() the folder is removed.
class AtomicFolder {
 public:
  /// Makes the temporary folder and the parents it needs. Throws FileError if that fails, if another process
  /// makes the same target, or if `target` exists and is to be rejected or has anything of others in it.
  explicit AtomicFolder(std::filesystem::path target, Existing existing = Existing::reject);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  ///< where to write

  /// Forces everything to the disk and renames the folder to `target` in one step. Throws FileError. If
  /// unlisted files appeared in the replaced folder, it is kept under the name in the FileError.
  void commit();

 private:
  void replace() const;

  std::filesystem::path target_, path_;
  Existing existing_;
  FileLock lock_;
  bool committed_ = false;
};

// The manifest of a folder: the program replaces and removes only what its marker lists.

/// The marker, a text file: the paths of what the program made in the folder; those of folders end in "/".
inline constexpr const char* kMarker = ".gaitslam";

using OutputNames = std::set<std::string, std::less<>>;

/// Returns what the folder's marker lists, if it has one. Symbolic links are neither folders nor markers.
std::optional<OutputNames> listed_in(const std::filesystem::path& folder);
bool has_marker(const std::filesystem::path& folder);

/// Returns the first entry of the folder, by name, that is neither listed nor the leftover of a killed
/// process. A listed folder's own marker decides about it. Symbolic links are never listed.
std::optional<std::filesystem::path> unlisted_in(const std::filesystem::path& folder);

/// Throws a FileError that names the first unlisted entry of the folder, or the folder if it is a file or a
/// symbolic link. A folder that does not exist passes.
void require_replaceable(const std::filesystem::path& folder);

/// Lists these names in the folder's marker; makes both if they are missing. Throws a FileError that names
/// the first of them that exists but was not listed before; then nothing is changed.
void list_outputs(const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Removes those of these names from the marker that do not exist, and the marker if it then lists nothing.
void unlist_missing(const std::filesystem::path& folder, const std::vector<std::string>& names);

/// Lists these names, unchecked, in the folder's marker, if any; for folders with markers of their own.
void add_to_marker(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace sim::files
