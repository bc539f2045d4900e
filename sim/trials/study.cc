#include "sim/trials/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sim::trials {
namespace {

constexpr double kFailure = 1e6;  // above the loss of any success

scenario::Scenario with_values(scenario::Scenario scenario, const std::vector<Range>& parameters,
                               const std::vector<double>& point) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = parameters[i].value_at(point[i]);
    set(scenario, parameters[i].key, value);
    for (const std::string& also : parameters[i].also) set(scenario, also, value);
  }
  return scenario;
}

}  // namespace

double loss_of(const TrialRecord& record, Objective objective) {
  const auto term = record.value(name(objective));
  if (term && std::isfinite(*term)) return std::min(*term, kFailure / 2);
  return kFailure * (2 - record.value("lasted_fraction").value_or(0));
}

double mean_loss(const std::vector<const TrialRecord*>& records, Objective objective) {
  double sum = 0;
  for (const TrialRecord* record : records) sum += loss_of(*record, objective);
  return sum / static_cast<double>(records.size());
}

Runs::Runs(const std::vector<RecordingSet>& sets, const Execution& execution)
    : remote_(execution.remote != nullptr),
      run_tasks_(remote_ ? execution.remote : in_threads(execution.threads)) {
  for (const RecordingSet& set : sets) {
    for (std::size_t k = 0; k < set.folders.size(); ++k) {
      const Recording identity = load_identity(set.folders[k]);
      runs_.push_back({set.folders[k], identity.name, identity.hash, scenario_of(set, set.folders[k])});
      if (!set.seeds.empty())
        runs_.back().name = fmt::format("{}/seed-{}", runs_.back().scenario.scenario.name, set.seeds[k]);
    }
  }
}

Task Runs::task(const Run& run, const std::vector<Range>& parameters,
                const std::vector<double>& point) const {
  const scenario::Scenario changed = with_values(run.scenario.scenario, parameters, point);
  const std::string scenario = scenario::to_yaml(changed);
  const bool simulate = changed.walk.steering.by == walking::SteeredBy::estimate;
  return {trial_key({run.hash, scenario}), scenario,
          simulate ? std::filesystem::path() : std::filesystem::absolute(run.folder)};
}

void Runs::run_missing(std::vector<Task> tasks, TrialLog& log) const {
  std::erase_if(tasks, [&](const Task& task) { return log.find(task.key) != nullptr; });
  if (tasks.empty()) return;
  run_tasks_(tasks, log);
  for (const Task& task : tasks)
    if (!log.find(task.key)) throw files::FileError(task.recording, "the filter could not be tried on it");
}

// The tasks of one recording follow each other, so that it is decoded once for them.
void Runs::prefetch(const std::vector<std::vector<double>>& points, const std::vector<Range>& parameters,
                    TrialLog& log) const {
  if (!remote_) return;
  std::vector<Task> tasks;
  for (const Run& run : runs_)
    for (const std::vector<double>& point : points) tasks.push_back(task(run, parameters, point));
  run_missing(tasks, log);
}

std::vector<const TrialRecord*> Runs::evaluate(const std::vector<Range>& parameters,
                                               const std::vector<double>& point, TrialLog& log) const {
  std::vector<Task> tasks;
  for (const Run& run : runs_) tasks.push_back(task(run, parameters, point));
  run_missing(tasks, log);
  std::vector<const TrialRecord*> records;
  for (const Task& task : tasks) records.push_back(log.find(task.key));
  return records;
}

Study::Study(const Spec& spec, const Runs& runs, TrialLog& log,
             std::function<void(const Candidate&)> on_candidate)
    : spec_(spec), runs_(runs), log_(log), on_candidate_(std::move(on_candidate)) {}

const Candidate& Study::evaluate(const std::string& origin, const std::vector<double>& point) {
  const auto records = runs_.evaluate(spec_.parameters, point, log_);
  candidates_.push_back({origin, point, records, mean_loss(records, spec_.objective)});
  if (on_candidate_) on_candidate_(candidates_.back());
  return candidates_.back();
}

const Candidate& Study::best() const {
  return *std::min_element(candidates_.begin(), candidates_.end(),
                           [](const Candidate& a, const Candidate& b) { return a.loss < b.loss; });
}

}  // namespace sim::trials
