#include "sim/files/text.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace sim::files {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = 1 << 16;  // bytes

[[noreturn]] void fail(const fs::path& file, int fault) {
  throw FileError(file, std::string("cannot be read: ") + std::strerror(fault));
}

bool is_between(std::string_view character, std::string_view first, std::string_view last) {
  return character.size() == first.size() && character >= first && character <= last;
}

// The bytes of the first character; 0 if it is not UTF-8.
std::size_t bytes_of_first(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t n = first < 0x80                    ? 1
                        : first >= 0xC2 && first < 0xE0 ? 2
                        : first >= 0xE0 && first < 0xF0 ? 3
                        : first >= 0xF0 && first < 0xF5 ? 4
                                                        : 0;
  if (n == 0 || n > text.size()) return 0;
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
  return std::ranges::all_of(text.substr(1, n - 1), continues) ? n : 0;
}

bool is_obeyed(std::string_view character) {
  if (character.size() == 1)
    return character != "\n" && character != "\t" && (character[0] < ' ' || character[0] == '\x7F');
  return is_between(character, "\xC2\x80", "\xC2\x9F") ||          // C1 controls
         is_between(character, "\xE2\x80\xAA", "\xE2\x80\xAE") ||  // U+202A to U+202E
         is_between(character, "\xE2\x81\xA6", "\xE2\x81\xA9");    // U+2066 to U+2069
}

}  // namespace

std::string sanitize(const std::string& text) {
  std::string cleaned;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t n = bytes_of_first(rest);
    const std::string_view character = rest.substr(0, std::max<std::size_t>(n, 1));
    cleaned += n == 0 || is_obeyed(character) ? "?" : character;
    rest.remove_prefix(character.size());
  }
  return cleaned;
}

std::string shell_word(const std::string& text) {
  static constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == text.npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

Descriptor::~Descriptor() {
  if (fd >= 0) ::close(fd);
}

InputFile::InputFile(const fs::path& file, std::uintmax_t most)
    : file_(file),
      in_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)),
      most_(most),
      piece_(std::make_unique_for_overwrite<char[]>(kPiece)) {
  const int fd = in_.fd;
  if (fd < 0 && errno == ENXIO) throw FileError(file, kNotRegular);  // a socket
  if (fd < 0) fail(file, errno);
  struct stat found {};
  if (::fstat(fd, &found) != 0) fail(file, errno);
  if (S_ISDIR(found.st_mode)) fail(file, EISDIR);
  if (S_ISREG(found.st_mode))
    size_ = static_cast<std::uintmax_t>(found.st_size);
  else if (file == "/dev/stdin" || file.parent_path() == "/dev/fd" || file.parent_path() == "/proc/self/fd")
    ::fcntl(fd, F_SETFL, 0);  // waits for its bytes
  else
    throw FileError(file, kNotRegular);
  if (size_ > most) throw FileError(file, fmt::format("has {} bytes, expected at most {}", size_, most));
}

std::string_view InputFile::next() {
  ssize_t n;
  do n = ::read(in_.fd, piece_.get(), kPiece);
  while (n < 0 && errno == EINTR);
  if (n < 0) fail(file_, errno);
  const auto bytes = static_cast<std::size_t>(n);
  if ((read_ += bytes) > most_) throw FileError(file_, fmt::format("has more than {} bytes", most_));
  return {piece_.get(), bytes};
}

std::string read_text(const fs::path& file, std::uintmax_t most) {
  InputFile in(file, most);
  std::string text;
  for (std::string_view piece; !(piece = in.next()).empty();) text += piece;
  return text;
}

void write_text(const fs::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) throw FileError(file, std::string("cannot be written: ") + std::strerror(errno));
}

}  // namespace sim::files
