#include "sim/bench/scenario_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <utility>

#include "sim/bench/scenario_keys.h"

namespace sim::bench {
namespace {

using walking::Command;

constexpr Domain kLength{-1000, 1000}, kDuration{0, 3600}, kRadius{0.05, 1000}, kStep{-1, 1},
    kAngle{-36000, 36000};

/// A key in degrees for a member in radians.
template <class Owner, class Access>
Key<Owner> make_angle_key(const std::string& name, Access access, const std::string& doc) {
  return {name, expected(kAngle, 0.0), doc,
          [=](const Yaml& node, Owner& owner) {
            double degrees = 0;
            read(node, name, kAngle, degrees);
            access(owner) = to_radians(degrees);
          },
          [=](const Owner& owner) { return print(kAngle, to_degrees(access(owner))); }};
}

#define GAITSLAM_FIELD(member) \
#member, [](auto&& command) -> auto& { return command.member; }

/// A kind of command: its word in the file and its fields.
template <class Kind>
struct Grammar {
  std::string_view word;
  std::vector<Key<Kind>> fields;
};

const Grammar<walking::Stand>& grammar(const walking::Stand&) {
  using Kind = walking::Stand;
  static const Grammar<Kind> g{"stand",
                               {make_key<Kind>(GAITSLAM_FIELD(duration_s), kDuration, "time on both feet")}};
  return g;
}
const Grammar<walking::Straight>& grammar(const walking::Straight&) {
  using Kind = walking::Straight;
  static const Grammar<Kind> g{
      "straight",
      {make_key<Kind>(GAITSLAM_FIELD(forward_m), kLength, "ahead, in the robot's frame at the start"),
       make_key<Kind>(GAITSLAM_FIELD(left_m), kLength, "to the left; negative: to the right")}};
  return g;
}
template <class Kind>
Grammar<Kind> arc_grammar(std::string_view word) {
  return {word,
          {make_key<Kind>(GAITSLAM_FIELD(radius_m), kRadius, "of the circle"),
           make_angle_key<Kind>(
               "angle_deg", [](auto&& command) -> auto& { return command.angle_rad; },
               "positive: the robot turns left")}};
}
const Grammar<walking::TangentArc>& grammar(const walking::TangentArc&) {
  static const auto g = arc_grammar<walking::TangentArc>("tangent_arc");
  return g;
}
const Grammar<walking::PerpendicularArc>& grammar(const walking::PerpendicularArc&) {
  static const auto g = arc_grammar<walking::PerpendicularArc>("perpendicular_arc");
  return g;
}

const Grammar<walking::Step>& grammar(const walking::Step&) {
  using Kind = walking::Step;
  static const Grammar<Kind> g{
      "steps",
      {make_key<Kind>(GAITSLAM_FIELD(forward_m), kStep,
                      "of each landing: ahead, seen from the standing foot"),
       make_key<Kind>(GAITSLAM_FIELD(left_m), kStep, "to the left of it: the left foot; negative: the right"),
       make_angle_key<Kind>(
           "turn_deg", [](auto&& step) -> auto& { return step.turn_rad; },
           "by which that foot's frame is turned first")}};
  return g;
}
/// Steps are a list of what this says.
const Grammar<walking::Step>& grammar(const walking::Steps&) { return grammar(walking::Step{}); }

/// Calls f(Kind{}) for each kind of command.
template <class F>
void for_each_kind(const F& f) {
  [&]<std::size_t... i>(std::index_sequence<i...>) { (f(std::variant_alternative_t<i, Command>{}), ...); }
  (std::make_index_sequence<std::variant_size_v<Command>>{});
}

std::vector<std::string_view> words() {
  std::vector<std::string_view> all;
  for_each_kind([&](const auto& kind) { all.push_back(grammar(kind).word); });
  return all;
}

template <class Kind>
void read_field(const Yaml& name, const Yaml& value, const std::string& where, Kind& command) {
  std::vector<std::string_view> known;
  for (const Key<Kind>& field : grammar(command).fields) {
    if (field.name == name.text) return field.read(value, command);
    known.push_back(field.name);
  }
  fail(name, where,
       fmt::format("unknown field '{}', expected {}{}", name.text, fmt::join(known, ", "),
                   did_you_mean(name.text, known)));
}

template <class Kind>
void read_fields(const Yaml& node, const std::string& where, Kind& command) {
  if (node.kind != Yaml::Kind::map) fail(node, where, "expected fields in braces, as in {duration_s: 1}");
  for (std::size_t i = 0; i < node.keys.size(); ++i) read_field(node.keys[i], node.items[i], where, command);
}

void read_fields(const Yaml& node, const std::string& where, walking::Steps& steps) {
  if (node.kind != Yaml::Kind::list || node.items.empty()) {
    fail(node, where, "expected a list of steps, as in [{forward_m: 0.1, left_m: -0.19}]");
  }
  for (const Yaml& item : node.items) read_fields(item, where, steps.list.emplace_back());
}

Command read_command(const Yaml& node, std::string_view key) {
  if (node.kind != Yaml::Kind::map || node.keys.size() != 1) {
    fail(node, key,
         fmt::format("expected a list of commands, each one of {}, as in - stand: {{duration_s: 1}}",
                     fmt::join(words(), ", ")));
  }
  const Yaml& word = node.keys[0];
  std::optional<Command> command;
  for_each_kind([&](const auto& kind) {
    if (grammar(kind).word != word.text) return;
    auto read = kind;
    read_fields(node.items[0], fmt::format("{}: {}", key, word.text), read);
    command = read;
  });
  if (!command) {
    fail(word, key,
         fmt::format("unknown command '{}', expected one of {}{}", word.text, fmt::join(words(), ", "),
                     did_you_mean(word.text, words())));
  }
  return *command;
}

template <class Kind>
std::string print_fields(const Kind& command) {
  std::vector<std::string> fields;
  for (const auto& field : grammar(command).fields) {
    fields.push_back(fmt::format("{}: {}", field.name, field.print(command)));
  }
  return fmt::format("{{{}}}", fmt::join(fields, ", "));
}

std::string print_fields(const walking::Steps& steps) {
  std::vector<std::string> list;
  for (const walking::Step& step : steps.list) list.push_back(print_fields(step));
  return fmt::format("[{}]", fmt::join(list, ", "));
}

std::string print_command(const Command& command) {
  return std::visit(
      [](const auto& kind) { return fmt::format("{{{}: {}}}", grammar(kind).word, print_fields(kind)); },
      command);
}

template <class Kind>
std::string describe(const Grammar<Kind>& grammar) {
  std::string text;
  for (const auto& field : grammar.fields) {
    text += fmt::format("  {:18} {:10} {}, {}; default {}\n", grammar.word, field.name, field.doc,
                        field.expected, field.print(Kind{}));
  }
  return text;
}

}  // namespace

void read_commands(const Yaml& node, std::string_view key, std::vector<Command>& commands) {
  if (node.kind != Yaml::Kind::list || node.items.empty()) {
    fail(node, key, "expected a list of commands, as in [{stand: {duration_s: 1}}]");
  }
  std::vector<Command> all;
  for (const Yaml& item : node.items) all.push_back(read_command(item, key));
  commands = std::move(all);
}

std::string print_commands(const std::vector<Command>& commands) {
  std::vector<std::string> lines;
  for (const Command& command : commands) lines.push_back(print_command(command));
  return fmt::format("[\n    {}]", fmt::join(lines, ",\n    "));
}

std::string describe_commands() {
  std::string text;
  for_each_kind([&](const auto& kind) { text += describe(grammar(kind)); });
  return text;
}

}  // namespace sim::bench
