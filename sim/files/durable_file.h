// Files and folders that appear complete or not at all, whenever the process is killed or the power fails.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/files/file_error.h"

namespace sim::files {

/// Writes `bytes` to a temporary sibling, forces it to the disk and renames it to `file`, which is replaced.
/// Throws FileError; then `file` is as it was.
void write_durably(const std::filesystem::path& file, std::string_view bytes);

/// What happens to an existing folder of the same name.
enum class Existing { refuse, replace };

/// A folder that is filled under the name of a temporary, hidden sibling and gets its own name by commit().
/// The destructor removes the temporary if there was no commit(). The temporary of a killed process is
/// removed by the next DurableFolder of the same name on the same machine.
class DurableFolder {
 public:
  /// Makes the temporary folder, and the parents it needs. Throws FileError when that cannot be, or when
  /// `target` exists and is to be refused.
  explicit DurableFolder(std::filesystem::path target, Existing existing = Existing::refuse);
  ~DurableFolder();
  DurableFolder(const DurableFolder&) = delete;
  DurableFolder& operator=(const DurableFolder&) = delete;

  const std::filesystem::path& path() const { return temporary_; }  ///< where to write
  const std::filesystem::path& target() const { return target_; }

  /// Forces all that was written to the disk and renames the folder to `target`, in one step. Throws
  /// FileError.
  void commit();

 private:
  std::filesystem::path target_, temporary_;
  Existing existing_;
  bool committed_ = false;
};

}  // namespace sim::files
