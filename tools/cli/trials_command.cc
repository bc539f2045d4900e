// The hidden command that runs the tasks of a file for sweeps and tunings. A trial that crashes is tried once
// more, then logged as crashed, and the other trials continue.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <sstream>

#include "sim/files/text.h"
#include "sim/trials/task.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/processes.h"
#include "tools/cli/jobs/recordings.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace scenario = sim::scenario;
namespace trials = sim::trials;

struct TrialsRequest {
  fs::path tasks;
  fs::path models = standard_models();
  std::optional<pid_t> parent;
};

/// The task that is running and how often it was started; written to a file that survives a crash.
struct Running {
  std::string key;
  int attempt = 0;
  bool operator==(const Running&) const = default;
};

fs::path log_file(const fs::path& tasks) { return fs::path(tasks).replace_extension(".log"); }
fs::path running_file(const fs::path& tasks) { return fs::path(tasks).replace_extension(".under_way"); }

Running read_running(const fs::path& tasks) {
  Running running;
  if (fs::exists(running_file(tasks)))
    std::istringstream(sim::files::read_text(running_file(tasks))) >> running.key >> running.attempt;
  return running;
}

void run_tasks(const TrialsRequest& request) {
  const trials::TaskFile file = trials::read_tasks(request.tasks);
  trials::TrialLog log(log_file(request.tasks), file.purpose);
  const Recordings recordings(request.models);
  // Successive trials mostly use the same recording.
  trials::Runner runner(1, {[&](const scenario::Scenario& s) { return recordings.key(s); },
                            [&](const scenario::ReadScenario& read, const auto& use) {
                              use(recordings.get(read, [](double) {}).folder);
                            }});
  for (const trials::Task& task : file.tasks) {
    if (log.find(task.key)) continue;
    const Running before = read_running(request.tasks);
    sim::files::write_text(running_file(request.tasks),
                           fmt::format("{} {}\n", task.key, before.key == task.key ? before.attempt + 1 : 1));
    log.add(runner.run(task));
  }
}

/// Logs the second crash of the same trial as its result.
void log_crash(const TrialsRequest& request, const Running& running, int signal) {
  if (running.attempt < 2) return;
  const trials::TaskFile file = trials::read_tasks(request.tasks);
  for (const trials::Task& task : file.tasks)
    if (task.key == running.key)
      trials::TrialLog(log_file(request.tasks), file.purpose)
          .add({task.key,
                scenario::read_scenario_text(task.scenario, "task.yaml").scenario.seed,
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
    if (running == before)
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
