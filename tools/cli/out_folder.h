// Where results go, and whether they can.
#pragma once

#include <filesystem>
#include <string>

#include "sim/bench/result.h"

namespace cli {

namespace bench = sim::bench;
namespace fs = std::filesystem;

/// Throws UsageError when nothing can be written below the folder (which need not exist yet), or when
/// `asked_for` names a folder that has something in it and force is not given. Creates nothing.
void check_out_folder(const std::filesystem::path& folder, bool asked_for, bool force);

/// Takes away again, at its end, those folders above a result that were made for it and stayed empty.
class NewFolders {
 public:
  explicit NewFolders(const std::filesystem::path& folder);
  ~NewFolders();
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;

 private:
  std::filesystem::path folder_, existing_;
};

/// Prints the score of a result folder, and what went wrong; gives the exit code.
int report(const bench::Outcome& outcome, const fs::path& result_folder);

}  // namespace cli
