#include "sim/files/printed_text.h"

#include <algorithm>
#include <string_view>

namespace sim::files {
namespace {

bool is_between(std::string_view character, std::string_view first, std::string_view last) {
  return character.size() == first.size() && character >= first && character <= last;
}

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

// The bytes of the character with which the text begins; 0 where that is no UTF-8.
std::size_t bytes_of_first(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t n = first < 0x80                    ? 1
                        : first >= 0xC2 && first < 0xE0 ? 2
                        : first >= 0xE0 && first < 0xF0 ? 3
                        : first >= 0xF0 && first < 0xF5 ? 4
                                                        : 0;
  if (n == 0 || n > text.size()) return 0;
  const std::string_view others = text.substr(1, n - 1);
  return std::all_of(others.begin(), others.end(), is_continuation) ? n : 0;
}

bool is_obeyed(std::string_view character) {
  if (character.size() == 1)
    return character != "\n" && character != "\t" && (character[0] < ' ' || character[0] == '\x7F');
  return is_between(character, "\xC2\x80", "\xC2\x9F") ||          // C1 controls
         is_between(character, "\xE2\x80\xAA", "\xE2\x80\xAE") ||  // U+202A to U+202E
         is_between(character, "\xE2\x81\xA6", "\xE2\x81\xA9");    // U+2066 to U+2069
}

}  // namespace

std::string without_controls(const std::string& text) {
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

}  // namespace sim::files
