// Shared by the fuzz targets: the input as text and as a file, and the exceptions that a reader may throw.
#pragma once

#include <stdlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include "sim/files/text.h"
#include "sim/scenario/yaml.h"

namespace fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A folder in the temporary folder, which tools/fuzz.sh removes.
inline const std::filesystem::path& folder() {
  static const std::filesystem::path made = [] {
    std::string pattern = (std::filesystem::temp_directory_path() / "gaitslam-fuzz-XXXXXX").string();
    return std::filesystem::path(::mkdtemp(pattern.data()));
  }();
  return made;
}

/// Writes a file of that folder and returns its path.
inline std::filesystem::path file(const std::string& name, std::string_view text) {
  static std::set<std::string> made;  // their folders exist
  const std::filesystem::path path = folder() / name;
  if (made.insert(name).second) std::filesystem::create_directories(path.parent_path());
  sim::files::write_text(path, text);
  return path;
}

/// Calls `read`, which may throw FileError or ConfigError; any other exception ends the target.
/// Returns the error's message, empty on success.
template <class Read>
std::string read_or_reject(const Read& read) {
  try {
    read();
    return "";
  } catch (const sim::files::FileError& error) {
    return error.what();
  } catch (const sim::scenario::ConfigError& error) {
    return error.what();
  }
}

/// Ends the target if a property is violated.
inline void require(bool property) {
  if (!property) abort();
}

}  // namespace fuzz
