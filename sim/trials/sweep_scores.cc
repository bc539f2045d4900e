#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text_table.h"
#include "sim/score/statistics.h"
#include "sim/trials/sweep.h"
#include "sim/trials/task.h"

namespace sim::trials {
namespace {

using nlohmann::ordered_json;
using std::string_view_literals::operator""sv;

constexpr std::size_t kMostRows = 40;
constexpr std::array kShown{"ate_se3_rmse_m"sv, "rmse_m"sv, "nees_position_mean"sv, "nees_orientation_mean"sv,
                            "loop_landmarks"sv};

ordered_json value_of(const std::string& printed) {
  const ordered_json value = ordered_json::parse(printed, nullptr, false);
  return value.is_number() || value.is_boolean() ? value : ordered_json(printed);
}

const Configuration& configuration(const SweepPlan& plan, std::size_t trial) {
  return plan.configurations[trial / plan.seeds.size()];
}

/// "0.0123", or "-" if no seed has the value.
std::string median(const SweepPlan& plan, const RecordOf& record, std::size_t first, std::string_view name) {
  std::vector<double> values;
  for (std::size_t i = first; i < first + plan.seeds.size(); ++i) {
    const TrialRecord* const one = record(i);
    if (const auto value = one ? one->value(name) : std::nullopt) values.push_back(*value);
  }
  return values.empty() ? "-" : fmt::format("{:.4g}", score::median(values));
}

std::vector<std::string> row(const SweepPlan& plan, const RecordOf& record, std::size_t c) {
  const std::size_t first = c * plan.seeds.size();
  std::vector<std::string> cells{plan.configurations[c].read.scenario.name};
  cells.insert(cells.end(), plan.configurations[c].values.begin(), plan.configurations[c].values.end());
  int completed = 0;
  for (std::size_t i = first; i < first + plan.seeds.size(); ++i)
    completed += record(i) && record(i)->ending == "completed" ? 1 : 0;
  cells.push_back(fmt::format("{}/{}", completed, plan.seeds.size()));
  for (const std::string_view name : kShown) cells.push_back(median(plan, record, first, name));
  return cells;
}

}  // namespace

std::string scores_csv(const SweepPlan& plan, const RecordOf& record) {
  const std::vector<std::string> names = value_names();
  std::string text = "trial,scenario,seed";
  for (const std::string& key : plan.keys) text += "," + key;
  text += ",ending,cause";
  for (const std::string& name : names) text += "," + name;
  text += "\n";
  for (std::size_t i = 0; i < plan.trials(); ++i) {
    const TrialRecord* const one = record(i);
    if (!one) continue;
    text +=
        fmt::format("{},{},{}", i, files::csv_field(configuration(plan, i).read.scenario.name), one->seed);
    for (const std::string& value : configuration(plan, i).values) text += "," + files::csv_field(value);
    text += fmt::format(",{},{}", one->ending, files::csv_field(one->cause));
    for (const std::string& name : names) {
      const auto value = one->value(name);
      text += value ? fmt::format(",{}", *value) : ",";
    }
    text += "\n";
  }
  return text;
}

std::string scores_jsonl(const SweepPlan& plan, const RecordOf& record) {
  std::string text;
  for (std::size_t i = 0; i < plan.trials(); ++i) {
    const TrialRecord* const one = record(i);
    if (!one) continue;
    ordered_json settings = ordered_json::object();
    for (std::size_t k = 0; k < plan.keys.size(); ++k)
      settings[plan.keys[k]] = value_of(configuration(plan, i).values[k]);
    ordered_json line{
        {"trial", i}, {"scenario", configuration(plan, i).read.scenario.name}, {"settings", settings}};
    line.update(ordered_json::parse(to_line(*one)));
    text += files::json_text(line) + "\n";
  }
  return text;
}

std::string sweep_table(const SweepPlan& plan, const RecordOf& record) {
  std::vector<std::vector<std::string>> rows{{"scenario"}};
  rows[0].insert(rows[0].end(), plan.keys.begin(), plan.keys.end());
  rows[0].push_back("completed");
  for (const std::string_view name : kShown) rows[0].emplace_back(name);
  for (std::size_t c = 0; c < std::min(plan.configurations.size(), kMostRows); ++c)
    rows.push_back(row(plan, record, c));
  std::string text = files::text_table(rows, {.naming = 1 + plan.keys.size()});
  if (plan.configurations.size() > kMostRows)
    text += fmt::format("... and {} more\n", plan.configurations.size() - kMostRows);
  return plan.seeds.size() > 1 ? "medians over seeds\n" + text : text;
}

}  // namespace sim::trials
