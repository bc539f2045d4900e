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

constexpr double kFailure = 1e6;     // above the loss of any success
constexpr std::size_t kRecent = 16;  // settings that a new one is compared with

// Calls work(i) for all i < count in that many threads. Rethrows the first exception.
void in_threads(std::size_t count, int threads_wanted, const std::function<void(std::size_t)>& work) {
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
    for (int k = 1; k < std::min<int>(threads_wanted, static_cast<int>(count)); ++k)
      threads.emplace_back(take);
    take();
  }
  for (const std::exception_ptr& fault : faults)
    if (fault) std::rethrow_exception(fault);
}

scenario::ReadScenario with_values(scenario::ReadScenario read, const std::vector<Parameter>& parameters,
                                   const std::vector<double>& point) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = parameters[i].value_at(point[i]);
    set(read.scenario, parameters[i].key, value);
    for (const std::string& also : parameters[i].also) set(read.scenario, also, value);
  }
  return read;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

double mean_of_first(const Candidate& candidate, const Runs& runs, Objective objective) {
  std::vector<const TrialRecord*> records;
  for (const std::size_t run : runs.first()) records.push_back(candidate.records[run]);
  return mean_loss(records, objective);
}

}  // namespace

double loss_of(const TrialRecord& record, Objective objective) {
  const auto term = record.values.find(std::string(name(objective)));
  if (term != record.values.end() && std::isfinite(term->second)) return std::min(term->second, kFailure / 2);
  const auto lasted = record.values.find("lasted_fraction");
  return kFailure * (2 - (lasted == record.values.end() ? 0 : lasted->second));
}

double mean_loss(const std::vector<const TrialRecord*>& records, Objective objective) {
  double sum = 0;
  for (const TrialRecord* record : records) sum += loss_of(*record, objective);
  return sum / static_cast<double>(records.size());
}

bool Candidate::complete() const {
  return std::find(records.begin(), records.end(), nullptr) == records.end();
}

Runs::Runs(const std::vector<RecordingSet>& sets, bool keep_ideal, const Execution& execution)
    : execution_(execution) {
  for (const RecordingSet& set : sets) {
    first_.push_back(runs_.size());
    for (const std::filesystem::path& folder : set.folders)
      runs_.push_back({folder, "", scenario_of(set, folder), {}});
    for (std::size_t k = 0; k < set.seeds.size(); ++k) {
      Run& run = runs_[first_.back() + k];
      run.name = fmt::format("{}/seed-{}", run.scenario.scenario.name, set.seeds[k]);
    }
  }
  in_threads(runs_.size(), execution.threads, [&](std::size_t i) {
    Run& run = runs_[i];
    run.recording = execution.remote ? load_identity(run.folder)
                    : keep_ideal     ? load(run.folder)
                                     : load(run.folder, run.scenario.scenario);
    if (run.name.empty()) run.name = run.recording.name;
  });
}

std::vector<std::size_t> Runs::all() const {
  std::vector<std::size_t> all(size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

Task Runs::task(const Run& run, const std::vector<Parameter>& parameters,
                const std::vector<double>& point) const {
  const scenario::Scenario changed = with_values(run.scenario, parameters, point).scenario;
  const std::string scenario = scenario::to_yaml(changed);
  const bool simulate = changed.walk.steering.by == walking::SteeredBy::estimate;
  return {trial_key({run.recording.hash, scenario}), scenario,
          simulate ? std::filesystem::path() : std::filesystem::absolute(run.folder)};
}

void Runs::run_remotely(std::vector<Task> tasks, TrialLog& log) const {
  std::erase_if(tasks, [&](const Task& task) { return log.find(task.key) != nullptr; });
  if (tasks.empty()) return;
  execution_.remote(tasks, log);
  for (const Task& task : tasks)
    if (!log.find(task.key)) throw files::FileError(task.recording, "the filter could not be tried on it");
}

// The tasks of one recording follow each other, so that it is decoded once for them.
void Runs::prefetch(const std::vector<std::vector<double>>& points, const std::vector<Parameter>& parameters,
                    TrialLog& log) const {
  if (!execution_.remote) return;
  std::vector<Task> tasks;
  for (const Run& run : runs_)
    for (const std::vector<double>& point : points) tasks.push_back(task(run, parameters, point));
  run_remotely(tasks, log);
}

std::vector<const TrialRecord*> Runs::evaluate(const std::vector<std::size_t>& which,
                                               const std::vector<Parameter>& parameters,
                                               const std::vector<double>& point, TrialLog& log) const {
  std::vector<Task> tasks;
  for (const std::size_t run : which) tasks.push_back(task(runs_[run], parameters, point));
  if (execution_.remote) run_remotely(tasks, log);
  std::vector<const TrialRecord*> records(which.size());
  in_threads(which.size(), execution_.threads, [&](std::size_t i) {
    const Run& run = runs_[which[i]];
    if (!log.find(tasks[i].key))
      log.add(run_task(tasks[i].key, with_values(run.scenario, parameters, point), run.recording,
                       {{run.recording.walk_ending}}));
    records[i] = log.find(tasks[i].key);
  });
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
  if (here <= quantile(first, 0.75)) return std::nullopt;
  return here + std::max(0.0, quantile(rest, 0.5));
}

const Candidate& Study::best() const {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates_)
    if (candidate.complete() && (!best || candidate.loss < best->loss)) best = &candidate;
  return *best;
}

}  // namespace sim::tune
