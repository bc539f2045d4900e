// Files and folders that appear complete or not at all, even if the process is killed; inter-process locks.
#pragma once

#include "sim/files/text.h"

namespace sim::files {

/// A locked file (flock). The lock is released when this object or the process ends; child processes do not
/// inherit it.
class FileLock {
 public:
  /// shared, exclusive: create the file if it is missing, and wait for the lock. try_exclusive does not wait;
  /// try_existing does not create the file either.
  enum class How { shared, exclusive, try_exclusive, try_existing };

  /// Locks the file that has this name now, even one that this process cannot write, but not through a
  /// symbolic link. Returns nothing if `how` gives up. Throws FileError.
  static std::optional<FileLock> acquire(const fs::path& file, How how);
  /// Locks a folder itself, not a file in it. Returns nothing if another process holds the lock. Succeeds if
  /// the file system cannot lock folders. Throws FileError.
  static std::optional<FileLock> acquire_folder(const fs::path& folder);

  int fd() const { return file_.fd; }

 private:
  explicit FileLock(int fd) : file_(fd) {}
  Descriptor file_;
};

/// Writes these bytes to an open file, at its position. file: its name, for FileError.
void write_all(int fd, const fs::path& file, std::string_view bytes);

/// Throws a FileError if this name, or the target of a link of this name, exists and is not a regular file.
void require_regular(const fs::path& file);

/// Writes `bytes` to a temporary sibling (.<file>.partial), flushes it to disk and renames it to `file`.
/// Keeps an existing file's permissions. Throws FileError, as require_regular() does; `file` is then
/// unchanged.
void write_atomically(const fs::path& file, std::string_view bytes);

/// Returns whether a path is the name of a temporary sibling created here (".X.partial").
bool is_partial(const fs::path& path);

// The marker of a folder that the program created. When such a folder, or a file of the program in it, is
// replaced, the old one is moved aside: nothing that a user added is ever removed.

/// The marker, a text file. It stays empty until the folder is complete.
inline constexpr const char* kMarker = ".gaitslam";

/// Returns whether the folder is complete and was created by the program. Symbolic links count as neither
/// folders
/// markers.
bool has_marker(const fs::path& folder);

/// Throws a FileError unless the folder is missing, empty, or has a marker. Symbolic links and files are
/// rejected.
void require_replaceable(const fs::path& folder);

/// Creates the folder if it is missing, and its marker. Throws FileError if it has no marker and contains one
/// of these names; then nothing is changed.
void claim_outputs(const fs::path& folder, const std::vector<std::string>& names);

/// Moves those of these names that exist in the folder to its first folder earlier-<n> that contains none of
/// them. Returns that folder, or nothing if none of the names exists. Throws FileError.
std::optional<fs::path> set_aside(const fs::path& folder, const std::vector<std::string>& names);

/// Writes a file in a marked folder as write_atomically() does, after setting aside a file with other
/// content.
void write_output(const fs::path& file, std::string_view bytes);

/// What happens to an existing folder of the same name. replace: it moves to earlier-<n> beside it.
enum class Existing { reject, replace };

/// A folder that is filled as a hidden sibling, .<target>.partial. commit() gives it its name and its marker;
/// without commit() it is removed. The marker is locked while this object lives, so that a second process is
/// rejected and leftovers are recognized.
class AtomicFolder {
 public:
  /// Creates the temporary folder and the parents it needs. Throws FileError if that fails, if another
  /// process is creating the same target, or if `target` exists and is to be rejected or cannot be replaced.
  explicit AtomicFolder(fs::path target, Existing existing = Existing::reject);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const fs::path& path() const { return path_; }  ///< where to write

  /// Flushes everything to disk and renames the folder to `target` in one step. Throws FileError.
  void commit();

 private:
  fs::path target_, path_;
  Existing existing_;
  FileLock lock_;
  bool committed_ = false;
};

/// Removes partial folders in `folder` that killed processes left behind, except other users'. A complete one
/// gets its name, or moves to earlier-<n> if that is taken.
void remove_leftovers(const fs::path& folder);

}  // namespace sim::files
