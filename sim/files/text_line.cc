#include "sim/files/text_line.h"

#include <fmt/format.h>

#include <algorithm>
namespace sim::files {

using std::chrono::nanoseconds;

TextLine::TextLine(const std::filesystem::path& file, std::size_t number, std::string_view text)
    : file_(file), number_(number), has_commas_(text.find(',') != text.npos) {
  constexpr std::string_view kApart = " \t\r,";
  for (std::size_t at = 0; (at = text.find_first_not_of(kApart, at)) != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kApart, at), text.size());
    fields_.push_back({text.substr(at, end - at), at + 1});
    at = end;
  }
}

void TextLine::fail(std::size_t field, const std::string& why) const {
  throw FileError(file_, number_, fields_.at(field).column, why);
}
void TextLine::fail(const std::string& why) const { throw FileError(file_, number_, why); }

double TextLine::number(std::size_t field) const {
  const auto value = parse_finite(text(field));
  if (!value) fail(field, fmt::format("expected a finite number, found \"{}\"", text(field)));
  return *value;
}

nanoseconds TextLine::stamp(std::size_t field, const TimeUnit& unit) const {
  number(field);
  const auto t = parse_stamp(text(field), unit);
  if (!t) fail(field, "a time of more than 9e9 s: is it in nanoseconds?");
  return *t;
}

TextLines::TextLines(const std::filesystem::path& file) : text_(read_text(file)) {
  std::size_t number = 0;
  for (std::string_view rest = text_; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view text = rest.substr(0, end);
    if (++number == 1 && text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte order mark
    TextLine line(file, number, text);
    bool is_header = false;
    if (lines_.empty() && line.size() >= 4 && !parse_number<double>(line.text(0))) {
      Header header(file, number, text);
      is_header = header.are_titles();
      if (is_header) header_.emplace(std::move(header));
    }
    if (!line.is_comment() && !is_header) lines_.push_back(std::move(line));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

}  // namespace sim::files
