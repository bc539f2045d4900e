// A trial as a task for the process that runs it, and its record.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/replay/replay.h"
#include "sim/scenario/scenario.h"
#include "sim/tune/trial.h"
#include "sim/tune/trial_log.h"

namespace sim::tune {

/// key: identifies the trial in the log. scenario: all of it as YAML, seed included. recording: the result
/// folder that holds the recording; empty: it is in the cache.
struct Task {
  std::string key, scenario;
  std::filesystem::path recording{};
};

/// A file of tasks: the purpose of their log in the first line, then one line of JSON each.
struct TaskFile {
  std::string purpose;
  std::vector<Task> tasks;
};
void write_tasks(const std::filesystem::path& file, const TaskFile& tasks);
TaskFile read_tasks(const std::filesystem::path& file);

/// The names of a record's values, in the order of tables: all metrics, then the terms of objectives.
std::vector<std::string> value_names();

/// Runs one trial on a recording of a walk that ended so; without a filter it scores the walk alone. A
/// recording of a walk whose simulation failed is not tried. The values are metrics, terms of objectives and
/// lasted_fraction by their names.
TrialRecord run_task(const std::string& key, const scenario::ReadScenario& scenario,
                     const Recording& recording, const replay::WalkEnd& walk);

}  // namespace sim::tune
