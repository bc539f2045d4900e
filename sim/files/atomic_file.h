// Files and folders that appear complete or not at all, even if the process is killed; inter-process locks.
#pragma once

#include "sim/files/text.h"

namespace sim::files {

/// A locked file (flock). The end of its life or of the process releases it; children do not inherit it.
class FileLock {
 public:
  /// shared, exclusive: make the file if it is missing and wait for the lock. try_exclusive does not wait;
  /// try_existing does not make the file either.
  enum class How { shared, exclusive, try_exclusive, try_existing };

  /// Locks the file that has this name now, also one that this process cannot write, but not through a
  /// symbolic link. Returns nothing if `how` gives up; throws FileError.
  static std::optional<FileLock> acquire(const fs::path& file, How how);
  /// Locks a folder without a file in it; nothing if another process has the lock. Succeeds if the file
  /// system cannot lock folders; throws FileError.
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

/// Writes `bytes` to a temporary sibling (.<file>.partial), forces it to the disk and renames it to `file`;
/// keeps an existing file's permissions. Throws FileError, as require_regular() does; `file` is then
/// unchanged.
void write_atomically(const fs::path& file, std::string_view bytes);

/// Returns whether a path is the name of a temporary sibling made here (".X.partial").
bool is_partial(const fs::path& path);

// The marker of a folder that the program made. What such a folder, or a file of the program in it, is
// replaced with moves it aside: nothing that a user added is ever removed.

/// The marker, a text file. It is empty until the folder is complete.
inline constexpr const char* kMarker = ".gaitslam";

/// Returns whether the folder is complete and was made by the program. Symbolic links are neither folders nor
/// markers.
bool has_marker(const fs::path& folder);

/// Throws a FileError unless the folder is missing, empty, or has a marker. Symbolic links and files are
/// rejected.
void require_replaceable(const fs::path& folder);

/// Makes the folder if it is missing, and its marker. Throws a FileError if it has no marker and one of these
/// names is in it; then nothing is changed.
void claim_outputs(const fs::path& folder, const std::vector<std::string>& names);

/// Moves those of these names that exist in the folder into its first folder earlier-<n> that has none of
/// them. Returns that folder, or nothing if none of them exists; throws FileError.
std::optional<fs::path> set_aside(const fs::path& folder, const std::vector<std::string>& names);

/// Writes a file of a marked folder as write_atomically() does, after setting aside one with other content.
void write_output(const fs::path& file, std::string_view bytes);

/// Treatment of an existing folder of the same name. replace: it moves to earlier-<n> beside it.
enum class Existing { reject, replace };

/// A folder that is filled as a hidden sibling, .<target>.partial, gets its name and its marker by commit(),
/// and is removed without it. The marker is locked while this object lives, so that a second process is
/// rejected and a leftover is recognized.
class AtomicFolder {
 public:
  /// Makes the temporary folder and the parents it needs. Throws FileError if that fails, if another process
  /// makes the same target, or if `target` exists and is to be rejected or cannot be replaced.
  explicit AtomicFolder(fs::path target, Existing existing = Existing::reject);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const fs::path& path() const { return path_; }  ///< where to write

  /// Forces everything to the disk and renames the folder to `target` in one step. Throws FileError.
  void commit();

 private:
  fs::path target_, path_;
  Existing existing_;
  FileLock lock_;
  bool committed_ = false;
};

/// Removes the partial folders in `folder` that killed processes left, except those of other users. A
/// complete one gets its name, or moves to earlier-<n> if that is taken.
void remove_leftovers(const fs::path& folder);

}  // namespace sim::files
