#include "sim/trials/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/score/statistics.h"

namespace sim::trials {
namespace {

constexpr double kFailure = 1e6;     // above the loss of any success
constexpr std::size_t kRecent = 16;  // settings to compare a new one with

scenario::Scenario with_values(scenario::Scenario scenario, const std::vector<Range>& parameters,
                               const std::vector<double>& point) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = parameters[i].value_at(point[i]);
    set(scenario, parameters[i].key, value);
    for (const std::string& also : parameters[i].also) set(scenario, also, value);
  }
  return scenario;
}

double mean_of_first(const Candidate& candidate, const Runs& runs, Objective objective) {
  std::vector<const TrialRecord*> records;
  for (const std::size_t run : runs.first()) records.push_back(candidate.records[run]);
  return mean_loss(records, objective);
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

bool Candidate::complete() const {
  return std::find(records.begin(), records.end(), nullptr) == records.end();
}

Runs::Runs(const std::vector<RecordingSet>& sets, const Execution& execution)
    : remote_(execution.remote != nullptr),
      run_tasks_(remote_ ? execution.remote : in_threads(execution.threads)) {
  for (const RecordingSet& set : sets) {
    first_.push_back(runs_.size());
    for (std::size_t k = 0; k < set.folders.size(); ++k) {
      const Recording identity = load_identity(set.folders[k]);
      runs_.push_back({set.folders[k], identity.name, identity.hash, scenario_of(set, set.folders[k])});
      if (!set.seeds.empty())
        runs_.back().name = fmt::format("{}/seed-{}", runs_.back().scenario.scenario.name, set.seeds[k]);
    }
  }
}

std::vector<std::size_t> Runs::all() const {
  std::vector<std::size_t> all(size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
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

std::vector<const TrialRecord*> Runs::evaluate(const std::vector<std::size_t>& which,
                                               const std::vector<Range>& parameters,
                                               const std::vector<double>& point, TrialLog& log) const {
  std::vector<Task> tasks;
  for (const std::size_t run : which) tasks.push_back(task(runs_[run], parameters, point));
  run_missing(tasks, log);
  std::vector<const TrialRecord*> records;
  for (const Task& task : tasks) records.push_back(log.find(task.key));
  return records;
}

Study::Study(const Spec& spec, const Runs& runs, TrialLog& log,
             std::function<void(const Candidate&)> on_candidate)
    : spec_(spec), runs_(runs), log_(log), on_candidate_(std::move(on_candidate)) {}

const Candidate& Study::evaluate(const std::string& origin, const std::vector<double>& point, Abort abort) {
  Candidate candidate{origin, point, std::vector<const TrialRecord*>(runs_.size(), nullptr), 0};
  const auto add = [&](const std::vector<std::size_t>& which) {
    const auto records = runs_.evaluate(which, spec_.parameters, point, log_);
    for (std::size_t i = 0; i < which.size(); ++i) candidate.records[which[i]] = records[i];
  };
  std::optional<double> estimate;
  if (abort == Abort::hopeless) {
    add(runs_.first());
    estimate = loss_if_hopeless(candidate);
  }
  if (!estimate) {
    std::vector<std::size_t> left = runs_.all();
    std::erase_if(left, [&](std::size_t run) { return candidate.records[run] != nullptr; });
    add(left);
  }
  candidate.loss = estimate ? *estimate : mean_loss(candidate.records, spec_.objective);
  candidates_.push_back(std::move(candidate));
  if (on_candidate_) on_candidate_(candidates_.back());
  return candidates_.back();
}

// Compares with the latest settings that were tried on all recordings.
std::optional<double> Study::loss_if_hopeless(const Candidate& begun) const {
  if (runs_.first().size() == runs_.size()) return std::nullopt;
  std::vector<double> first, rest;
  for (auto c = candidates_.rbegin(); c != candidates_.rend() && first.size() < kRecent; ++c) {
    if (!c->complete()) continue;
    first.push_back(mean_of_first(*c, runs_, spec_.objective));
    rest.push_back(c->loss - first.back());
  }
  if (first.size() < kRecent / 2) return std::nullopt;
  const double here = mean_of_first(begun, runs_, spec_.objective);
  if (here <= score::quantile(first, 0.75)) return std::nullopt;
  return here + std::max(0.0, score::median(rest));
}

const Candidate& Study::best() const {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates_)
    if (candidate.complete() && (!best || candidate.loss < best->loss)) best = &candidate;
  return *best;
}

}  // namespace sim::trials
