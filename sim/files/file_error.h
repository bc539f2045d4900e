// The exception of reading and writing files: it names the file, the place in it and what is wrong.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "sim/files/printed_text.h"

namespace sim::files {

/// A file is missing, cannot be read or written, or has the wrong content.
/// what() is "file: why", "file:line: why" or "file:line:column: why", lines and columns counted from 1,
/// without what a terminal obeys.
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& file, const std::string& why)
      : std::runtime_error(without_controls(file.string() + ": " + why)) {}
  FileError(const std::filesystem::path& file, std::size_t line, const std::string& why)
      : FileError(file.string() + ":" + std::to_string(line), why) {}
  FileError(const std::filesystem::path& file, std::size_t line, std::size_t column, const std::string& why)
      : FileError(file.string() + ":" + std::to_string(line) + ":" + std::to_string(column), why) {}
};

}  // namespace sim::files
