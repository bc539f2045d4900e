// Files and folders that appear complete or not at all, whenever the process is killed or the power fails.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/files/file_error.h"
#include "sim/files/file_lock.h"

namespace sim::files {

/// Throws a FileError where something has this name, or a symbolic link of this name leads to something, that
/// is no regular file: a device, a pipe, a folder.
void require_regular(const std::filesystem::path& file);

/// Writes `bytes` to a temporary sibling (.<file>.partial), forces it to the disk and renames it to `file`,
/// which is replaced and whose permissions are kept. The temporary of a killed process is used by the next
/// call for the same file. Throws FileError, as require_regular() does too; then `file` is as it was.
void write_durably(const std::filesystem::path& file, std::string_view bytes);

/// A hidden folder beside `target`, .<target>.partial, in which one process makes what then gets the name of
/// `target`. Its marker is locked while this object lives, so that a second process is refused, and what a
/// killed process left is recognised and removed. At the end of its life the folder is removed.
class PartialFolder {
 public:
  /// Makes the folder, and the parents it needs. Throws FileError when that cannot be, when another process
  /// makes the same target, or when somebody else's files are in the folder.
  explicit PartialFolder(const std::filesystem::path& target);
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const FileLock& lock() const { return lock_; }
  /// It was renamed and is not to be removed.
  void release() { released_ = true; }

 private:
  std::filesystem::path path_;
  FileLock lock_;
  bool released_ = false;
};

/// Removes those partial folders in `folder` that killed processes left. What belongs to another user, so
/// that it cannot be looked at, stays.
void remove_leftovers(const std::filesystem::path& folder);

/// What happens to an existing folder of the same name. replace: if the program made all that is in it.
enum class Existing { refuse, replace };

/// A folder that is filled as a PartialFolder and gets its own name by commit(), with a marker that lists all
/// files in it (owned_folder.h).
class DurableFolder {
 public:
  /// Makes the temporary folder. Throws FileError when that cannot be, when `target` exists and is to be
  /// refused, or when it holds anything that the program did not make.
  explicit DurableFolder(std::filesystem::path target, Existing existing = Existing::refuse);

  const std::filesystem::path& path() const { return partial_.path(); }  ///< where to write
  const std::filesystem::path& target() const { return target_; }

  /// Forces all that was written to the disk and renames the folder to `target`, in one step. Throws
  /// FileError. Where files of others appeared in the folder that was replaced, that folder is kept under
  /// another name, which the FileError says.
  void commit();

 private:
  void replace();
  void discard_old() const;

  std::filesystem::path target_;
  Existing existing_;
  PartialFolder partial_;
};

}  // namespace sim::files
