#include <fmt/format.h>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_keys.h"
#include "sim/bench/scenario_limits.h"

namespace sim::bench {
namespace {

/// Writes "a: \n  b: value" for "a.b", repeating only the sections that change from key to key.
class YamlWriter {
 public:
  void write(std::string_view path, const std::string& value) {
    const std::vector<std::string_view> parts = split(path);
    std::size_t same = 0;
    while (same + 1 < parts.size() && same < open_.size() && open_[same] == parts[same]) ++same;
    open_.assign(parts.begin(), parts.end() - 1);
    for (std::size_t i = same; i + 1 < parts.size(); ++i)
      text += fmt::format("{:{}}{}:\n", "", 2 * i, parts[i]);
    text += fmt::format("{:{}}{}: {}\n", "", 2 * (parts.size() - 1), parts.back(), value);
  }
  std::string text;

 private:
  static std::vector<std::string_view> split(std::string_view path) {
    std::vector<std::string_view> parts;
    for (std::size_t dot; (dot = path.find('.')) != std::string_view::npos; path.remove_prefix(dot + 1)) {
      parts.push_back(path.substr(0, dot));
    }
    parts.push_back(path);
    return parts;
  }
  std::vector<std::string_view> open_;
};

}  // namespace

std::string to_yaml(const Scenario& scenario) {
  YamlWriter yaml;
  for (const auto& key : scenario_keys()) {
    if (has_section(scenario, key.name)) yaml.write(key.name, key.print(scenario));
  }
  return yaml.text + print_limits(scenario.limits.metrics);
}

}  // namespace sim::bench
