#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <set>

#include "sim/files/text.h"
#include "sim/trials/trial.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr std::size_t kMostTasks = 32;  // of a part: half a minute, enough for an array element

std::vector<fs::path> parts_in(const fs::path& folder) {
  std::vector<fs::path> parts;
  if (!fs::exists(folder)) return parts;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".tasks") parts.push_back(entry.path());
  std::sort(parts.begin(), parts.end());
  return parts;
}

std::vector<fs::path> write_parts(const std::vector<trials::Task>& tasks, const TrialsPlace& place,
                                  const Backend& backend) {
  fs::create_directories(place.folder);
  // As few parts as keep all processes equally busy, because each part decodes its recording.
  const auto up = [](std::size_t a, std::size_t b) { return (a + b - 1) / b; };
  const auto jobs = static_cast<std::size_t>(std::max(backend.jobs, 1));
  const std::size_t n = tasks.size(),
                    each = backend.slurm() ? kMostTasks : up(n, jobs * up(n, jobs * kMostTasks));
  for (std::size_t first = 0; first < tasks.size(); first += each) {
    const auto begin = tasks.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(std::min(each, tasks.size() - first));
    trials::write_tasks(place.folder / fmt::format("{:06}.tasks", first), {place.purpose, {begin, end}});
  }
  return parts_in(place.folder);
}

fs::path log_of(const fs::path& part) { return fs::path(part).replace_extension(".log"); }
/// The file with the key of the running task, which survives a crash.
fs::path running_file(const fs::path& part) { return fs::path(part).replace_extension(".under_way"); }

/// Records that parts have written by now, each after the first line of its log.
std::size_t finished(const std::vector<fs::path>& parts) {
  std::size_t n = 0;
  for (const fs::path& part : parts) {
    if (!fs::exists(log_of(part))) continue;
    const std::string text = files::read_text(log_of(part));
    n +=
        static_cast<std::size_t>(std::max<std::ptrdiff_t>(std::count(text.begin(), text.end(), '\n'), 1) - 1);
  }
  return n;
}

void remove_part(const fs::path& part) {
  for (const fs::path& file : {part, log_of(part), running_file(part)}) fs::remove(file);
}

void run_parts(std::vector<trials::Task> rest, trials::TrialLog& log, const TrialsPlace& place,
               const Backend& backend) {
  const auto has_record = [&](const trials::Task& task) { return log.find(task.key) != nullptr; };
  std::erase_if(rest, has_record);
  if (rest.empty()) return;
  const std::size_t total = rest.size();
  ProgressLine progress(fmt::format("{}, {} trials", place.title, total));
  while (!rest.empty()) {
    std::vector<fs::path> parts = parts_in(place.folder);
    if (parts.empty()) parts = write_parts(rest, place, backend);
    CommandLines lines;
    for (const fs::path& part : parts)
      lines.push_back(
          {{"trials", fs::absolute(part).string(), "--models", fs::absolute(place.models).string()}});
    const std::size_t before = rest.size();
    const std::vector<Ended> ended = run_all(lines, backend, [&](double) {
      progress.show(static_cast<double>(total - before + finished(parts)) / static_cast<double>(total));
    });
    for (const fs::path& part : parts) {
      if (fs::exists(log_of(part)))
        for (const auto& [key, record] : trials::read_trial_log(log_of(part), place.purpose)) log.add(record);
      remove_part(part);
    }
    std::erase_if(rest, has_record);
    if (rest.size() < before) continue;
    std::set<std::string> printed;
    for (const Ended& one : ended)
      if (one.exit_code != 0 && printed.insert(one.complaint).second) std::cerr << one.complaint;
    return;
  }
}

struct TrialsRequest {
  fs::path tasks;
  fs::path models = standard_models();
  BatchMember batch;
};

void run_tasks(const TrialsRequest& request) {
  const trials::TaskFile file = trials::read_tasks(request.tasks);
  trials::TrialLog log(log_of(request.tasks), file.purpose);
  const Recordings recordings(request.models);
  // Successive trials mostly use the same recording.
  trials::Runner runner(false, {[&](const scenario::Scenario& s) { return recordings.key(s); },
                                [&](const scenario::ReadScenario& read, const auto& use) {
                                  use(recordings.get(read, [](double) {}).folder);
                                }});
  for (const trials::Task& task : file.tasks) {
    if (log.find(task.key)) continue;
    files::write_text(running_file(request.tasks), task.key);
    log.add(runner.run(task));
  }
}

/// Logs the crash of the running task. Throws UsageError if none was running.
void log_crash(const TrialsRequest& request, int signal) {
  const trials::TaskFile file = trials::read_tasks(request.tasks);
  const std::string running =
      fs::exists(running_file(request.tasks)) ? files::read_text(running_file(request.tasks)) : "";
  trials::TrialLog log(log_of(request.tasks), file.purpose);
  for (const trials::Task& task : file.tasks)
    if (task.key == running && !log.find(task.key))
      return log.add({task.key,
                      scenario::read_scenario_text(task.scenario, "task.yaml").scenario.seed,
                      "crashed",
                      fmt::format("killed by signal {} ({})", signal, strsignal(signal)),
                      {}});
  throw UsageError("{}: killed by signal {} before any trial", request.tasks.string(), signal);
}

/// A trial that crashes is logged, and the others continue in a new process.
int run_trials(TrialsRequest& request) {
  join_batch(request.batch);
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

void remove_parts(const fs::path& folder) {
  for (const fs::path& part : parts_in(folder)) remove_part(part);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

RunTrials in_processes(const TrialsPlace& place, const Backend& backend) {
  return [place, backend](const std::vector<trials::Task>& tasks, trials::TrialLog& log) {
    run_parts(tasks, log, place, backend);
  };
}

/// The hidden command that runs the tasks of a part.
void add_trials(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "trials", "Run the tasks of a file", "", run_trials);
  command.group("");
  command.add_option("tasks", request.tasks)->required();
  add_models(command, request.models);
  add_batch_member(command, request.batch);
}

}  // namespace cli
