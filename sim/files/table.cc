#include "sim/files/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace sim::files {
namespace {

using std::chrono::nanoseconds;

constexpr std::string_view kBlank = " \t\r\"";

using enum Quantity;

/// Names of columns in lower case, each between spaces, without their axis (w, x, y or z) and with '.' for
/// '/'. Only the last two words of a dotted name such as /odom/pose/position/x count.
constexpr std::pair<Quantity, std::string_view> kStems[] = {
    {position, "  t p p_ p_rs_r_ position. position_ "},
    {orientation, " q q_ q_rs_ orientation. orientation_ "},
    {angular_rate, " w w_ w_rs_s_ gyro_ omega_ angular_velocity. angular_velocity_ "},
    {acceleration, " a a_ a_rs_s_ acc_ linear_acceleration. linear_acceleration_ "}};
constexpr std::string_view kElements = "pr11pr12pr13pr22pr23pr33pt11pt12pt13pt22pt23pt33";

/// Names of stamps whose unit is in the title, and names that define it: the first is PlotJuggler's, the
/// others are ROS names, of which two pairs are a stamp in two columns.
constexpr std::string_view kStamps = " t time timestamp stamp ";
constexpr std::pair<std::string_view, double> kStampsWithUnit[] = {
    {" __time ", 1e9}, {" field.header.stamp ", 1}, {" sec secs ", 1e9}, {" nanosec nsecs ", 1}};

/// Units. A name without a unit has the first one, but a stamp must state its unit.
constexpr struct {
  Quantity quantity;
  std::string_view unit;
  double factor;
} kUnits[] = {{time, "s", 1e9},
              {time, "ms", 1e6},
              {time, "us", 1e3},
              {time, "ns", 1},
              {position, "m", 1},
              {position, "cm", 1e-2},
              {position, "mm", 1e-3},
              {position, "km", 1e3},
              {orientation, "1", 1},
              {angular_rate, "rad s^-1", 1},
              {angular_rate, "rad/s", 1},
              {angular_rate, "deg s^-1", M_PI / 180},
              {angular_rate, "deg/s", M_PI / 180},
              {acceleration, "m s^-2", 1},
              {acceleration, "m/s^2", 1},
              {acceleration, "g", 9.80665},
              {covariance, "m^2", 1},
              {covariance, "rad^2", 1}};

constexpr std::array<const char*, 6> kWords{"stamp",        "position",     "orientation",
                                            "angular rate", "acceleration", "covariance"};
constexpr std::array<std::size_t, 6> kCounts{1, 3, 4, 3, 3, 12};

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  return text.substr(0, text.find_last_not_of(kBlank) + 1);
}

/// Returns whether a list contains a word.
bool lists(std::string_view words, std::string_view word) {
  return words.find(fmt::format(" {} ", word)) != words.npos;
}

/// Returns the words after the dot before the last `count` dots, or all.
std::string_view last_words(std::string_view name, int count) {
  std::size_t dot = name.size();
  while (count-- > 0 && dot != name.npos && dot > 0) dot = name.rfind('.', dot - 1);
  return dot == name.npos || dot == 0 ? name : name.substr(dot + 1);
}

char separator_of(std::string_view line) {
  for (const char separator : {';', '\t', ','})
    if (line.find(separator) != line.npos) return separator;
  return ' ';
}

}  // namespace

std::optional<nanoseconds> parse_stamp(std::string_view text, double ns_per_unit) {
  const std::size_t dot = text.find('.');
  if (ns_per_unit == 1e9 && dot < 10 && text.size() == dot + 10) {  // as tum_row() writes it, 20 times faster
    const auto s = parse_number<std::uint32_t>(text.substr(0, dot)),
               ns = parse_number<std::uint32_t>(text.substr(dot + 1));
    if (s && ns) return std::chrono::seconds(*s) + nanoseconds(*ns);
  }
  const auto whole = parse_number<std::int64_t>(text);
  const auto value = whole ? std::optional(static_cast<long double>(*whole))
                           : parse_number<long double>(text);  // x86's 64-bit mantissa keeps every ns
  if (!value) return std::nullopt;
  const long double ns = *value * ns_per_unit;
  if (!(std::abs(ns) <= 9e18L)) return std::nullopt;
  return nanoseconds(std::llround(ns));
}

std::string not_rising(nanoseconds before, nanoseconds stamp) {
  const std::string why = "the stamp is not after the previous one: it is ";
  if (stamp == before) return why + "the same";
  return why + fmt::format("{:.6g} s earlier", 1e-9 * double((before - stamp).count()));
}

nanoseconds median_step(const std::vector<nanoseconds>& stamps) {
  std::vector<nanoseconds> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
  if (steps.empty()) return nanoseconds(0);
  const auto middle = steps.begin() + std::ptrdiff_t(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return *middle;
}

TableRow::TableRow(std::shared_ptr<const fs::path> file, std::size_t line, std::string_view text,
                   char separator)
    : Row(std::move(file), line) {
  begin_ = text.data();
  for (std::size_t at = 0; at <= text.size();) {
    if (separator == ' ' && (at = text.find_first_not_of(kBlank, at)) == text.npos) break;
    const std::size_t end =
        std::min(separator == ' ' ? text.find_first_of(kBlank, at) : text.find(separator, at), text.size());
    fields_.push_back(trimmed(text.substr(at, end - at)));
    at = end + 1;
  }
}

Table::Table(const fs::path& file, Expected expected, const std::string& columns)
    : file_(std::make_shared<const fs::path>(file)), expected_(expected), text_(read_text(file)) {
  require_utf8(file, text_);
  if (text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
  if (text_.find('\n') == text_.npos && text_.find('\r') != text_.npos)
    throw FileError(file, "lines end with CR, expected line feeds");
  std::vector<std::string_view> above;  // lines above the first row
  bool has_titles = false;              // the last of them is not a comment
  std::size_t number = 0;
  for (std::size_t begin = 0, end; begin < text_.size(); begin = end + 1) {
    end = std::min(text_.find('\n', begin), text_.size());
    ++number;
    const std::string_view line = trimmed(std::string_view(text_).substr(begin, end - begin));
    if (line.empty()) continue;
    const bool comment = line[0] == '#' || line[0] == '%';
    if (rows_.empty() && !comment) separator_ = separator_of(line);
    if (!comment && (separator_ == ';' || separator_ == '\t'))
      std::replace(text_.begin() + std::ptrdiff_t(begin), text_.begin() + std::ptrdiff_t(end), ',', '.');
    if (comment ||
        (rows_.empty() && !parse_number<double>(TableRow(file_, number, line, separator_).text(0)))) {
      if (rows_.empty()) above.push_back(line), has_titles = !comment;
      continue;
    }
    rows_.emplace_back(file_, number, std::string_view(text_).substr(begin, end - begin), separator_);
    width_ = std::max(width_, rows_.back().fields());
  }
  if (!columns.empty()) name(columns), above.clear();
  for (; titles_.empty() && !above.empty(); above.pop_back(), has_titles = false)
    if (auto titles = titles_of(above.back(), separator_); has_titles || is_header(titles))
      titles_ = std::move(titles);
  const auto has = [&](std::string_view text) {
    return std::ranges::any_of(titles_, [&](const Title& title) { return title.name.starts_with(text); });
  };
  for (Title& title : titles_)  // as EuRoC and TUM define it
    if (title.name == "timestamp" && title.unit.empty())
      title.unit = has("p_RS_R_") || has("w_RS_S_") ? "ns" : separator_ == ' ' && has("tx") ? "s" : "";
  // OpenVINS' header names covariances even if no row has any.
  while (titles_.size() > width_ && titles_.back().quantity == covariance) titles_.pop_back();
  if (columns.empty() && is_named() && !rows_.empty() && titles_.size() != width_)
    fail(fmt::format("its header names {}, its rows have {}", counted(titles_.size(), "column"), width_));
}

std::vector<Table::Title> Table::titles_of(std::string_view line, char separator) const {
  line.remove_prefix(std::min(line.find_first_not_of("# \t"), line.size()));
  if (line.starts_with("% ")) line.remove_prefix(2);
  std::vector<std::string> words(1);
  int depth = 0;
  for (const char c : line) {
    depth += (c == '[' || c == '(') - (c == ']' || c == ')');
    const bool ends = separator == ' ' ? depth == 0 && (c == ' ' || c == '\t' || c == ',') : c == separator;
    if (!ends)
      words.back() += c;
    else if (separator != ' ' || !words.back().empty())
      words.emplace_back();
  }
  if (separator == ' ' && words.back().empty()) words.pop_back();
  std::vector<Title> titles;
  for (const std::string& word : words)
    if (separator == ' ' && !titles.empty() && (word[0] == '[' || word[0] == '('))
      titles.back() = parse(titles.back().name + word);  // a unit after a space
    else
      titles.push_back(parse(word));
  return titles;
}

Table::Title Table::parse(std::string_view text) const {
  Title title;
  text = trimmed(text);
  if (const std::size_t open = text.find_first_of("[("); open != text.npos) {
    title.unit = trimmed(text.substr(open + 1, std::min(text.find_last_of("])"), text.size()) - open - 1));
    text = trimmed(text.substr(0, open));
  }
  title.name = text;
  std::string name = title.name;
  if (name.size() > 1 && name[0] == '-') name.erase(0, 1), title.factor = -1;
  for (char& c : name) c = c == '/' ? '.' : char(std::tolower(static_cast<unsigned char>(c)));
  if (lists(kStamps, name)) title.quantity = time, title.factor = 0;
  for (const auto& [names, ns] : kStampsWithUnit)
    if (lists(names, name) || lists(names, last_words(name, 1)))
      title.quantity = time, title.factor = ns, title.axis = names.starts_with(" n");
  if (const std::size_t element = kElements.find(name); name.size() == 4 && element % 4 == 0)
    title.quantity = covariance, title.axis = element / 4;
  if (name.empty()) return title;
  std::string_view stem = last_words(name, 2);
  stem.remove_suffix(1);
  for (const auto& [quantity, stems] : kStems)
    if (const auto axis = std::size_t(name.back() - (quantity == orientation ? 'w' : 'x'));
        lists(stems, stem) && name.back() >= 'w' && axis < 4)
      title.quantity = quantity, title.axis = axis;
  return title;
}

bool Table::is_header(const std::vector<Title>& titles) const {
  const auto is_known = [](const Title& title) { return title.quantity.has_value(); };
  const auto is_marked = [&](const Title& title) {
    return separator_ != ' ' || title.quantity == time || !title.unit.empty();
  };
  return std::ranges::count_if(titles, is_known) >= 3 ||
         (titles.size() == width_ && std::ranges::any_of(titles, is_marked));
}

void Table::name(const std::string& columns) {
  titles_ = titles_of(columns, ' ');
  for (const Title& title : titles_)
    if (!title.quantity && title.name != "-")
      fail(fmt::format("--columns: unknown name \"{}\", expected - for a column that is not used",
                       title.name));
  if (titles_.size() > width_) fail(fmt::format("--columns has {}", counted(titles_.size(), "name")));
}

double Table::factor(const Title& title) const {
  if (title.unit.empty() && title.factor != 0) return title.factor;
  std::string known;
  for (const auto& [quantity, unit, value] : kUnits) {
    if (quantity != title.quantity) continue;
    if (unit == title.unit) return title.factor < 0 ? -value : value;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", unit);
  }
  fail(fmt::format("column \"{}\" has {}, expected one of {}", title.name,
                   title.unit.empty() ? "no unit" : fmt::format("the unknown unit \"{}\"", title.unit),
                   known));
}

std::vector<Column> Table::columns(Quantity quantity) const {
  const auto of = std::size_t(quantity);
  std::vector<std::optional<Column>> found(kCounts[of]);
  for (std::size_t field = 0; field < titles_.size(); ++field) {
    const Title& title = titles_[field];
    if (title.quantity != quantity) continue;
    found.resize(std::max(found.size(), title.axis + 1));
    if (found[title.axis]) fail(fmt::format("two columns are the same part of the {}", kWords[of]));
    found[title.axis] = Column{field, factor(title)};
  }
  std::vector<Column> all;
  for (const auto& column : found)
    if (column) all.push_back(*column);
  if (!all.empty() && all.size() < found.size())
    fail(fmt::format("{} of {} columns of the {} have a known name", all.size(), found.size(), kWords[of]));
  return all;
}

std::vector<Column> Table::required(Quantity quantity) const {
  std::vector<Column> found = columns(quantity);
  if (found.empty()) fail(fmt::format("no column contains the {}", kWords[std::size_t(quantity)]));
  return found;
}

std::vector<std::string> Table::names() const {
  std::vector<std::string> all;
  for (const Title& title : titles_) {
    const bool lacks_unit = title.factor == 0 && title.unit.empty();
    const std::string unit = lacks_unit ? "ns" : title.unit;
    all.push_back(!title.quantity ? "-"
                  : unit.empty()  ? title.name
                                  : fmt::format("{}[{}]", title.name, unit));
  }
  return all;
}

nanoseconds Table::stamp(const TableRow& row, const std::vector<Column>& columns) const {
  const Column& first = columns.at(0);
  row.number(first.field);
  const auto t = parse_stamp(row.text(first.field), first.factor);
  if (!t) fail(fmt::format("the time {} in its unit is more than 9e9 s", row.text(first.field)));
  if (columns.size() == 1) return *t;
  const auto rest = parse_number<std::int64_t>(row.text(columns[1].field));
  if (!rest || *rest < 0 || *rest >= 1'000'000'000 || t->count() % 1'000'000'000 != 0)
    row.fail(columns[1].field, "expected whole seconds, and whole nanoseconds below 1 s in a second column");
  return *t + nanoseconds(*rest);
}

void Table::fail(const std::string& why) const {
  constexpr std::size_t kShown = 160;
  if (rows_.empty()) throw FileError(*file_, why);
  std::string row;
  for (std::size_t i = 0; i < rows_[0].fields(); ++i)
    row += fmt::format("{}{}", i == 0 ? "" : std::string(1, separator_), rows_[0].text(i));
  throw FileError(*file_, rows_[0].line(), "{}; the first row has {}: {}{}; expected {}", why,
                  counted(rows_[0].fields(), "column"), row.substr(0, kShown),
                  row.size() > kShown ? "..." : "", expected_(*this));
}

}  // namespace sim::files
