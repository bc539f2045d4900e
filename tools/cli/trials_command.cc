// The hidden command that runs the tasks of a file for sweeps and tunings. A trial that crashes is tried once
// more, then logged as crashed, and the other trials continue.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "sim/files/text.h"
#include "sim/scenario/yaml.h"
#include "sim/tune/task.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/processes.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "tools/cli/recordings.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace replay = sim::replay;
namespace scenario = sim::scenario;
namespace tune = sim::tune;

struct TrialsRequest {
  fs::path tasks;
  fs::path models = standard_models();
  std::optional<pid_t> parent;
};

/// The task that is running and how often it was started; written to a file that survives a crash.
struct Running {
  std::string key;
  int attempt = 0;
};

fs::path log_of(const fs::path& tasks) { return fs::path(tasks).replace_extension(".log"); }
fs::path running_file(const fs::path& tasks) { return fs::path(tasks).replace_extension(".under_way"); }

Running read_running(const fs::path& tasks) {
  Running running;
  if (fs::exists(running_file(tasks)))
    std::istringstream(sim::files::read_text(running_file(tasks))) >> running.key >> running.attempt;
  return running;
}

/// Keeps the last recording decoded, because successive trials mostly use the same one.
class Runner {
 public:
  explicit Runner(const fs::path& models) : recordings_(models) {}

  tune::TrialRecord run(const tune::Task& task) {
    const scenario::ReadScenario read = scenario::read_scenario_text(task.scenario, "task.yaml");
    try {
      const tune::Recording& loaded = recording(task, read);
      return tune::run_task(task.key, read, loaded, walk_);
    } catch (const sim::files::FileError&) {
      throw;  // a fault of the machine, such as a full disk, and not of the trial
    } catch (const std::exception& e) {
      return {task.key, read.scenario.seed, "not begun", e.what(), {}};
    }
  }

 private:
  const tune::Recording& recording(const tune::Task& task, const scenario::ReadScenario& read) {
    const std::string name =
        (task.recording.empty() ? recordings_.key(read.scenario) : task.recording.string()) +
        tune::errors_of(read.scenario);
    if (name == loaded_) return *recording_;
    loaded_.clear();
    recording_.reset();
    if (task.recording.empty())
      load(recordings_.get(read, [](double) {}).folder, read);
    else
      load(task.recording, read);
    loaded_ = name;
    return *recording_;
  }

  void load(const fs::path& folder, const scenario::ReadScenario& read) {
    recording_ = tune::load(folder, read.scenario);
    walk_ = replay::read_walk_end(folder);
  }

  Recordings recordings_;
  std::string loaded_;
  std::optional<tune::Recording> recording_;
  replay::WalkEnd walk_;
};

void run_tasks(const TrialsRequest& request) {
  const tune::TaskFile file = tune::read_tasks(request.tasks);
  tune::TrialLog log(log_of(request.tasks), file.purpose);
  Runner runner(request.models);
  for (const tune::Task& task : file.tasks) {
    if (log.find(task.key)) continue;
    const Running before = read_running(request.tasks);
    sim::files::write_text(running_file(request.tasks),
                           fmt::format("{} {}\n", task.key, before.key == task.key ? before.attempt + 1 : 1));
    log.add(runner.run(task));
  }
}

std::uint64_t seed_of(const tune::Task& task) {
  return scenario::read_scenario_text(task.scenario, "task.yaml").scenario.seed;
}

/// Logs the second crash of the same trial as its result.
void log_crash(const TrialsRequest& request, const Running& running, int signal) {
  if (running.attempt < 2) return;
  const tune::TaskFile file = tune::read_tasks(request.tasks);
  for (const tune::Task& task : file.tasks)
    if (task.key == running.key)
      tune::TrialLog(log_of(request.tasks), file.purpose)
          .add({task.key,
                seed_of(task),
                "crashed",
                fmt::format("killed by signal {} ({}), twice", signal, strsignal(signal)),
                {}});
}

int run_trials(const TrialsRequest& request) {
  if (request.parent) die_with(*request.parent);
  Running before = read_running(request.tasks);
  for (const pid_t supervisor = getpid();;) {
    const pid_t child = fork();
    if (child < 0) throw UsageError(std::string("no process for the trials: ") + std::strerror(errno));
    if (child == 0) {
      die_with(supervisor);
      run_tasks(request);  // main, in the child, reports what it throws
      return 0;
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    const Running running = read_running(request.tasks);
    if (running.key == before.key && running.attempt == before.attempt)
      throw UsageError(
          fmt::format("{}: killed by signal {} before any trial", request.tasks.string(), WTERMSIG(status)));
    log_crash(request, running, WTERMSIG(status));
    before = running;
  }
}

}  // namespace

void add_trials(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<TrialsRequest>();
  CLI::App* command = app.add_subcommand("trials", "Run the tasks of a file")->group("");
  command->add_option("tasks", request->tasks)->required();
  add_models(*command, request->models);
  add_parent(*command, request->parent);
  command->callback([request, &exit_code] { exit_code = run_trials(*request); });
}

}  // namespace cli
