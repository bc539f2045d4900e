#include "walking/plan_cause.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "walking/keys.h"

namespace walking {
namespace {

constexpr const char* kNoSingleKey = "no single key is the cause";

/// A key, its value and another value for it, both in the unit of the key's name.
struct Exchange {
  std::string key;
  double now = 0, instead = 0;
  WalkOptions changed;
};

/// A visitor of `keys` that exchanges each number of a part of the options for that of another such part.
/// part(options): the part in a copy of the options.
template <class Part, class Access>
class Exchanger : public KeyVisitor {
 public:
  Exchanger(const WalkOptions& options, std::string prefix, const Part& other, Access part,
            std::vector<Exchange>& all)
      : options_(options), prefix_(std::move(prefix)), other_(other), part_(part), all_(all) {}

  void number(std::string_view key, auto member, double, double, const char*) const {
    exchange(key, member, 1);
  }
  void degrees(std::string_view key, auto member, double, double, const char*) const {
    exchange(key, member, 180 / std::numbers::pi);
  }
  void choice(const auto&...) const {}
  void value(const auto&...) const {}
  void part(const auto&...) const {}

 private:
  void exchange(std::string_view, int Part::*, double) const {
  }  // of repeat: its commands were feasible before
  void exchange(std::string_view key, double Part::*member, double unit) const {
    Exchange one{prefix_ + std::string(key), 0, unit * other_.*member, options_};
    double& value = part_(one.changed).*member;
    if (value == other_.*member) return;
    one.now = unit * value;
    value = other_.*member;
    all_.push_back(std::move(one));
  }

  const WalkOptions& options_;
  std::string prefix_;
  const Part& other_;
  Access part_;
  std::vector<Exchange>& all_;
};

template <class Part, class Access>
void exchange_numbers(const WalkOptions& options, const std::string& prefix, const Part& other, Access part,
                      std::vector<Exchange>& all) {
  Part::keys(Exchanger<Part, Access>(options, prefix, other, part, all));
}

std::string name_of(int command) { return "walk.commands[" + std::to_string(command) + "]."; }

/// Returns the index of the first step that the legs cannot take, or nullopt.
std::optional<std::size_t> failing_step(WalkOptions options, const IsFeasible& is_feasible) {
  const std::vector<Step> all = std::get<Steps>(options.commands.back()).list;
  for (std::size_t n = 1; n <= all.size(); ++n) {
    std::get<Steps>(options.commands.back())
        .list.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
    if (!is_feasible(options)) return n - 1;
  }
  return std::nullopt;
}

/// Those of the first step that the legs cannot take, against a step on the spot.
std::vector<Exchange> exchanges_of_steps(WalkOptions options, const IsFeasible& is_feasible) {
  std::vector<Exchange> all;
  const auto failing = failing_step(options, is_feasible);
  if (!failing) return all;
  auto& list = std::get<Steps>(options.commands.back()).list;
  list.resize(*failing + 1);
  const Step on_the_spot{0, std::copysign(hrp2::kFootSpacing, list.back().left_m), 0};
  const auto last = [](WalkOptions& o) -> Step& { return std::get<Steps>(o.commands.back()).list.back(); };
  const int command = static_cast<int>(options.commands.size()) - 1;
  exchange_numbers(options, name_of(command) + "steps[" + std::to_string(*failing) + "].", on_the_spot, last,
                   all);
  return all;
}

std::vector<Exchange> exchanges_of_command(const WalkOptions& options, const IsFeasible& is_feasible) {
  const int command = static_cast<int>(options.commands.size()) - 1;
  const auto visit = [&]<class Kind>(const Kind&) -> std::vector<Exchange> {
    std::vector<Exchange> all;
    if constexpr (std::is_same_v<Kind, Steps>) {
      all = exchanges_of_steps(options, is_feasible);
    } else {
      const auto part = [](WalkOptions& o) -> Kind& { return std::get<Kind>(o.commands.back()); };
      exchange_numbers(options, name_of(command) + Kind::kName + ".", Kind{}, part, all);
    }
    return all;
  };
  return std::visit(visit, options.commands.back());
}

std::optional<std::string> first_cause(const std::vector<Exchange>& exchanges,
                                       const IsFeasible& is_feasible) {
  for (const Exchange& one : exchanges) {
    if (!is_feasible(one.changed)) continue;
    std::ostringstream text;
    text << "the cause is " << one.key << " " << one.now << ", with " << one.instead
         << " the legs can follow";
    return text.str();
  }
  return std::nullopt;
}

}  // namespace

std::string cause_of_infeasible(const WalkOptions& options, int command, const IsFeasible& is_feasible) {
  WalkOptions up_to_command = options;
  up_to_command.commands.resize(static_cast<std::size_t>(command) + 1);
  std::vector<Exchange> of_walk;
  exchange_numbers(
      up_to_command, "walk.", WalkOptions{}, [](WalkOptions& o) -> WalkOptions& { return o; }, of_walk);
  if (is_feasible(up_to_command)) return kNoSingleKey;  // it takes the next command, too
  if (const auto cause = first_cause(of_walk, is_feasible)) return *cause;
  const auto of_command = exchanges_of_command(up_to_command, is_feasible);
  return first_cause(of_command, is_feasible).value_or(kNoSingleKey);
}

}  // namespace walking
