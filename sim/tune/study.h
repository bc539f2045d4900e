// Settings tried on recordings: every run of the filter once, remembered on the disk, alike for any number of
// threads.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/tune/spec.h"
#include "sim/tune/task.h"
#include "sim/tune/trial.h"
#include "sim/tune/trial_log.h"

namespace sim::tune {

/// What a run that failed counts in an objective: worse than any success, the worse the earlier it failed.
double failure_value(double lasted_fraction);
/// What a run counts: its term, or the value of its failure.
double value_of(const TrialRecord& record, Objective objective);

/// A setting that was tried. `parts` as of Parameter.
struct Candidate {
  std::string origin;  ///< "start", "global", "polish" or "profile"
  std::vector<double> parts;
  std::vector<const TrialRecord*> records;  ///< of each run; nullptr where it was given up before
  std::vector<double> values;               ///< of each objective; for one given up an estimate
  bool complete() const;
};

/// Runs all tasks, on a cluster say, and adds their records to the log.
using RunTasks = std::function<void(const std::vector<Task>&, TrialLog&)>;

/// Where trials run: in so many threads of this process, or elsewhere.
struct Where {
  int jobs = 1;
  RunTasks elsewhere{};
};

/// The recordings of one side (training or hold-out): in memory, unless trials run elsewhere.
class Runs {
 public:
  /// keep_ideal: parameters change the sensor errors, which are then drawn for each trial.
  Runs(const std::vector<Footage>& footage, bool keep_ideal, const Where& where);

  std::size_t size() const { return runs_.size(); }
  /// Which runs are tried first: one of each entry of the spec.
  const std::vector<std::size_t>& first() const { return first_; }
  /// "tangent_circle/seed-1"
  const std::string& name(std::size_t run) const { return runs_[run].name; }

  /// The records of those runs (in that order) with these values, from the log where it has them.
  std::vector<const TrialRecord*> try_on(const std::vector<std::size_t>& which,
                                         const std::vector<Parameter>& parameters,
                                         const std::vector<double>& parts, TrialLog& log) const;

  /// Where trials run elsewhere, all of these settings are tried on all runs at once: what try_on() will be
  /// asked for.
  void expect(const std::vector<std::vector<double>>& settings, const std::vector<Parameter>& parameters,
              TrialLog& log) const;

 private:
  struct Run {
    std::filesystem::path folder;
    std::string name;
    bench::ReadScenario scenario;
    Recording recording;  ///< elsewhere: name and hash alone
  };
  Task task(const Run& run, const std::vector<Parameter>& parameters, const std::vector<double>& parts) const;
  void run_elsewhere(std::vector<Task> tasks, TrialLog& log) const;

  Where where_;
  std::vector<Run> runs_;
  std::vector<std::size_t> first_;
};

/// All that is tried in a tuning, one setting after another: what is tried next depends on no thread.
class Study {
 public:
  /// told: called after each setting.
  Study(const Spec& spec, const Runs& runs, TrialLog& log, std::function<void(const Candidate&)> told);

  /// evaluate() will be asked for these: where trials run elsewhere, they run at once.
  void expect(const std::vector<std::vector<double>>& settings) {
    runs_.expect(settings, spec_.parameters, log_);
  }

  /// Tries a setting on all runs. hopeless_ends: one whose first runs are beyond the upper quartile of what
  /// the last settings had there is given up, and valued by how those went on.
  const Candidate& evaluate(const std::string& origin, const std::vector<double>& parts,
                            bool hopeless_ends = false);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// The complete candidate with the least first objective; there is one.
  const Candidate& best() const;
  const Spec& spec() const { return spec_; }

 private:
  std::optional<std::vector<double>> value_if_hopeless(const Candidate& begun) const;

  const Spec& spec_;
  const Runs& runs_;
  TrialLog& log_;
  std::function<void(const Candidate&)> told_;
  std::vector<Candidate> candidates_;
};

/// The mean over those runs of what each counts.
double mean_value(const std::vector<const TrialRecord*>& records, const std::vector<std::size_t>& runs,
                  Objective objective);

}  // namespace sim::tune
