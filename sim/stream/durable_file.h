// Files and folders that appear whole or not at all, whenever the process is killed or the power goes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/stream/file_error.h"

namespace sim::stream {

/// Writes `bytes` to a temporary sibling, forces them to the disk and renames it to `file`, replacing what
/// was there. Throws FileError; then `file` is as it was.
void write_durably(const std::filesystem::path& file, std::string_view bytes);

/// What a finished folder does to one of the same name.
enum class Existing { refuse, replace };

/// A folder that is filled under a temporary, hidden sibling name and appears under its own name by commit()
/// alone. Destroyed without commit(): the temporary is removed. Left behind by a killed process: removed by
/// the next DurableFolder of the same name on the same machine.
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

}  // namespace sim::stream
