#include "sim/trials/task.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/result/score_input.h"

namespace sim::trials {
namespace {

using nlohmann::json;

/// The objective terms that are not metrics, by name.
std::map<std::string, double> terms_by_name(const Terms& terms) {
  return {{"pose_nll", terms.pose_nll}, {"innovation_nll", terms.innovation_nll}};
}

score::Metrics of_walk_alone(const Recording& recording, const scenario::ReadScenario& scenario) {
  const result::RunRecord record{scenario,     {recording.walk.ending}, recording.setup, recording.truth,
                                 std::nullopt, recording.hash};
  return score::evaluate(result::score_input(record));
}

/// Does not try a recording of a failed simulation.
TrialRecord run_on(const std::string& key, const scenario::ReadScenario& scenario,
                   const Recording& recording) {
  TrialRecord record{
      key, scenario.scenario.seed, std::string(name_of(recording.walk.ending)), recording.walk.cause, {}};
  if (recording.walk.ending == scenario::Ending::failed) return record;
  Trial trial{recording.walk, {}, {}, 1};
  if (scenario.scenario.slam)
    trial = run_trial(recording, scenario);
  else
    trial.metrics = of_walk_alone(recording, scenario);
  if (trial.ended.ending != recording.walk.ending)
    record.ending = name_of(trial.ended.ending), record.cause = trial.ended.cause;
  for (const auto& [name, metric] : trial.metrics)
    if (metric.value) record.values[name] = *metric.value;
  if (scenario.scenario.slam) record.values["lasted_fraction"] = trial.lasted_fraction;
  if (trial.terms) record.values.merge(terms_by_name(*trial.terms));
  return record;
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

std::shared_ptr<Runner::Loaded> Runner::find(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  const auto found =
      std::find_if(loaded_.begin(), loaded_.end(), [&](const auto& l) { return l->name == name; });
  if (found != loaded_.end()) {
    loaded_.splice(loaded_.begin(), loaded_, found);
    return loaded_.front();
  }
  while (!loaded_.empty() && loaded_.size() >= keep_) loaded_.pop_back();
  loaded_.push_front(std::make_shared<Loaded>());
  loaded_.front()->name = name;
  return loaded_.front();
}

// A recording is loaded with the sensor errors of the first trial that needs it. If another trial has other
// errors, it is loaded without any, and from then on each trial applies its own.
std::shared_ptr<const Recording> Runner::load(const Task& task, const scenario::ReadScenario& read) {
  const auto loaded = find(task.recording.empty() ? cache_.key(read.scenario) : task.recording.string());
  const std::scoped_lock lock(loaded->mutex);
  const auto load_from = [&](const std::filesystem::path& folder) {
    loaded->recording = std::make_shared<const Recording>(
        loaded->recording ? trials::load(folder) : trials::load(folder, read.scenario));
  };
  const Recording* const now = loaded->recording.get();
  if (!now || (!now->errors.empty() && now->errors != errors_of(read.scenario)))
    task.recording.empty() ? cache_.open(read, load_from) : load_from(task.recording);
  return loaded->recording;
}

TrialRecord Runner::run(const Task& task) {
  const scenario::ReadScenario read = scenario::read_scenario_text(task.scenario, "task.yaml");
  try {
    return run_on(task.key, read, *load(task, read));
  } catch (const files::FileError&) {
    throw;  // a fault of the machine, such as a full disk
  } catch (const std::exception& e) {
    return {task.key, read.scenario.seed, std::string(name_of(scenario::Ending::not_started)), e.what(), {}};
  }
}

RunTasks in_threads(int threads) {
  const auto runner = std::make_shared<Runner>(std::numeric_limits<std::size_t>::max());
  return [threads, runner](const std::vector<Task>& tasks, TrialLog& log) {
    std::atomic<std::size_t> next{0};
    std::vector<std::exception_ptr> faults(tasks.size());
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks.size(); i = next++) {
        try {
          log.add(runner->run(tasks[i]));
        } catch (...) {
          faults[i] = std::current_exception();
        }
      }
    };
    {
      std::vector<std::jthread> others;
      for (int k = 1; k < std::min(threads, static_cast<int>(tasks.size())); ++k) others.emplace_back(work);
      work();
    }
    for (const std::exception_ptr& fault : faults)
      if (fault) std::rethrow_exception(fault);
  };
}

}  // namespace sim::trials
