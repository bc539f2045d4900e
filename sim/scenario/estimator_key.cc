#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "sim/estimators/estimator.h"
#include "sim/scenario/value.h"

namespace sim::scenario {
namespace {

using estimators::EstimatorChoice;
using estimators::Source;
using std::string_view_literals::operator""sv;

constexpr std::array kFields{"program"sv, "command"sv,        "name"sv,
                             "options"sv, "start_within_s"sv, "answer_within_s"sv};
constexpr Domain kLimit{0.001, 1e6};
constexpr std::size_t kMostOptions = 1000;

const Domain& named() {
  static const Domain domain{0, 0, estimators::estimator_names()};
  return domain;
}

/// A scalar's text. Throws ConfigError.
std::string word(const Yaml& node, const std::string& key) {
  if (node.kind != Yaml::Kind::scalar || node.text.empty() || node.text.find('\0') != node.text.npos)
    fail(node, key, "expected a non-empty word");
  return node.text;
}

std::vector<std::string> words(const Yaml& node, const std::string& key) {
  if (node.kind == Yaml::Kind::scalar) return {word(node, key)};
  if (node.kind != Yaml::Kind::list || node.items.empty())
    fail(node, key, "expected the program and its arguments, as in [./my_slam, --stdio]");
  std::vector<std::string> all;
  for (const Yaml& item : node.items) all.push_back(word(item, key));
  return all;
}

/// Nested sections become dotted keys.
void read_options(const Yaml& node, const std::string& key, const std::string& section,
                  EstimatorChoice& choice) {
  if (node.kind != Yaml::Kind::map) fail(node, key, "expected keys and values, as in {threads: 2}");
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const std::string name = section + node.keys[i].text;
    const Yaml& value = node.items[i];
    if (value.kind == Yaml::Kind::map) {
      read_options(value, key, name + ".", choice);
      continue;
    }
    if (value.kind != Yaml::Kind::scalar || name.empty() || name.find_first_of("=\n") != name.npos ||
        value.text.find_first_of(std::string_view("\n\0", 2)) != value.text.npos)
      fail(node.keys[i], key, fmt::format("'{}': expected a name without '=' and a value on one line", name));
    for (const auto& [earlier, unused] : choice.options)
      if (earlier == name) fail(node.keys[i], key, fmt::format("'{}' is given twice", name));
    choice.options.emplace_back(name, value.text);
    if (choice.options.size() > kMostOptions)
      fail(node, key, fmt::format("more than {} options", kMostOptions));
  }
}

bool is_built_in(std::string_view name) {
  const auto& names = named().choices;
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Returns the program's or command's file without folder and extension, or unlike a built-in name.
std::string standard_name(const EstimatorChoice& choice) {
  const std::string& first = choice.words.front();
  std::string name = std::filesystem::path(first.substr(0, first.find(' '))).stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-') c = '_';
  if (name.empty()) name = "estimator";
  return is_built_in(name) ? name + "_external" : name.substr(0, 100);
}

void read_field(const Yaml& at, const std::string& key, const Yaml& value, EstimatorChoice& choice) {
  const std::string& field = at.text;
  const std::string path = key + "." + field;
  if (field == "program" || field == "command") {
    if (!choice.words.empty()) fail(at, path, "names a program and a command, expected one of them");
    choice.source = field == "program" ? Source::program : Source::command;
    choice.words = field == "program" ? words(value, path) : std::vector{word(value, path)};
  } else if (field == "name") {
    read(value, path, {}, choice.name);
  } else if (field == "options") {
    read_options(value, path, "", choice);
  } else if (field == "start_within_s" || field == "answer_within_s") {
    read(value, path, kLimit, field == "start_within_s" ? choice.start_within_s : choice.answer_within_s);
  } else if (field == "library") {
    fail(at, path,
         "was removed: compile the library as a program with -DGAITSLAM_ESTIMATOR_MAIN, and give "
         "estimator.program");
  } else {
    fail(
        at, path,
        fmt::format("unknown, expected one of {}{}", fmt::join(kFields, ", "), did_you_mean(field, kFields)));
  }
}

EstimatorChoice read_section(const Yaml& node, const std::string& key) {
  EstimatorChoice choice;
  choice.name.clear();
  for (std::size_t i = 0; i < node.keys.size(); ++i) read_field(node.keys[i], key, node.items[i], choice);
  if (choice.words.empty()) fail(node, key, "expected a program, as in {program: [./my_slam, --stdio]}");
  if (choice.name.empty()) choice.name = standard_name(choice);
  if (is_built_in(choice.name))
    fail(node, key + ".name", fmt::format("{} is a built-in estimator, expected another name", choice.name));
  return choice;
}

}  // namespace

std::string expected(const Domain&, const EstimatorChoice&) {
  return fmt::format("a built-in estimator ({}) or {{program: [FILE, ARGUMENT...], options: {{...}}}}",
                     fmt::join(named().choices, ", "));
}

void read(const Yaml& node, std::string_view key, const Domain&, EstimatorChoice& choice) {
  if (node.kind == Yaml::Kind::map) {
    choice = read_section(node, std::string(key));
    return;
  }
  if (node.kind == Yaml::Kind::scalar && node.text.find_first_of("/.") != node.text.npos)
    fail(node, key,
         fmt::format("is '{0}', expected a built-in estimator ({1}) or {{program: {0}}}", node.text,
                     fmt::join(named().choices, ", ")));
  EstimatorChoice found;
  found.name = named().choices[read_choice(node, key, named())];
  choice = found;
}

std::string print(const Domain&, const EstimatorChoice& choice) {
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
