// The hidden command that runs the tasks of one file, for sweeps and tunings: a trial that crashes is tried
// once more, then logged as crashed, and the others go on.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/bench/scenario_yaml.h"
#include "sim/stream/file_error.h"
#include "sim/tune/task.h"
#include "tools/cli/commands.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/processes.h"
#include "tools/cli/recordings.h"
#include "tools/cli/trial_commands.h"

namespace cli {
namespace {

namespace tune = sim::tune;

struct Request {
  fs::path tasks;
  fs::path models = GAITSLAM_MODELS;
  std::optional<pid_t> parent;
};

/// Which task is under way, for the n-th time: what a crash leaves behind.
struct Under {
  std::string key;
  int attempt = 0;
};

fs::path log_of(const fs::path& tasks) { return fs::path(tasks).replace_extension(".log"); }
fs::path under_way(const fs::path& tasks) { return fs::path(tasks).replace_extension(".under_way"); }

Under read_under(const fs::path& tasks) {
  Under under;
  std::ifstream(under_way(tasks)) >> under.key >> under.attempt;
  return under;
}

/// The recordings of trials that follow each other are mostly the same: the last one stays decoded.
class Runner {
 public:
  explicit Runner(const fs::path& models) : recordings_(models) {}

  tune::TrialRecord run(const tune::Task& task) {
    const bench::ReadScenario read = bench::read_scenario_text(task.scenario, "task.yaml");
    try {
      const tune::Recording& loaded = recording(task, read);
      return tune::run_task(task.key, read, loaded, walk_);
    } catch (const sim::stream::FileError&) {
      throw;  // a full disk, say: of the machine, not of the trial
    } catch (const std::exception& e) {
      return {task.key, read.scenario.seed, "not begun", e.what(), {}};
    }
  }

 private:
  const tune::Recording& recording(const tune::Task& task, const bench::ReadScenario& read) {
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

  void load(const fs::path& folder, const bench::ReadScenario& read) {
    recording_ = tune::load(folder, read.scenario);
    walk_ = bench::read_walk_end(folder);
  }

  Recordings recordings_;
  std::string loaded_;
  std::optional<tune::Recording> recording_;
  bench::WalkEnd walk_;
};

void run_tasks(const Request& request) {
  const tune::TaskFile file = tune::read_tasks(request.tasks);
  tune::TrialLog log(log_of(request.tasks), file.purpose);
  Runner runner(request.models);
  for (const tune::Task& task : file.tasks) {
    if (log.find(task.key)) continue;
    const Under before = read_under(request.tasks);
    std::ofstream(under_way(request.tasks))
        << fmt::format("{} {}\n", task.key, before.key == task.key ? before.attempt + 1 : 1);
    log.add(runner.run(task));
  }
}

std::uint64_t seed_of(const tune::Task& task) {
  return bench::read_scenario_text(task.scenario, "task.yaml").scenario.seed;
}

/// The second crash in the same trial is its result.
void note_crash(const Request& request, const Under& under, int signal) {
  if (under.attempt < 2) return;
  const tune::TaskFile file = tune::read_tasks(request.tasks);
  for (const tune::Task& task : file.tasks)
    if (task.key == under.key)
      tune::TrialLog(log_of(request.tasks), file.purpose)
          .add({task.key,
                seed_of(task),
                "crashed",
                fmt::format("killed by signal {} ({}), twice", signal, strsignal(signal)),
                {}});
}

int run_trials(const Request& request) {
  if (request.parent) die_with(*request.parent);
  Under before = read_under(request.tasks);
  for (const pid_t supervisor = getpid();;) {
    const pid_t child = fork();
    if (child < 0) throw UsageError(std::string("no process for the trials: ") + std::strerror(errno));
    if (child == 0) {
      die_with(supervisor);
      run_tasks(request);  // what it throws is told by main, in the child
      return 0;
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    const Under under = read_under(request.tasks);
    if (under.key == before.key && under.attempt == before.attempt)
      throw UsageError(
          fmt::format("{}: killed by signal {} before any trial", request.tasks.string(), WTERMSIG(status)));
    note_crash(request, under, WTERMSIG(status));
    before = under;
  }
}

}  // namespace

void add_trials(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("trials", "Run the tasks of a file")->group("");
  command->add_option("tasks", request->tasks)->required();
  command->add_option("--models", request->models);
  command->add_option("--die-with-parent", request->parent);
  command->callback([request, &exit_code] { exit_code = run_trials(*request); });
}

}  // namespace cli
