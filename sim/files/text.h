// Reading and writing text files, whole or in pieces; names of files within a folder; the exception
// thrown by all readers and writers; text and tables for a terminal.
#pragma once

#include <fmt/core.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Embeds a file in the program: name() returns its bytes.
#define GAITSLAM_EMBED(name, file)                                                          \
  asm(".section .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name "_end:\n.text\n"); \
  extern "C" const char name##_begin[] __attribute__((visibility("hidden")));               \
  extern "C" const char name##_end[] __attribute__((visibility("hidden")));                 \
  static std::string_view name() { return {name##_begin, name##_end}; }

namespace sim {
namespace fs = std::filesystem;
}

namespace sim::files {

/// Returns the text with '?' in place of each control character (except line feed and tab), each character
/// that changes the writing direction or is forbidden in XML, and each byte that is not UTF-8.
std::string sanitize(const std::string& text);

/// Returns the sanitized text with '?' also in place of line feeds and tabs.
std::string one_line(const std::string& text);

/// Returns the text as one word of a POSIX shell command, quoted if needed.
std::string shell_word(const std::string& text);

/// A file is missing, cannot be read or written, or has the wrong content. what() is the sanitized text
/// "file: why", "file:line: why" or "file:line:column: why", with lines and columns from 1.
class FileError : public std::runtime_error {
 public:
  FileError(const fs::path& file, const std::string& why)
      : std::runtime_error(sanitize(file.string() + ": " + why)) {}
  /// why: a format string and its arguments.
  template <typename First, typename... T>
  FileError(const fs::path& file, fmt::format_string<First, T...> why, First&& first, T&&... rest)
      : FileError(file, fmt::format(why, std::forward<First>(first), std::forward<T>(rest)...)) {}
  FileError(const fs::path& file, std::size_t line, const std::string& why)
      : FileError(file.string() + ":" + std::to_string(line), why) {}
  template <typename First, typename... T>
  FileError(const fs::path& file, std::size_t line, fmt::format_string<First, T...> why, First&& first,
            T&&... rest)
      : FileError(file, line, fmt::format(why, std::forward<First>(first), std::forward<T>(rest)...)) {}
  FileError(const fs::path& file, std::size_t line, std::size_t column, const std::string& why)
      : FileError(file.string() + ":" + std::to_string(line) + ":" + std::to_string(column), why) {}

 protected:
  explicit FileError(const std::string& text) : std::runtime_error(sanitize(text)) {}
};

/// The disk is full or a device failed: neither the command line nor an input is wrong.
class DeviceError : public FileError {
 public:
  using FileError::FileError;
  explicit DeviceError(const std::string& text) : FileError(text) {}
};

/// Returns whether an operating system error means a full disk or a failed device.
bool is_of_device(int fault);

/// Throws FileError "file: what: reason" for an error number, or DeviceError if is_of_device() is true for
/// it.
[[noreturn]] void fail_by_errno(const fs::path& file, const std::string& what, int fault = errno);

/// An open file of the operating system, closed at the end of its life. Negative: none.
class Descriptor {
 public:
  explicit Descriptor(int opened) : fd(opened) {}
  Descriptor(Descriptor&& other) noexcept : fd(std::exchange(other.fd, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd, other.fd);
    return *this;
  }
  ~Descriptor();
  int fd;
};

/// Why pipes, devices and sockets are rejected.
inline constexpr const char* kNotRegular =
    "is not a regular file, expected one: pipes, devices and sockets are not read";

// Maximum sizes in bytes: larger than any file written by a person or by an hour of walking at the
// highest rates.
inline constexpr std::uintmax_t kMostOfYaml = 1 << 20, kMostOfJson = 64 << 20, kMostOfImage = 256 << 20;
/// Files that are read into memory whole, such as trajectories and logs.
inline constexpr std::uintmax_t kMostOfText = std::uintmax_t{2} << 30;
/// Files that are read row by row.
inline constexpr std::uintmax_t kMostOfRows = std::uintmax_t{16} << 30;

/// A regular file, or a link to one, read piece by piece; all input files are opened here. Only /dev/stdin
/// and /dev/fd/N, which a shell passes for <(...), may be pipes. All members throw FileError.
class InputFile {
 public:
  /// Throws if the file has more than `most` bytes, before reading it if its size is known.
  InputFile(const fs::path& file, std::uintmax_t most);

  std::uintmax_t size() const { return size_; }  ///< bytes; 0 for a pipe
  /// Returns the next bytes, none at the end of the file. They are valid until the next call.
  std::string_view next();

 private:
  fs::path file_;
  Descriptor in_;
  std::uintmax_t most_, size_ = 0, read_ = 0;
  std::unique_ptr<char[]> piece_;
};

/// Returns all bytes of a file. Throws FileError, as InputFile does.
std::string read_text(const fs::path& file, std::uintmax_t most = kMostOfText);

/// Writes exactly these bytes. Throws FileError "cannot be written: " and the reason. A killed process leaves
/// an incomplete file; with write_atomically it does not.
void write_text(const fs::path& file, std::string_view text);

/// Returns the number if the whole text is decimal and fits the type; otherwise nothing.
template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Returns parse_number() if the number is neither infinite nor NaN, otherwise nothing.
inline std::optional<double> parse_finite(std::string_view text) {
  const auto value = parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Returns the count with its noun: "1 seed", "2 seeds".
inline std::string counted(std::size_t n, std::string_view what) {
  return std::to_string(n) + " " + std::string(what) + (n == 1 ? "" : "s");
}

/// Returns the lines of a text without their line feeds.
std::vector<std::string> lines_of(std::string_view text);

/// Returns the lines of a text between "@@ title" and the next line that starts with "@@ ", or nothing if
/// there is no such title.
std::optional<std::string> titled_lines(std::string_view text, std::string_view title);

/// Throws FileError if the name of a file below a folder is empty, absolute or contains "..".
void require_below(const fs::path& folder, std::string_view name);

/// Returns folder/name. Throws FileError as require_below() does, or if a link on the way leaves the folder:
/// lists in external files must not open anything outside it.
fs::path contained_path(const fs::path& folder, std::string_view name);

inline constexpr std::size_t kTerminalWidth = 100;

/// naming: how many of the first columns identify a row. The first column is left-aligned, all
/// others are right-aligned.
struct TableShape {
  std::size_t naming = 1;
  std::size_t width = kTerminalWidth;
};

/// Returns rows of cells, all of the same length, as a table; the first row contains the titles. Rows with
/// different first cells are separated by an empty line. If the table is too wide, long titles are broken
/// after '_' and '.', then the remaining columns follow in more tables with the same naming columns.
std::string text_table(const std::vector<std::vector<std::string>>& rows, const TableShape& shape);

}  // namespace sim::files
