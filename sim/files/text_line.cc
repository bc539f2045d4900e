#include "sim/files/text_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "sim/files/text.h"

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

// Decimals to nanoseconds without a double, which resolves today's date to 100 ns only.
nanoseconds TextLine::stamp(std::size_t field, Unit unit) const {
  const std::string_view text = fields_.at(field).text;
  const std::int64_t scale = unit == Unit::seconds ? 1'000'000'000 : 1;
  const double approximately = number(field);
  if (std::abs(approximately) * static_cast<double>(scale) > 9e18)
    fail(field, "a time of more than 9e9 s: is it in nanoseconds?");
  if (text.find_first_of("eE") != text.npos)
    return nanoseconds(std::llround(approximately * static_cast<double>(scale)));
  const std::size_t dot = text.find('.');
  std::int64_t whole = 0, digit = scale / 10, fraction = 0;
  std::from_chars(text.data(), text.data() + std::min(dot, text.size()), whole);
  for (std::size_t i = dot == text.npos ? text.size() : dot + 1; i < text.size(); ++i, digit /= 10)
    fraction += (text[i] - '0') * digit;
  return nanoseconds(whole * scale + (text.front() == '-' ? -fraction : fraction));
}

TextLines::TextLines(const std::filesystem::path& file) : text_(read_text(file)) {
  std::size_t number = 0;
  for (std::string_view rest = text_; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    TextLine line(file, ++number, rest.substr(0, end));
    if (!line.is_comment()) lines_.push_back(std::move(line));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

}  // namespace sim::files
