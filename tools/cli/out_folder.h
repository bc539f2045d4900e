// Where results go, and whether they can.
#pragma once

#include <filesystem>
#include <string>

namespace cli {

/// Throws UsageError when nothing can be written below the folder (which need not exist yet), or when
/// `asked_for` names a folder that has something in it and force is not given. Creates nothing.
void check_out_folder(const std::filesystem::path& folder, bool asked_for, bool force);

}  // namespace cli
