// Shared by the fuzz targets: the input as a file, and the exceptions that a reader may throw. A target is an
// inline function of the input as text; the others of its file are not part of the program.
#pragma once

#include <stdlib.h>

#include <set>

#include "sim/files/text.h"
#include "sim/scenario/yaml.h"

namespace fuzz {

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

/// Calls `read`, which may throw FileError or a Rejection. Returns their message, empty on success.
template <class Rejection = sim::scenario::ConfigError>
std::string read_or_reject(const auto& read) {
  try {
    read();
    return "";
  } catch (const Rejection& error) {
    return error.what();
  } catch (const sim::files::FileError& error) {
    return error.what();
  }
}

/// Ends the target if a property is violated.
inline void require(bool property) {
  if (!property) abort();
}

}  // namespace fuzz

/// The entry of libFuzzer, at the end of each file of targets.
#define GAITSLAM_FUZZ_ENTRY                                                           \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    fuzz::GAITSLAM_FUZZ(std::string_view(reinterpret_cast<const char*>(data), size)); \
    return 0;                                                                         \
  }
