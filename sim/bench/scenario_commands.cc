#include "sim/bench/scenario_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <utility>

#include "sim/bench/scenario_keys.h"

namespace sim::bench {
namespace {

using walking::Command;

constexpr Domain kLength{-1000, 1000}, kDuration{0, 3600}, kRadius{0.05, 1000}, kAngle{-36000, 36000};

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
Command read_fields(const Yaml& node, const std::string& where) {
  Kind command;
  if (node.kind != Yaml::Kind::map) fail(node, where, "expected fields in braces, as in {duration_s: 1}");
  for (std::size_t i = 0; i < node.keys.size(); ++i) read_field(node.keys[i], node.items[i], where, command);
  return command;
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
    command = read_fields<std::decay_t<decltype(kind)>>(node.items[0], fmt::format("{}: {}", key, word.text));
  });
  if (!command) {
    fail(word, key,
         fmt::format("unknown command '{}', expected one of {}{}", word.text, fmt::join(words(), ", "),
                     did_you_mean(word.text, words())));
  }
  return *command;
}

std::string print_command(const Command& command) {
  return std::visit(
      [](const auto& kind) {
        std::vector<std::string> fields;
        for (const auto& field : grammar(kind).fields) {
          fields.push_back(fmt::format("{}: {}", field.name, field.print(kind)));
        }
        return fmt::format("{{{}: {{{}}}}}", grammar(kind).word, fmt::join(fields, ", "));
      },
      command);
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
  for_each_kind([&](const auto& kind) {
    for (const auto& field : grammar(kind).fields) {
      text += fmt::format("  {:18} {:10} {}, {}; default {}\n", grammar(kind).word, field.name, field.doc,
                          field.expected, field.print(kind));
    }
  });
  return text;
}

}  // namespace sim::bench
