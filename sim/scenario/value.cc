#include "sim/scenario/value.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <numbers>

#include "sim/estimators/estimator.h"
#include "sim/files/text.h"

namespace sim::scenario {
namespace {

/// Returns "'0.1 m'": the input, shortened, for a message.
std::string as_written(const Yaml& node) {
  if (node.kind == Yaml::Kind::empty) return "empty";
  if (node.is_list()) return "a list";
  if (node.is_map()) return "a section";
  const std::string text = node.text.size() > 40 ? fmt::format("{:.37}...", node.text) : node.text;
  return node.quoted ? fmt::format("the text \"{}\"", text) : fmt::format("'{}'", text);
}

[[noreturn]] void reject(const Yaml& node, std::string_view key, const std::string& expectation) {
  fail(node, key, "is {}, expected {}", as_written(node), expectation);
}

/// Returns a plain scalar as a number, or nothing.
template <class Number>
std::optional<Number> number(const Yaml& node) {
  if (!node.is_scalar() || node.quoted) return std::nullopt;
  return files::parse_number<Number>(node.text);
}

template <class Number>
void read_number(const Yaml& node, std::string_view key, const Domain& domain, Number& value) {
  const std::optional<Number> found = number<Number>(node);
  const double as_double = found ? double(*found) : std::nan("");
  const bool inside = as_double >= domain.lowest && as_double <= domain.highest && std::isfinite(as_double);
  if (!inside) reject(node, key, expected(domain, value));
  value = *found;
}

std::string range(const Domain& domain) {
  if (domain.highest >= std::numeric_limits<double>::max()) return "";
  return fmt::format(" from {} to {}", domain.lowest, domain.highest);
}

bool is_word(const Yaml& node) { return node.is_scalar() && !node.text.empty(); }

using programs::Choice, programs::Source;
using std::string_view_literals::operator""sv;

constexpr std::array kFields{"program"sv,        "command"sv,         "name"sv, "options"sv,
                             "start_within_s"sv, "answer_within_s"sv, "time"sv};
constexpr Domain kLimit{0.001, 1e6};
constexpr std::size_t kMostOptions = 1000;

/// Names of built-in controllers (for walk.controller) or estimators.
struct Role {
  explicit Role(const Domain& domain)
      : noun(domain.choices.empty() ? "estimator" : "controller"),
        names{0, 0, domain.choices.empty() ? estimators::estimator_names() : domain.choices},
        example(domain.choices.empty() ? "./my_slam" : "./my_walk") {}
  bool is_built_in(std::string_view name) const { return std::ranges::count(names.choices, name) > 0; }
  bool may_be_command() const { return noun == "estimator"; }
  std::string_view noun;
  Domain names;
  std::string_view example;
};

std::string word(const Yaml& node, const std::string& key) {
  if (!node.is_scalar() || node.text.empty() || node.text.find('\0') != node.text.npos)
    fail(node, key, "expected a non-empty word");
  return node.text;
}

std::vector<std::string> words(const Yaml& node, const std::string& key, const Role& role) {
  if (node.is_scalar()) return {word(node, key)};
  if (!node.is_list() || node.items.empty())
    fail(node, key, "expected the program and its arguments, as in [{}, --stdio]", role.example);
  std::vector<std::string> all;
  for (const Yaml& item : node.items) all.push_back(word(item, key));
  return all;
}

/// Nested sections become dotted keys.
void read_options(const Yaml& node, const std::string& key, const std::string& section, Choice& choice) {
  if (!node.is_map()) fail(node, key, "expected keys and values, as in {threads: 2}");
  for (const auto& [at, value] : node.entries()) {
    const std::string name = section + at.text;
    if (value.is_map()) {
      read_options(value, key, name + ".", choice);
      continue;
    }
    if (!value.is_scalar() || name.empty() || name.find_first_of("=\n") != name.npos ||
        value.text.find_first_of(std::string_view("\n\0", 2)) != value.text.npos)
      fail(at, key, "'{}': expected a name without '=' and a value on one line", name);
    for (const auto& [earlier, unused] : choice.options)
      if (earlier == name) fail(at, key, "'{}' is given twice", name);
    choice.options.emplace_back(name, value.text);
    if (choice.options.size() > kMostOptions) fail(node, key, "more than {} options", kMostOptions);
  }
}

/// Returns the name of the program's or command's file, changed if it is also a built-in name.
std::string standard_name(const Choice& choice, const Role& role) {
  std::string name = programs::program_name(command_words(choice));
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-') c = '_';
  if (name.empty()) name = role.noun;
  return role.is_built_in(name) ? name + "_external" : name.substr(0, 100);
}

void read_field(const Yaml& at, const std::string& key, const Yaml& value, const Role& role, Choice& choice) {
  const std::string& field = at.text;
  const std::string path = key + "." + field;
  if (field == "program" || (field == "command" && role.may_be_command())) {
    if (!choice.words.empty()) fail(at, path, "names a program and a command, expected only one");
    choice.source = field == "program" ? Source::program : Source::command;
    choice.words = field == "program" ? words(value, path, role) : std::vector{word(value, path)};
  } else if (field == "name") {
    read(value, path, {}, choice.name);
  } else if (field == "options") {
    read_options(value, path, "", choice);
  } else if (field == "start_within_s" || field == "answer_within_s") {
    read(value, path, kLimit, field == "start_within_s" ? choice.start_within_s : choice.answer_within_s);
  } else {
    std::vector<std::string_view> known(kFields.begin(), kFields.end());
    if (!role.may_be_command()) std::erase(known, "command");
    fail(at, path, "unknown, expected one of {}{}", fmt::join(known, ", "), did_you_mean(field, known));
  }
}

Choice read_section(const Yaml& node, const std::string& key, const Role& role) {
  Choice choice;
  choice.name.clear();
  for (const auto& [field, value] : node.entries()) read_field(field, key, value, role, choice);
  if (choice.words.empty())
    fail(node, key, "expected a program, as in {{program: [{}, --stdio]}}", role.example);
  if (choice.name.empty()) choice.name = standard_name(choice, role);
  if (role.is_built_in(choice.name))
    fail(node, key + ".name", "{} is a built-in {}, expected another name", choice.name, role.noun);
  return choice;
}

bool is_name(const Yaml& node) {
  const auto allowed = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.';
  };
  return is_word(node) && std::ranges::all_of(node.text, allowed) && !node.text.starts_with('.') &&
         node.text.size() <= 100;
}

}  // namespace

std::string expected(const Domain& domain, const double&) { return "a number" + range(domain); }
std::string expected(const Domain& domain, const int&) { return "a whole number" + range(domain); }
std::string expected(const Domain&, const std::uint64_t&) {
  return "a whole number from 0 to 18446744073709551615";
}
std::string expected(const Domain&, const bool&) { return "true or false"; }
std::string expected(const Domain& domain, const std::string&) {
  if (!domain.choices.empty()) return expected_choice(domain);
  return "a name of letters, digits, '_', '-' and '.'";
}
std::string expected(const Domain& domain, const physics::NameOrPath&) {
  return expected(domain, std::string()) + ", or a path with a slash";
}
std::string expected(const Domain&, const fs::path&) { return "the path of a file, or ''"; }
std::string expected(const Domain& domain, const std::vector<std::string>&) {
  if (domain.choices.empty()) return "a list of texts";
  return fmt::format("a list of {}", fmt::join(domain.choices, ", "));
}
std::string expected(const Domain& domain, const Eigen::Vector3d&) {
  return fmt::format("a list of three numbers{}", range(domain));
}
std::string expected(const Domain& domain, const std::vector<Eigen::Vector3d>&) {
  return fmt::format("a list of points, each three numbers{}, as in [[6.4, 0.5, 1.2]]", range(domain));
}
std::string expected_choice(const Domain& domain) {
  return fmt::format("one of {}", fmt::join(domain.choices, ", "));
}

void read(const Yaml& node, std::string_view key, const Domain& domain, double& value) {
  read_number(node, key, domain, value);
}
void read(const Yaml& node, std::string_view key, const Domain& domain, int& value) {
  read_number(node, key, domain, value);
}
void read(const Yaml& node, std::string_view key, const Domain& domain, std::uint64_t& value) {
  const std::optional<std::uint64_t> found = number<std::uint64_t>(node);
  if (!found) reject(node, key, expected(domain, value));
  value = *found;
}
void read(const Yaml& node, std::string_view key, const Domain& domain, bool& value) {
  const bool plain = node.is_scalar() && !node.quoted;
  if (!plain || (node.text != "true" && node.text != "false")) reject(node, key, expected(domain, value));
  value = node.text == "true";
}
void read(const Yaml& node, std::string_view key, const Domain& domain, std::string& value) {
  if (!domain.choices.empty()) {
    value = domain.choices[read_choice(node, key, domain)];
    return;
  }
  // A model's parts may have any names; other names become file names.
  const bool is_part = key.ends_with("link") || key.ends_with("body") || key == "base";
  if (is_part ? !is_word(node) || files::one_line(node.text) != node.text : !is_name(node))
    reject(node, key, expected(domain, value));
  value = node.text;
}
void read(const Yaml& node, std::string_view key, const Domain& domain, physics::NameOrPath& value) {
  const bool is_path =
      is_word(node) && physics::NameOrPath(node.text).is_path() && files::one_line(node.text) == node.text;
  if (!is_path && !is_name(node)) reject(node, key, expected(domain, value));
  value = node.text;
}
void read(const Yaml& node, std::string_view key, const Domain& domain, fs::path& value) {
  if (!node.is_scalar() || files::one_line(node.text) != node.text)
    reject(node, key, expected(domain, value));
  value = node.text;
}
void read(const Yaml& node, std::string_view key, const Domain& domain, std::vector<std::string>& value) {
  if (domain.choices.empty()) return void(value = files::read_texts(node, key, "[left_toe, left_heel]"));
  if (!node.is_list() || node.items.empty()) reject(node, key, expected(domain, value));
  std::vector<std::string> words;
  for (const Yaml& item : node.items) {
    words.emplace_back(domain.choices[read_choice(item, key, domain)]);
    if (std::ranges::count(words, words.back()) > 1) fail(item, key, "'{}' is given twice", words.back());
  }
  value = std::move(words);
}
void read(const Yaml& node, std::string_view key, const Domain& domain, Eigen::Vector3d& value) {
  if (!node.is_list() || node.items.size() != 3) reject(node, key, expected(domain, value));
  for (int i = 0; i < 3; ++i) read_number(node.items[std::size_t(i)], key, domain, value[i]);
}
void read(const Yaml& node, std::string_view key, const Domain& domain, std::vector<Eigen::Vector3d>& value) {
  if (!node.is_list()) reject(node, key, expected(domain, value));
  std::vector<Eigen::Vector3d> points(node.items.size());
  for (std::size_t i = 0; i < points.size(); ++i) read(node.items[i], key, domain, points[i]);
  value = std::move(points);
}

std::size_t read_choice(const Yaml& node, std::string_view key, const Domain& domain) {
  if (!is_word(node)) reject(node, key, expected_choice(domain));
  const auto found = std::ranges::find(domain.choices, node.text);
  if (found == domain.choices.end())
    reject(node, key, expected_choice(domain) + did_you_mean(node.text, domain.choices));
  return std::size_t(found - domain.choices.begin());
}

std::string print(const Domain&, const std::string& value) { return quote_if_needed(value); }
std::string print(const Domain&, const fs::path& value) { return quote_if_needed(value.string()); }
std::string print(const Domain& domain, std::vector<std::string> value) {
  if (domain.choices.empty())
    for (std::string& text : value) text = quote_if_needed(text);
  return fmt::format("[{}]", fmt::join(value, ", "));
}
std::string print(const Domain&, const Eigen::Vector3d& value) {
  return fmt::format("[{}, {}, {}]", value.x(), value.y(), value.z());
}
std::string print(const Domain& domain, const std::vector<Eigen::Vector3d>& value) {
  std::vector<std::string> points;
  for (const Eigen::Vector3d& point : value) points.push_back(print(domain, point));
  return fmt::format("[{}]", fmt::join(points, ", "));
}

double to_radians(double degrees) { return degrees / 180 * std::numbers::pi; }

double to_degrees(double radians) {
  const double near = radians / std::numbers::pi * 180, typed = std::stod(fmt::format("{:.15g}", near));
  if (to_radians(typed) == radians) return typed;
  double below = near, above = near;
  for (int i = 0; i < 4; ++i) {
    if (to_radians(below) == radians) return below;
    if (to_radians(above) == radians) return above;
    below = std::nextafter(below, -std::numeric_limits<double>::infinity());
    above = std::nextafter(above, std::numeric_limits<double>::infinity());
  }
  return near;
}

const ValueType kDegrees{[](const Domain& domain) { return expected(domain, 0.0); },
                         [](const Yaml& node, std::string_view key, const Domain& domain, void* value) {
                           double angle = 0;
                           read(node, key, domain, angle);
                           *static_cast<double*>(value) = to_radians(angle);
                         },
                         [](const Domain& domain, const void* value) {
                           return print(domain, to_degrees(*static_cast<const double*>(value)));
                         }};

std::string expected(const Domain& domain, const Choice&) {
  const Role role(domain);
  return fmt::format("a built-in {} ({}) or {{program: [FILE, ARGUMENT...], options: {{...}}}}", role.noun,
                     fmt::join(role.names.choices, ", "));
}

void read(const Yaml& node, std::string_view key, const Domain& domain, Choice& choice) {
  const Role role(domain);
  if (node.is_map()) {
    choice = read_section(node, std::string(key), role);
    return;
  }
  if (node.is_scalar() && !role.is_built_in(node.text)) {
    const bool is_file = node.text.find_first_of("/.") != node.text.npos;
    fail(node, key, "is '{}', expected a built-in {} ({}) or {{program: {}}}{}", node.text, role.noun,
         fmt::join(role.names.choices, ", "), is_file ? node.text : "[FILE, ARGUMENT...]",
         did_you_mean(node.text, role.names.choices));
  }
  Choice found;
  found.name = role.names.choices[read_choice(node, key, role.names)];
  choice = found;
}

std::string print(const Domain&, const Choice& choice) {
  if (choice.source == Source::built_in) return choice.name;
  std::vector<std::string> words, options;
  for (const std::string& word : choice.words) words.push_back(quote_if_needed(word));
  for (const auto& [name, value] : choice.options)
    options.push_back(fmt::format("{}: {}", quote_if_needed(name), quote_if_needed(value)));
  const bool program = choice.source == Source::program;
  std::string text = program ? fmt::format("{{program: [{}]", fmt::join(words, ", "))
                             : fmt::format("{{command: {}", words.front());
  text += ", name: " + quote_if_needed(choice.name);
  if (!options.empty()) text += fmt::format(", options: {{{}}}", fmt::join(options, ", "));
  if (program)
    text += fmt::format(", start_within_s: {}, answer_within_s: {}", choice.start_within_s,
                        choice.answer_within_s);
  return text + "}";
}

}  // namespace sim::scenario
