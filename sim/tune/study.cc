#include "sim/tune/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <numeric>
#include <thread>

namespace sim::tune {
namespace {

constexpr double kFailure = 1e6;     // a success counts less
constexpr std::size_t kRecent = 16;  // settings that tell what can be hoped for

// Calls work(i) for all i < count in so many threads. The first exception is thrown on.
void in_threads(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::vector<std::exception_ptr> faults(count);
  const auto take = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        faults[i] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int k = 1; k < std::min<int>(jobs, static_cast<int>(count)); ++k) threads.emplace_back(take);
    take();
  }
  for (const std::exception_ptr& fault : faults)
    if (fault) std::rethrow_exception(fault);
}

bench::ReadScenario with_values(bench::ReadScenario read, const std::vector<Parameter>& parameters,
                                const std::vector<double>& parts) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = parameters[i].at(parts[i]);
    set(read.scenario, parameters[i].key, value);
    for (const std::string& also : parameters[i].also) set(read.scenario, also, value);
  }
  return read;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

}  // namespace

double failure_value(double lasted_fraction) { return kFailure * (2 - lasted_fraction); }

double value_of(const TrialRecord& record, Objective objective) {
  const auto term = record.values.find(std::string(name(objective)));
  if (term != record.values.end() && std::isfinite(term->second)) return std::min(term->second, kFailure / 2);
  const auto lasted = record.values.find("lasted_fraction");
  return failure_value(lasted == record.values.end() ? 0 : lasted->second);
}

double mean_value(const std::vector<const TrialRecord*>& records, const std::vector<std::size_t>& runs,
                  Objective objective) {
  double sum = 0;
  for (const std::size_t run : runs) sum += value_of(*records[run], objective);
  return sum / static_cast<double>(runs.size());
}

bool Candidate::complete() const {
  return std::find(records.begin(), records.end(), nullptr) == records.end();
}

Runs::Runs(const std::vector<Footage>& footage, bool keep_ideal, const Where& where) : where_(where) {
  for (const Footage& entry : footage) {
    first_.push_back(runs_.size());
    for (const std::filesystem::path& folder : entry.folders)
      runs_.push_back({folder, "", scenario_of(entry, folder), {}});
    for (std::size_t k = 0; k < entry.seeds.size(); ++k) {
      Run& run = runs_[first_.back() + k];
      run.name = fmt::format("{}/seed-{}", run.scenario.scenario.name, entry.seeds[k]);
    }
  }
  in_threads(runs_.size(), where.jobs, [&](std::size_t i) {
    Run& run = runs_[i];
    run.recording = where.elsewhere ? load_identity(run.folder)
                    : keep_ideal    ? load(run.folder)
                                    : load(run.folder, run.scenario.scenario);
    if (run.name.empty()) run.name = run.recording.name;
  });
}

Task Runs::task(const Run& run, const std::vector<Parameter>& parameters,
                const std::vector<double>& parts) const {
  const std::string scenario = bench::to_yaml(with_values(run.scenario, parameters, parts).scenario);
  return {trial_key({run.recording.hash, scenario}), scenario, std::filesystem::absolute(run.folder)};
}

void Runs::run_elsewhere(std::vector<Task> tasks, TrialLog& log) const {
  std::erase_if(tasks, [&](const Task& task) { return log.find(task.key) != nullptr; });
  if (tasks.empty()) return;
  where_.elsewhere(tasks, log);
  for (const Task& task : tasks)
    if (!log.find(task.key)) throw stream::FileError(task.recording, "the filter could not be tried on it");
}

// Those of one recording follow each other: it is decoded once for them.
void Runs::expect(const std::vector<std::vector<double>>& settings, const std::vector<Parameter>& parameters,
                  TrialLog& log) const {
  if (!where_.elsewhere) return;
  std::vector<Task> tasks;
  for (const Run& run : runs_)
    for (const std::vector<double>& parts : settings) tasks.push_back(task(run, parameters, parts));
  run_elsewhere(tasks, log);
}

std::vector<const TrialRecord*> Runs::try_on(const std::vector<std::size_t>& which,
                                             const std::vector<Parameter>& parameters,
                                             const std::vector<double>& parts, TrialLog& log) const {
  std::vector<Task> tasks;
  for (const std::size_t run : which) tasks.push_back(task(runs_[run], parameters, parts));
  if (where_.elsewhere) run_elsewhere(tasks, log);
  std::vector<const TrialRecord*> records(which.size());
  in_threads(which.size(), where_.jobs, [&](std::size_t i) {
    const Run& run = runs_[which[i]];
    if (!log.find(tasks[i].key))
      log.add(run_task(tasks[i].key, with_values(run.scenario, parameters, parts), run.recording,
                       {run.recording.walk_ending, ""}));
    records[i] = log.find(tasks[i].key);
  });
  return records;
}

Study::Study(const Spec& spec, const Runs& runs, TrialLog& log, std::function<void(const Candidate&)> told)
    : spec_(spec), runs_(runs), log_(log), told_(std::move(told)) {}

const Candidate& Study::evaluate(const std::string& origin, const std::vector<double>& parts,
                                 bool hopeless_ends) {
  Candidate candidate{origin, parts, std::vector<const TrialRecord*>(runs_.size(), nullptr), {}};
  const auto try_on = [&](const std::vector<std::size_t>& which) {
    const auto records = runs_.try_on(which, spec_.parameters, parts, log_);
    for (std::size_t i = 0; i < which.size(); ++i) candidate.records[which[i]] = records[i];
  };
  if (hopeless_ends) {
    try_on(runs_.first());
    if (auto value = value_if_hopeless(candidate)) candidate.values = *value;
  }
  if (candidate.values.empty()) {
    std::vector<std::size_t> all(runs_.size()), left;
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (const std::size_t run : all)
      if (!candidate.records[run]) left.push_back(run);
    try_on(left);
    for (const Objective objective : spec_.objectives)
      candidate.values.push_back(mean_value(candidate.records, all, objective));
  }
  candidates_.push_back(std::move(candidate));
  if (told_) told_(candidates_.back());
  return candidates_.back();
}

// With one objective, from the settings that were tried on all runs last.
std::optional<std::vector<double>> Study::value_if_hopeless(const Candidate& begun) const {
  const std::vector<std::size_t>& first = runs_.first();
  if (spec_.objectives.size() != 1 || first.size() == runs_.size()) return std::nullopt;
  std::vector<double> there, rest;
  for (auto c = candidates_.rbegin(); c != candidates_.rend() && there.size() < kRecent; ++c) {
    if (!c->complete()) continue;
    there.push_back(mean_value(c->records, first, spec_.objectives[0]));
    rest.push_back(c->values[0] - there.back());
  }
  if (there.size() < kRecent / 2) return std::nullopt;
  const double here = mean_value(begun.records, first, spec_.objectives[0]);
  if (here <= quantile(there, 0.75)) return std::nullopt;
  return std::vector{here + std::max(0.0, quantile(rest, 0.5))};
}

const Candidate& Study::best() const {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates_)
    if (candidate.complete() && (!best || candidate.values[0] < best->values[0])) best = &candidate;
  return *best;
}

}  // namespace sim::tune
