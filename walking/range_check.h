// Checks options against the ranges that stand beside them.
#pragma once

#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace walking {

/// A visitor of `keys` that throws std::invalid_argument at the first number out of its range, naming it.
template <class Options>
class RangeCheck {
 public:
  /// name: of the options in messages, such as "walk".
  RangeCheck(const Options& options, std::string name) : options_(options), name_(std::move(name)) {}

  void number(const char* key, auto member, double lowest, double highest, const char*) const {
    check(key, options_.*member, lowest, highest);
  }
  void degrees(const char* key, auto member, double lowest, double highest, const char*) const {
    check(key, options_.*member, lowest / 180 * std::numbers::pi, highest / 180 * std::numbers::pi, " rad");
  }
  void choice(const auto&...) const {}
  void value(const auto&...) const {}
  template <class Part>
  void part(const char* key, Part Options::*member) const {
    Part::keys(RangeCheck<Part>(options_.*member, name_ + "." + key));
  }

 private:
  void check(const char* key, double value, double lowest, double highest, const char* unit = "") const {
    if (!(value >= lowest && value <= highest))
      throw std::invalid_argument(name_ + "." + key + ": " + std::to_string(value) + " is not between " +
                                  std::to_string(lowest) + " and " + std::to_string(highest) + unit);
  }

  const Options& options_;
  std::string name_;
};

/// Throws std::invalid_argument when a number of the options is out of its range.
template <class Options>
void check_ranges(const Options& options, const std::string& name) {
  Options::keys(RangeCheck<Options>(options, name));
}

}  // namespace walking
