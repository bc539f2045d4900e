// The one table of keys: reading, overrides, help, printing, sweeps and tuning all go through it.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_value.h"

namespace sim::bench {

/// One thing that can be set in an Owner. A new key is one line in scenario_keys.cc; its default is the
/// member's initializer, its unit is in its name.
template <class Owner>
struct Key {
  std::string name;                                ///< dotted: "walk.step_length_m"
  std::string expected;                            ///< "a number from 0.01 to 0.5"
  std::string doc;                                 ///< one line
  std::function<void(const Yaml&, Owner&)> read;   ///< throws ConfigError
  std::function<std::string(const Owner&)> print;  ///< as YAML; lists may break lines
};

/// A key of an Owner whose member `access` reaches. The type of the member decides how it is read and
/// printed.
template <class Owner, class Access>
Key<Owner> make_key(const std::string& name, Access access, const Domain& domain, const std::string& doc,
                    const Owner& any = {}) {
  return {name, expected(domain, access(any)), doc,
          [=](const Yaml& node, Owner& owner) { read(node, name, domain, access(owner)); },
          [=](const Owner& owner) { return print(domain, access(owner)); }};
}

/// All keys but limits.<metric>, sections together, in the order of help and of to_yaml.
const std::vector<Key<Scenario>>& scenario_keys();

/// The key of that name, or nullptr.
const Key<Scenario>* find_key(std::string_view name);

/// The default scenario with every optional section present: where defaults are read from.
const Scenario& default_scenario();

/// True when the scenario has the section ("camera") that the key belongs to.
bool has_section(const Scenario& scenario, std::string_view key);

/// The unit that a key's name ends in: "walk.step_length_m" -> "m", "gyro.sigma_rad_s" -> "rad/s"; "" for
/// none.
std::string_view unit_of(std::string_view key);

}  // namespace sim::bench
