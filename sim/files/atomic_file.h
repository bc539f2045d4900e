// Files and folders that appear complete or not at all, even if the process is killed or the power fails;
// inter-process locks.
#pragma once

#include "sim/files/text.h"

namespace sim::files {

/// A locked file (flock). The lock is released when this object or the process ends; child processes do not
/// inherit it.
class FileLock {
 public:
  /// shared, exclusive: wait for the lock. soon: waits 3 s at most, enough for a killed process to end.
  /// try_exclusive: does not wait.
  enum class How { shared, exclusive, soon, try_exclusive };

  /// Locks the file that has this name now, and creates it if it is missing. Also locks a file that this
  /// process cannot write, but not through a symbolic link. Returns nothing if `how` gives up. Throws
  /// FileError.
  static std::optional<FileLock> acquire(const fs::path& file, How how);

  int fd() const { return file_.fd; }

 private:
  explicit FileLock(int fd) : file_(fd) {}
  Descriptor file_;
};

/// Writes these bytes to an open file, at its position. file: its name, for FileError.
void write_all(int fd, const fs::path& file, std::string_view bytes);

/// Throws a FileError if this name, or the target of a link of this name, exists and is not a regular file.
void require_regular(const fs::path& file);

/// Publishes a result: flushes a file or a folder to disk, renames it and flushes the folder that contains
/// it. An existing marked folder is first renamed to .<target>.old and removed at the end. Both paths must
/// be on the same file system. Throws FileError.
void publish(const fs::path& written, const fs::path& target);

/// Writes a temporary sibling, .<file>.partial, and publishes it. Keeps an existing file's permissions.
/// Throws FileError, as require_regular() does; `file` is then unchanged.
void write_atomically(const fs::path& file, std::string_view bytes);

/// The name of a text file in each folder created by the program.
inline constexpr const char* kMarker = ".gaitslam";

/// Returns whether the program created the folder. Symbolic links count as neither folders nor markers.
bool has_marker(const fs::path& folder);

/// Throws a FileError unless the folder is missing, empty, or has a marker. Symbolic links and files are
/// rejected.
void require_replaceable(const fs::path& folder);

/// Creates the folder if it is missing, and its marker. Throws FileError, as require_replaceable() does.
void mark_folder(const fs::path& folder);

/// Removes a marked folder, its marker last. Keeps files that cannot be removed.
void remove_marked(const fs::path& folder);

/// Removes the temporary siblings (.X.partial, .X.old) in `folder` that killed processes left behind, except
/// other users'.
void remove_leftovers(const fs::path& folder);

/// Which contents of an interrupted AtomicFolder its next attempt finds.
enum class Keeps { nothing, marked_folders };

/// A folder that is filled as a hidden sibling, .<target>.partial, with a marker. commit() publishes it;
/// without commit() it is removed, unless it keeps anything. The marker is locked while this object lives, so
/// that a second process is rejected.
class AtomicFolder {
 public:
  /// Creates the temporary folder, emptied of what it does not keep, and its parents. Throws
  /// FileError if that fails, if another process is creating the same target, or if `target` cannot be
  /// replaced.
  explicit AtomicFolder(fs::path target, Keeps keeps = Keeps::nothing);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const fs::path& path() const { return path_; }  ///< where to write

  /// Gives the folder its name. Throws FileError.
  void commit();

 private:
  fs::path target_, path_;
  Keeps keeps_;
  FileLock lock_;
  bool committed_ = false;
};

}  // namespace sim::files
