// Whole files as text or bytes, read and written in one call.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "sim/files/file_error.h"
#include "sim/files/input_file.h"

namespace sim::files {

/// All bytes of a file that InputFile reads, `most` at most. Throws FileError, as InputFile does.
std::string read_text(const std::filesystem::path& file, std::uintmax_t most = kMostOfText);

/// Makes or replaces a file that holds exactly these bytes. Throws FileError "cannot be written: " and the
/// reason of the operating system. A process that is killed meanwhile leaves a part of the file;
/// write_durably does not.
void write_text(const std::filesystem::path& file, std::string_view text);

}  // namespace sim::files
