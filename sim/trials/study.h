// Settings tried on recordings: each trial runs once and is logged; results do not depend on the number of
// threads.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/trials/log.h"
#include "sim/trials/spec.h"
#include "sim/trials/task.h"

namespace sim::trials {

/// The loss of a trial: its objective term. A failed trial loses more than any that succeeded; early
/// failures lose most.
double loss_of(const TrialRecord& record, Objective objective);
/// The mean loss over the records.
double mean_loss(const std::vector<const TrialRecord*>& records, Objective objective);

/// A setting that was tried, as a point of the unit cube (see Parameter).
struct Candidate {
  std::string origin;  ///< "start" or "search"
  std::vector<double> point;
  std::vector<const TrialRecord*> records;  ///< of each recording
  double loss = 0;                          ///< mean over the recordings
};

/// How trials run: in that many threads of this process, or by `remote` if it is set. It must be set if walks
/// are steered by their estimate: each setting then needs a simulation.
struct Execution {
  int threads = 1;
  RunTasks remote{};
};

/// The recordings of training or of the hold-out.
class Runs {
 public:
  Runs(const std::vector<RecordingSet>& sets, const Execution& execution);

  std::size_t size() const { return runs_.size(); }
  /// "tangent_circle/seed-1"
  const std::string& name(std::size_t run) const { return runs_[run].name; }

  /// The records of a setting on each recording, taken from the log if it has them.
  std::vector<const TrialRecord*> evaluate(const std::vector<Range>& parameters,
                                           const std::vector<double>& point, TrialLog& log) const;

  /// If trials run remotely, runs all of these settings on all recordings at once, so that evaluate() finds
  /// them in the log.
  void prefetch(const std::vector<std::vector<double>>& points, const std::vector<Range>& parameters,
                TrialLog& log) const;

 private:
  struct Run {
    std::filesystem::path folder;
    std::string name, hash;
    scenario::ReadScenario scenario;
  };
  /// A walk that its estimate steers differs with each setting: its task names no recording.
  Task task(const Run& run, const std::vector<Range>& parameters, const std::vector<double>& point) const;
  void run_missing(std::vector<Task> tasks, TrialLog& log) const;

  bool remote_;
  RunTasks run_tasks_;
  std::vector<Run> runs_;
};

/// All settings that a tuning tries, one after another.
class Study {
 public:
  /// on_candidate: called after each setting.
  Study(const Spec& spec, const Runs& runs, TrialLog& log,
        std::function<void(const Candidate&)> on_candidate);

  /// Runs::prefetch() of settings that will be evaluated.
  void prefetch(const std::vector<std::vector<double>>& points) {
    runs_.prefetch(points, spec_.parameters, log_);
  }

  /// Tries a setting on all recordings.
  const Candidate& evaluate(const std::string& origin, const std::vector<double>& point);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// The candidate with the least loss. There must be one.
  const Candidate& best() const;
  const Spec& spec() const { return spec_; }

 private:
  const Spec& spec_;
  const Runs& runs_;
  TrialLog& log_;
  std::function<void(const Candidate&)> on_candidate_;
  std::vector<Candidate> candidates_;
};

}  // namespace sim::trials
