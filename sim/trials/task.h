// Trials as tasks for the process that runs them, and their records.
#pragma once

#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/trials/log.h"
#include "sim/trials/trial.h"

namespace sim::trials {

/// key: identifies the trial in the log. scenario: all of it as YAML, with its seed. recording: the result
/// folder that contains the recording; empty: it is in the cache.
struct Task {
  std::string key, scenario;
  std::filesystem::path recording{};
};

/// Runs tasks and adds their records to the log.
using RunTasks = std::function<void(const std::vector<Task>&, TrialLog&)>;

/// A file of tasks: the purpose of their log in the first line, then one line of JSON each.
struct TaskFile {
  std::string purpose;
  std::vector<Task> tasks;
};
void write_tasks(const std::filesystem::path& file, const TaskFile& tasks);
TaskFile read_tasks(const std::filesystem::path& file);

/// The names of a record's values, in the order of tables: all metrics, then the terms of objectives.
std::vector<std::string> value_names();

/// How a Runner gets recordings that a task does not name.
struct RecordingCache {
  std::function<std::string(const scenario::Scenario&)> key;
  /// Calls `use` with the result folder of the scenario's recording, recorded first if it is missing.
  std::function<void(const scenario::ReadScenario&,
                     const std::function<void(const std::filesystem::path&)>& use)>
      open;
};

/// Runs tasks, keeping the last recordings decoded in memory. Safe to use from several threads.
class Runner {
 public:
  /// keep: the number of recordings in memory.
  explicit Runner(std::size_t keep, RecordingCache cache = {}) : keep_(keep), cache_(std::move(cache)) {}

  /// Runs the trial; without a filter it scores only the walk. A fault of the trial is its record: "not
  /// started". Throws FileError for a fault of the machine.
  TrialRecord run(const Task& task);

 private:
  struct Loaded {
    std::string name;
    std::mutex mutex;
    std::shared_ptr<const Recording> recording;
  };
  std::shared_ptr<Loaded> find(const std::string& name);
  std::shared_ptr<const Recording> load(const Task& task, const scenario::ReadScenario& read);

  std::size_t keep_;
  RecordingCache cache_;
  std::mutex mutex_;
  std::list<std::shared_ptr<Loaded>> loaded_;  ///< the last used first
};

/// Runs tasks in that many threads of this process, all recordings in memory.
RunTasks in_threads(int threads);

}  // namespace sim::trials
