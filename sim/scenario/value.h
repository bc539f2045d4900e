// Values in YAML: numbers, switches, words and lists, read strictly and printed so that they read back the
// same.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>

#include "sim/files/yaml.h"
#include "sim/physics/options.h"
#include "sim/programs/choice.h"

namespace sim::scenario {

// The YAML reader, under the names used for scenarios.
using files::ConfigError, files::Origin, files::Yaml, files::MapReaders;
using files::did_you_mean, files::fail, files::parse_seeds, files::parse_yaml, files::parse_yaml_file,
    files::quote_if_needed, files::read_map, files::read_path, files::read_seeds, files::read_texts,
    files::require_map, files::yaml_text;

/// The valid values: a number within [lowest, highest], or one of the choices.
struct Domain {
  double lowest = 0, highest = 0;
  std::span<const std::string_view> choices{};
};

/// The description of a valid value of this type: "a number from 0 to 1", "true or false", ...
std::string expected(const Domain& domain, const double&);
std::string expected(const Domain& domain, const int&);
std::string expected(const Domain& domain, const std::uint64_t&);
std::string expected(const Domain& domain, const bool&);
std::string expected(const Domain& domain, const std::string&);
std::string expected(const Domain& domain, const physics::NameOrPath&);
std::string expected(const Domain& domain, const fs::path&);
std::string expected(const Domain& domain, const std::vector<std::string>&);
std::string expected(const Domain& domain, const Eigen::Vector3d&);
std::string expected(const Domain& domain, const std::vector<Eigen::Vector3d>&);

/// Reads a node into a value. Throws ConfigError at the node, with the key.
void read(const Yaml& node, std::string_view key, const Domain& domain, double& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, int& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, std::uint64_t& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, bool& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, std::string& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, physics::NameOrPath& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, fs::path& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, std::vector<std::string>& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, Eigen::Vector3d& value);
void read(const Yaml& node, std::string_view key, const Domain& domain, std::vector<Eigen::Vector3d>& value);

/// Prints a value as YAML on one line; read() gives the same value bit for bit.
template <class T>
requires std::is_arithmetic_v<T> std::string print(const Domain&, T value) {
  return fmt::format("{}", value);
}
std::string print(const Domain& domain, const std::string& value);
std::string print(const Domain& domain, const fs::path& value);
std::string print(const Domain& domain, std::vector<std::string> value);
std::string print(const Domain& domain, const Eigen::Vector3d& value);
std::string print(const Domain& domain, const std::vector<Eigen::Vector3d>& value);

/// A built-in estimator or controller, or an external program.
std::string expected(const Domain& domain, const programs::Choice&);
void read(const Yaml& node, std::string_view key, const Domain& domain, programs::Choice& choice);
std::string print(const Domain& domain, const programs::Choice& choice);

/// Returns the index of a word among the domain's choices. Throws ConfigError.
std::size_t read_choice(const Yaml& node, std::string_view key, const Domain& domain);
/// Returns "one of a, b".
std::string expected_choice(const Domain& domain);

template <class T>
concept Enumeration = std::is_enum_v<T>;

template <Enumeration E>
std::string expected(const Domain& domain, const E&) {
  return expected_choice(domain);
}
template <Enumeration E>
void read(const Yaml& node, std::string_view key, const Domain& domain, E& value) {
  value = static_cast<E>(read_choice(node, key, domain));
}
template <Enumeration E>
std::string print(const Domain& domain, E value) {
  return std::string(domain.choices[std::size_t(value)]);
}

/// The operations on values of one type.
struct ValueType {
  std::string (*expected)(const Domain&);
  void (*read)(const Yaml&, std::string_view key, const Domain&, void* value);
  std::string (*print)(const Domain&, const void* value);
};
template <class T>
inline constexpr ValueType kValueType{
    [](const Domain& domain) { return expected(domain, T{}); },
    [](const Yaml& node, std::string_view key, const Domain& domain, void* value) {
      read(node, key, domain, *static_cast<T*>(value));
    },
    [](const Domain& domain, const void* value) { return print(domain, *static_cast<const T*>(value)); }};
/// An angle: degrees in the file, radians in the member.
extern const ValueType kDegrees;

/// Converts degrees to radians, and back to degrees that give exactly these radians if such degrees exist.
double to_radians(double degrees);
double to_degrees(double radians);

}  // namespace sim::scenario
