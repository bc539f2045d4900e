// Settings tried on recordings: each trial runs once and is logged on the disk, and the results do not depend
// on the number of threads.
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

/// The loss of a trial: its objective term. A trial that failed loses more than any that succeeded, and the
/// more the earlier it failed.
double loss_of(const TrialRecord& record, Objective objective);
/// The mean loss over the records.
double mean_loss(const std::vector<const TrialRecord*>& records, Objective objective);

/// A setting that was tried, as a point of the unit cube (see Parameter).
struct Candidate {
  std::string origin;  ///< "start", "global", "polish" or "profile"
  std::vector<double> point;
  std::vector<const TrialRecord*> records;  ///< of each recording; nullptr where the setting was aborted
  double loss = 0;                          ///< mean over all recordings; an estimate if it was aborted
  bool complete() const;
};

/// Runs all tasks (on a cluster, for example) and adds their records to the log.
using RunTasks = std::function<void(const std::vector<Task>&, TrialLog&)>;

/// How trials run: in that many threads of this process, or by `remote` where that is set. It must be set
/// where walks are steered by their estimate: each setting then needs a simulation.
struct Execution {
  int threads = 1;
  RunTasks remote{};
};

/// The recordings of training or of the hold-out: in memory, unless trials run remotely.
class Runs {
 public:
  /// keep_ideal: parameters change the sensor errors, which are then drawn for each trial.
  Runs(const std::vector<RecordingSet>& sets, bool keep_ideal, const Execution& execution);

  std::size_t size() const { return runs_.size(); }
  /// 0, 1, ..., size() - 1.
  std::vector<std::size_t> all() const;
  /// Which recordings are tried first: one of each set.
  const std::vector<std::size_t>& first() const { return first_; }
  /// "tangent_circle/seed-1"
  const std::string& name(std::size_t run) const { return runs_[run].name; }

  /// The records of a setting on those recordings, in that order; taken from the log where it has them.
  std::vector<const TrialRecord*> evaluate(const std::vector<std::size_t>& which,
                                           const std::vector<Parameter>& parameters,
                                           const std::vector<double>& point, TrialLog& log) const;

  /// Where trials run remotely, tries all of these settings on all recordings at once, so that evaluate()
  /// finds them in the log.
  void prefetch(const std::vector<std::vector<double>>& points, const std::vector<Parameter>& parameters,
                TrialLog& log) const;

 private:
  struct Run {
    std::filesystem::path folder;
    std::string name;
    scenario::ReadScenario scenario;
    Recording recording;  ///< name and hash alone where trials run remotely
  };
  /// A walk that its estimate steers is another one with each setting: its task names no recording.
  Task task(const Run& run, const std::vector<Parameter>& parameters, const std::vector<double>& point) const;
  void run_remotely(std::vector<Task> tasks, TrialLog& log) const;

  Execution execution_;
  std::vector<Run> runs_;
  std::vector<std::size_t> first_;
};

/// All settings that a tuning tries, one after another.
class Study {
 public:
  enum class Abort { never, hopeless };

  /// on_candidate: called after each setting.
  Study(const Spec& spec, const Runs& runs, TrialLog& log,
        std::function<void(const Candidate&)> on_candidate);

  /// Runs::prefetch() of settings that evaluate() will be asked for.
  void prefetch(const std::vector<std::vector<double>>& points) {
    runs_.prefetch(points, spec_.parameters, log_);
  }

  /// Tries a setting on all recordings. Abort::hopeless: a setting whose loss on the first recordings is
  /// above the upper quartile of recent settings is aborted there, and its loss on the others estimated by
  /// their median.
  const Candidate& evaluate(const std::string& origin, const std::vector<double>& point,
                            Abort abort = Abort::never);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// The complete candidate with the least loss. There must be one.
  const Candidate& best() const;
  const Spec& spec() const { return spec_; }

 private:
  std::optional<double> loss_if_hopeless(const Candidate& begun) const;

  const Spec& spec_;
  const Runs& runs_;
  TrialLog& log_;
  std::function<void(const Candidate&)> on_candidate_;
  std::vector<Candidate> candidates_;
};

}  // namespace sim::tune
