#include "sim/files/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace sim::files {
namespace {

constexpr double kLongest = 9e18;  // ns

// Names, each between spaces.
const std::map<Quantity, std::string> kNames{
    {Quantity::time,
     " time timestamp timestamps stamp times ts epoch sec secs seconds msec usec nsec nsecs nanosec nanosecs "
     "nanoseconds "},
    {Quantity::position, " p t pos position trans translation loc location "},
    {Quantity::orientation, " q quat quaternion orient orientation rot rotation attitude "},
    {Quantity::angular_rate, " w g gyr gyro gyroscope omega angularvelocity angvel angularrate "},
    {Quantity::acceleration,
     " a acc accel accelerometer acceleration linearacceleration linacc alpha specificforce "},
    {Quantity::other,
     " v vel velocity linearvelocity linvel b bias ba bg bw m mag magnetometer roll pitch yaw temperature "
     "cov lat latitude lon long longitude alt altitude north east down up "}};

std::optional<Quantity> quantity_named(const std::string& name) {
  for (const auto& [quantity, names] : kNames)
    if (names.find(" " + name + " ") != names.npos) return quantity;
  return std::nullopt;
}

// Units in lower case, without spaces, '^', '*', '_' and braces. Lengths are in m, rates in rad/s.
const std::map<Quantity, std::vector<std::pair<std::string_view, double>>> kUnits{
    {Quantity::time,
     {{"s sec secs seconds", 1e9},
      {"ms msec milliseconds", 1e6},
      {"us usec µs μs microseconds", 1e3},
      {"ns nsec nsecs nanosec nanosecs nanoseconds", 1}}},
    {Quantity::position, {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"km", 1e3}}},
    {Quantity::orientation, {{"1 -", 1}}},
    {Quantity::angular_rate,
     {{"rads-1 rad/s rads rad/sec radps radpers", 1},
      {"degs-1 deg/s degs deg/sec degps degpers dps °/s", M_PI / 180}}},
    {Quantity::acceleration, {{"ms-2 m/s2 m/s² ms2 m/s/s mps2 m/sec2", 1}, {"g", 9.80665}}}};

std::optional<double> factor_of(Quantity quantity, const std::string& unit) {
  for (const auto& [names, factor] : kUnits.at(quantity))
    if ((" " + std::string(names) + " ").find(" " + unit + " ") != std::string::npos) return factor;
  return std::nullopt;
}

bool is_unit(const std::string& unit) {
  return std::ranges::any_of(kUnits,
                             [&](const auto& entry) { return factor_of(entry.first, unit).has_value(); });
}

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      words.back() += lower(c);
    else if (!words.back().empty())
      words.emplace_back();
  if (words.back().empty()) words.pop_back();
  // Printed messages have these in front: field.pose.position.x
  static const std::set<std::string> kInFront{"field", "pose", "msg", "imu", "header"};
  while (words.size() > 1 && kInFront.contains(words[0])) words.erase(words.begin());
  return words;
}

bool is_axis(std::string_view word) { return word.size() == 1 && word[0] >= 'w' && word[0] <= 'z'; }

std::string joined(const std::vector<std::string>& words, std::size_t from = 0) {
  std::string all;
  for (; from < words.size(); ++from) all += words[from];
  return all;
}

// Separates the axis from the rest of the name in qx, gyrox_dps and est_qx, and frame and axis in p_G and
// p_G_Ix.
void split_axis(std::vector<std::string>& words) {
  if (std::ranges::any_of(words, is_axis)) return;
  for (std::size_t i = words.size(); i-- > 0;) {
    const std::string name = words[i].substr(0, words[i].size() - 1), axis = words[i].substr(name.size());
    const bool is_frame = i > 0 && name.size() == 1 && quantity_named(words[0]);
    if (!is_axis(axis) || !(is_frame || quantity_named(name)) ||
        (i + 1 < words.size() && !is_unit(joined(words, i + 1))))
      continue;
    words[i] = name;
    words.insert(words.begin() + static_cast<std::ptrdiff_t>(i) + 1, axis);
    return;
  }
}

// Looks the name up as all words, else as the first (p_RS_R is p), else as the last (/odom/pose/position is
// position).
std::optional<Quantity> quantity_of(const std::vector<std::string>& words, bool is_path) {
  std::optional<Quantity> found = quantity_named(joined(words));
  if (!found && !is_path) found = quantity_named(words.front());
  for (std::size_t from = 1; !found && from < words.size(); ++from)
    found = quantity_named(joined(words, from));
  return found;
}

struct CovarianceName {
  int row, column;  // order: orientation, position
  bool fixed_axes = false;
};
const std::map<std::string, int> kBlocks{{"orientation", 0}, {"rotation", 0}, {"rot", 0},
                                         {"position", 3},    {"pos", 3},      {"translation", 3}};

// The elements of a covariance: pr11, ptr12, covxy, covrollyaw; or, as in ROS, with an index: cov7,
// positioncov3.
const std::map<std::string, CovarianceName>& covariance_names() {
  static const auto names = [] {
    static constexpr std::array<std::array<const char*, 3>, 6> kAxes{{{"rx", "rx", "roll"},
                                                                      {"ry", "ry", "pitch"},
                                                                      {"rz", "rz", "yaw"},
                                                                      {"x", "tx", "px"},
                                                                      {"y", "ty", "py"},
                                                                      {"z", "tz", "pz"}}};
    std::map<std::string, CovarianceName> all;
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) {
        const auto name = [&](const std::string& text, bool fixed_axes = false) {
          all[text] = {row, column, fixed_axes};
        };
        const int i = row % 3, j = column % 3;
        const std::string of = row < 3 ? "r" : "t", to = column < 3 ? "r" : "t";
        name(fmt::format("p{}{}{}{}", of, to, i + 1, j + 1));
        if (of == to) name(fmt::format("p{}{}{}", of, i + 1, j + 1));
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = 0; b < 3; ++b)
            name(std::string("cov") + kAxes[static_cast<std::size_t>(row)][a] +
                     kAxes[static_cast<std::size_t>(column)][b],
                 (row < 3 && a == 2) || (column < 3 && b == 2));
        name(fmt::format("cov{}", 6 * ((row + 3) % 6) + (column + 3) % 6), true);
        for (const auto& [block, first] : kBlocks)
          if (first == row / 3 * 3 && of == to) {
            name(fmt::format("{}cov{}", block, 3 * i + j));
            name(fmt::format("{}cov{}{}", block, "xyz"[i], "xyz"[j]));
          }
      }
    return all;
  }();
  return names;
}

const std::map<std::string, double> kCovarianceUnits{{"m2", 1},
                                                     {"rad2", 1},
                                                     {"mrad", 1},
                                                     {"radm", 1},
                                                     {"cm2", 1e-4},
                                                     {"mm2", 1e-6},
                                                     {"deg2", M_PI* M_PI / 32400}};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\"#%";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  text.remove_suffix(text.size() - 1 - std::min(text.find_last_not_of(" \t\r\""), text.size() - 1));
  return text;
}

std::vector<std::string> split_titles(std::string_view text) {
  const char separator = text.find(';') != text.npos ? ';' : ',';
  const bool commas = text.find(separator) != text.npos;
  std::vector<std::string> titles(1);
  int depth = 0;
  for (const char c : trimmed(text)) {
    depth += (c == '[' || c == '(') - (c == ']' || c == ')');
    const bool ends = commas ? c == separator : depth == 0 && (c == ' ' || c == '\t');
    if (!ends)
      titles.back() += c;
    else if (commas || !titles.back().empty())
      titles.emplace_back();
  }
  if (commas) return titles;
  for (std::size_t i = 1; i < titles.size();)  // a unit after a space
    if (titles[i].starts_with('[') || titles[i].starts_with('('))
      titles[i - 1] += titles[i], titles.erase(titles.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
  return titles;
}

}  // namespace

std::optional<std::chrono::nanoseconds> parse_stamp(std::string_view text, const TimeUnit& unit) {
  const auto whole = parse_number<std::int64_t>(text);
  const auto value = whole ? std::optional(static_cast<long double>(*whole))
                           : parse_number<long double>(text);  // x86's 64-bit mantissa keeps every ns
  if (!value) return std::nullopt;
  const long double ns = *value * static_cast<long double>(unit.ns);
  if (!(std::abs(ns) <= kLongest)) return std::nullopt;
  return std::chrono::nanoseconds(std::llround(ns));
}

std::optional<double> median_step(const std::vector<double>& stamps) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    if (stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
  if (steps.empty()) return std::nullopt;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

const TimeUnit& unit_of_stamps(const fs::path& file, const std::vector<double>& stamps,
                               const TimeUnit* stated, double expected_step_s) {
  const std::optional<double> step = median_step(stamps);
  const double last = stamps.empty() ? 0 : stamps.back();
  const auto seconds = [](double x, const TimeUnit& unit) { return x * 1e-9 * static_cast<double>(unit.ns); };
  const auto steps_within = [&](const TimeUnit& unit, double least, double most) {
    return !step || (seconds(*step, unit) >= least && seconds(*step, unit) <= most);
  };
  if (stated) {
    if (!steps_within(*stated, 1e-6, 1e5) || std::abs(last) * static_cast<double>(stated->ns) > kLongest)
      throw FileError(file, "the header states {}, but the stamps, {} apart up to {}, are not", stated->name,
                      step.value_or(0), last);
    return *stated;
  }
  for (const TimeUnit& unit : kTimeUnits)
    if (seconds(last, unit) >= 1e9 && seconds(last, unit) < 1e10 && steps_within(unit, 1e-5, 1e4))
      return unit;
  if (!step) return std::abs(last) <= 9e9 ? kSeconds : kNanoseconds;
  if (*step < 10) return kSeconds;
  return *std::min_element(std::begin(kTimeUnits), std::end(kTimeUnits), [&](const auto& a, const auto& b) {
    const auto off = [&](const TimeUnit& unit) {
      return std::abs(std::log(seconds(*step, unit) / expected_step_s));
    };
    return off(a) < off(b);
  });
}

std::string not_rising(std::chrono::nanoseconds before, std::chrono::nanoseconds stamp) {
  std::string why = "the stamp is not after the previous one";
  if (stamp < before)
    why += fmt::format(": it is {:.6g} s earlier", 1e-9 * static_cast<double>((before - stamp).count()));
  if (stamp == before)
    why +=
        ": it is the same; if its last digits are missing or in another column, expected all digits, or a "
        "header that names both columns, such as secs,nsecs";
  return why;
}

bool Header::read_covariance(const std::vector<std::string>& words, Title& title) {
  std::string name = joined(words);
  const auto names = [&](const char* word) { return name.find(word) != name.npos; };
  const bool indexed = name.size() == 3 && name[0] == 'p' && parse_number<int>(name.substr(1));  // P12
  const bool variance = words.front() == "var" || words.front() == "variance";
  if (!covariance_names().contains(name) && !indexed && !variance && !names("cov")) return false;
  title.quantity = Quantity::other;
  title.of_covariance = std::ranges::none_of(std::array{"twist", "vel", "acc", "gyro", "bias"}, names);
  if (names("cov")) {  // the block, if any, then what follows "cov"
    name.clear();
    std::string after;
    for (const std::string& word : words)
      if (kBlocks.contains(word))
        name = word;
      else if (word.find("cov") != word.npos)
        after = word.substr(word.find("cov"));
      else if (!after.empty())
        after += word;
    if (after.starts_with("covariance")) after.erase(3, 7);
    if (after == "cov") after += std::exchange(title.unit, "");
    name += after;
  }
  if (const auto found = covariance_names().find(name); found != covariance_names().end())
    title.element = {found->second.row, found->second.column}, title.fixed_axes = found->second.fixed_axes;
  return true;
}

Header::Title Header::parse(std::string_view text) {
  Title title;
  text = trimmed(text);
  title.text = text;
  if (const std::size_t open = text.find_first_of("[("); open != text.npos) {
    for (const char c : text.substr(open + 1, text.find_last_of("])") - open - 1))
      if (std::string_view(" \t^*_{}").find(c) == std::string_view::npos) title.unit += lower(c);
    text = trimmed(text.substr(0, open));
  }
  std::vector<std::string> words = words_of(text);
  if (words.empty()) return title;
  if (read_covariance(words, title)) return title;
  split_axis(words);
  const auto axis = std::find_if(words.rbegin(), words.rend(), is_axis);
  if (axis != words.rend() &&
      (axis != std::prev(words.rend()) || words.size() == 1 || is_unit(joined(words, 1)))) {
    title.axis = (*axis)[0];
    for (auto word = axis.base(); word != words.end(); ++word) title.unit += *word;  // gyro_x_deg_s
    words.erase(std::prev(axis.base()), words.end());
    if (!words.empty()) title.quantity = quantity_of(words, title.text.starts_with('/'));
    title.stem = joined(words);
    return title;
  }
  if (words[0] == "t" || quantity_named(words[0]) == Quantity::time) {
    title.quantity = Quantity::time;
    if (title.unit.empty() && factor_of(Quantity::time, words.back())) {
      title.unit = words.back();
      words.pop_back();
    }
    for (const std::string& word : words) title.stem += word;
    return title;
  }
  title.quantity = quantity_of(words, title.text.starts_with('/'));
  if (title.quantity && *title.quantity != Quantity::time) title.quantity = Quantity::other;  // no axis
  return title;
}

Header::Header(fs::path file, std::size_t line, const std::vector<std::string>& titles)
    : file_(std::move(file)), line_(line) {
  for (const std::string& title : titles) titles_.push_back(parse(title));
}

Header::Header(fs::path file, std::size_t line, std::string_view text)
    : Header(std::move(file), line, split_titles(text)) {}

bool Header::names(Quantity quantity) const {
  return std::ranges::any_of(titles_, [&](const Title& t) { return t.quantity == quantity; });
}

bool Header::names_axis(char axis) const {
  return std::ranges::any_of(titles_, [&](const Title& t) { return !t.quantity && t.axis == axis; });
}

bool Header::are_titles() const {
  return std::ranges::count_if(titles_, [](const Title& title) { return title.axis != 0; }) >= 3;
}

bool Header::fit(std::size_t columns, bool commas) {
  const auto is_word = [](const Title& title) { return !title.quantity && title.axis == 0; };
  while (titles_.size() > columns && is_word(titles_.front())) titles_.erase(titles_.begin());
  const bool starts_with_pose = titles_.front().axis != 0 && !names(Quantity::time);
  if (starts_with_pose && titles_.size() + 1 == columns)
    titles_.insert(titles_.begin(), Title{"timestamp", "", Quantity::time});
  else if (!commas && std::ranges::any_of(titles_, is_word) && titles_.size() != columns &&
           titles_.front().quantity != Quantity::time)
    return false;
  else if (starts_with_pose)
    throw FileError(
        file_, line_,
        "the header names {} columns and no stamp, the rows have {}: expected a name for each column, or "
        "for each but a stamp in front",
        titles_.size(), columns);
  return true;
}

// A title without a quantity, such as "x", fits any quantity with its axis.
bool Header::fits(std::size_t field, Quantity quantity, char axis, bool named) const {
  if (field >= titles_.size()) return false;
  const Title& title = titles_[field];
  if (title.quantity) return title.quantity == quantity && title.axis == axis;
  return !named && (title.axis == axis || title.axis == 0);
}

double Header::factor(std::size_t field, Quantity quantity) const {
  const std::string& unit = titles_[field].unit;
  const auto found = unit.empty() ? std::optional(1.0) : factor_of(quantity, unit);
  if (found) return *found;
  std::string all;
  for (const auto& [names, value] : kUnits.at(quantity)) all += (all.empty() ? "" : " ") + std::string(names);
  fail(field, "unknown unit \"{}\", expected one of {}", unit, all);
}

std::vector<Column> Header::columns(Quantity quantity, std::string_view axes, std::size_t first) const {
  static constexpr std::array kWords{"the time", "the position", "the orientation", "the angular rate",
                                     "the acceleration"};
  const bool named = names(quantity);
  std::vector<std::size_t> in_order, by_name;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    std::vector<std::size_t> fitting;
    for (std::size_t field = 0; field < titles_.size(); ++field)
      if (titles_[field].axis == axes[i] && fits(field, quantity, axes[i], named)) fitting.push_back(field);
    const auto is_bare = [&](std::size_t field) { return titles_[field].stem.empty(); };
    const bool bare = !named && std::ranges::any_of(fitting, is_bare);  // "x" is preferred to "goal_x"
    if (bare) std::erase_if(fitting, [&](std::size_t field) { return !is_bare(field); });
    if (in_order.size() == i && fits(first + i, quantity, axes[i], named) &&
        (titles_[first + i].axis == 0 || std::ranges::count(fitting, first + i) > 0))
      in_order.push_back(first + i);
    if (fitting.size() == 1) by_name.push_back(fitting[0]);
    if (fitting.size() > 1 && !bare && quantity == Quantity::position)
      fail(fitting[1], "names the position along {} again, after column {}, expected it once", axes[i],
           fitting[0] + 1);
  }
  const std::vector<std::size_t>& found = in_order.size() == axes.size() ? in_order : by_name;
  if (found.size() < axes.size())
    fail(std::min(first + in_order.size(), titles_.size() - 1),
         "expected {} along {} here, or columns that name each axis once",
         kWords.at(static_cast<std::size_t>(quantity)), axes[in_order.size()]);
  std::vector<Column> columns;
  for (const std::size_t field : found) columns.push_back({field, factor(field, quantity)});
  return columns;
}

std::optional<CovarianceColumns> Header::covariance_columns(bool twenty) const {
  CovarianceColumns found;
  std::array<std::array<int, 6>, 6> times{};
  for (std::size_t field = 0; field < titles_.size(); ++field) {
    const Title& title = titles_[field];
    if (!title.of_covariance) continue;
    if (!title.element)
      fail(field,
           "unknown covariance name, expected for example Pr11, Pt12, cov_xy, cov_roll_yaw or "
           "pose.covariance[0]");
    const auto unit = kCovarianceUnits.find(title.unit.empty() ? "m2" : title.unit);
    if (unit == kCovarianceUnits.end()) fail(field, "unknown unit \"{}\", expected m^2 or rad^2", title.unit);
    const auto [row, column] = *title.element;
    if (times[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)]++ > 0)
      fail(field, "is repeated");
    found.elements.push_back({row, column, {field, unit->second}, !title.unit.empty()});
    found.fixed_axes |= title.fixed_axes;
  }
  const auto is_unknown = [](const Title& title) { return !title.quantity && title.axis == 0; };
  const auto unknown = std::ranges::find_if(titles_, is_unknown);
  if (twenty && (!found.elements.empty() || std::ranges::count_if(titles_, is_unknown) >= 12) &&
      unknown != titles_.end())
    fail(static_cast<std::size_t>(unknown - titles_.begin()),
         "unknown name, expected a covariance such as Pr11 or Pt12");
  if (found.elements.empty()) return std::nullopt;
  const auto has = [&](std::size_t row, std::size_t column) {
    return times[row][column] + times[column][row] > 0;
  };
  const bool crossed =
      std::ranges::any_of(found.elements, [](const auto& e) { return e.row / 3 != e.column / 3; });
  for (std::size_t row = 0; row < 6; ++row)
    for (std::size_t column = row; column < 6; ++column)
      if (!has(row, column) && (crossed || row / 3 == column / 3))
        throw FileError(file_, line_, "the covariance is incomplete: no column is P{}{}{}{}",
                        row < 3 ? "r" : "t", row / 3 == column / 3 ? "" : "t", row % 3 + 1, column % 3 + 1);
  return found;
}

const TimeUnit* Header::time_unit(std::size_t field) const {
  if (titles_[field].unit.empty()) return nullptr;
  const double ns = factor(field, Quantity::time);
  return std::find_if(std::begin(kTimeUnits), std::end(kTimeUnits),
                      [&](const TimeUnit& unit) { return static_cast<double>(unit.ns) == ns; });
}

StampColumns Header::stamp_columns() const {
  std::vector<std::size_t> times;
  for (std::size_t field = 0; field < titles_.size(); ++field)
    if (titles_[field].quantity == Quantity::time) times.push_back(field);
  if (times.empty()) return {};
  const auto of_message =
      std::ranges::find(times, "stamp", [&](std::size_t field) { return titles_[field].stem; });
  StampColumns stamp{of_message == times.end() ? times.front() : *of_message};
  stamp.unit = time_unit(stamp.field);
  for (const std::size_t field : times) {
    const TimeUnit* const unit =
        titles_[field].stem == titles_[stamp.field].stem ? time_unit(field) : nullptr;
    if (!unit || !stamp.unit) continue;
    if (unit->ns < stamp.unit->ns)
      stamp.rest = field, stamp.rest_unit = unit;
    else if (unit->ns > stamp.unit->ns)
      stamp = {field, unit, stamp.field, stamp.unit};
  }
  return stamp;
}

}  // namespace sim::files
