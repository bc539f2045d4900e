// The hidden command that runs the tasks of a file for sweeps and tunings. A trial that crashes is logged,
// and the others continue.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

#include "sim/files/text.h"
#include "sim/trials/task.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/processes.h"
#include "tools/cli/jobs/recordings.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"

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

fs::path log_file(const fs::path& tasks) { return fs::path(tasks).replace_extension(".log"); }
/// The file with the key of the running task, which survives a crash.
fs::path running_file(const fs::path& tasks) { return fs::path(tasks).replace_extension(".under_way"); }

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
    sim::files::write_text(running_file(request.tasks), task.key);
    log.add(runner.run(task));
  }
}

/// Logs the crash of the running task. Throws UsageError if none was running.
void log_crash(const TrialsRequest& request, int signal) {
  const trials::TaskFile file = trials::read_tasks(request.tasks);
  const std::string running =
      fs::exists(running_file(request.tasks)) ? sim::files::read_text(running_file(request.tasks)) : "";
  trials::TrialLog log(log_file(request.tasks), file.purpose);
  for (const trials::Task& task : file.tasks)
    if (task.key == running && !log.find(task.key))
      return log.add({task.key,
                      scenario::read_scenario_text(task.scenario, "task.yaml").scenario.seed,
                      "crashed",
                      fmt::format("killed by signal {} ({})", signal, strsignal(signal)),
                      {}});
  throw UsageError(fmt::format("{}: killed by signal {} before any trial", request.tasks.string(), signal));
}

int run_trials(const TrialsRequest& request) {
  if (request.parent) die_with(*request.parent);
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
    log_crash(request, WTERMSIG(status));
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
