#include "sim/tune/task.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/result/score_input.h"

namespace sim::tune {
namespace {

using nlohmann::json;

/// The objective terms that are not metrics, by name.
std::map<std::string, double> terms_by_name(const Terms& terms) {
  return {{"pose_nll", terms.pose_nll},
          {"innovation_nll", terms.innovation_nll},
          {"consistency", terms.consistency},
          {"nis_consistency", terms.nis_consistency}};
}

score::Metrics of_walk_alone(const Recording& recording, const scenario::ReadScenario& scenario) {
  const result::RunRecord record{scenario,     {recording.walk_ending}, recording.setup, recording.truth,
                                 std::nullopt, recording.hash};
  return score::evaluate(result::score_input(record));
}

}  // namespace

void write_tasks(const std::filesystem::path& file, const TaskFile& tasks) {
  std::string text = tasks.purpose + "\n";
  for (const Task& task : tasks.tasks)
    text +=
        json{{"key", task.key}, {"scenario", task.scenario}, {"recording", task.recording.string()}}.dump() +
        "\n";
  files::write_atomically(file, text);
}

TaskFile read_tasks(const std::filesystem::path& file) {
  std::istringstream in(files::read_text(file));
  TaskFile tasks;
  if (!std::getline(in, tasks.purpose)) throw files::FileError(file, "cannot be read");
  for (std::string line; std::getline(in, line);) {
    const files::Json task(fmt::format("{}:{}", file.string(), tasks.tasks.size() + 2), line);
    tasks.tasks.push_back({task.at("key").text(), task.at("scenario").text(), task.at("recording").text()});
  }
  return tasks;
}

std::vector<std::string> value_names() {
  std::vector<std::string> names;
  for (const auto& metric : score::metric_definitions()) names.emplace_back(metric.name);
  for (const auto& [name, value] : terms_by_name({})) names.push_back(name);
  return names;
}

TrialRecord run_task(const std::string& key, const scenario::ReadScenario& scenario,
                     const Recording& recording, const replay::WalkEnd& walk) {
  TrialRecord record{
      key, scenario.scenario.seed, std::string(name_of(walk.ended.ending)), walk.ended.cause, {}};
  if (walk.ended.ending == scenario::Ending::failed) return record;
  Trial trial{walk.ended, {}, {}, 1};
  if (scenario.scenario.slam)
    trial = run_trial(recording, scenario);
  else
    trial.metrics = of_walk_alone(recording, scenario);
  if (trial.ended.ending != walk.ended.ending)
    record.ending = name_of(trial.ended.ending), record.cause = trial.ended.cause;
  for (const auto& [name, metric] : trial.metrics)
    if (metric.value) record.values[name] = *metric.value;
  if (scenario.scenario.slam) record.values["lasted_fraction"] = trial.lasted_fraction;
  if (trial.terms) record.values.merge(terms_by_name(*trial.terms));
  return record;
}

}  // namespace sim::tune
