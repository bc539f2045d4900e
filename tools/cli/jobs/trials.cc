#include <fmt/format.h>

#include <algorithm>
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
/// The file with the running task, which survives a crash.
fs::path running_file(const fs::path& part) { return fs::path(part).replace_extension(".under_way"); }

void remove_part(const fs::path& part) {
  for (const fs::path& file : {part, log_of(part), running_file(part)}) fs::remove(file);
}

/// Logs the crash of the task that ran when a signal killed the process of the part.
void log_crash(const fs::path& part, int signal, result::JobLog& log) {
  if (signal == 0 || !fs::exists(running_file(part))) return;
  const trials::Task task = trials::read_tasks(running_file(part)).tasks.at(0);
  log.add({task.key,
           scenario::read_scenario_text(task.scenario, "task.yaml").scenario.seed,
           "crashed",
           fmt::format("killed by signal {} ({})", signal, strsignal(signal)),
           {}});
}

/// After a crash, the tasks without a record are run in new parts.
void run_parts(std::vector<trials::Task> rest, result::JobLog& log, const TrialsPlace& place,
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
    const std::vector<Exited> ended = run_all(lines, backend, [&](double part) {
      progress.show(1 - (1 - part) * static_cast<double>(before) / static_cast<double>(total));
    });
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (fs::exists(log_of(parts[i])))
        for (const auto& [key, record] : result::read_job_log(log_of(parts[i]), place.purpose))
          log.add(record);
      log_crash(parts[i], ended[i].signal, log);
      remove_part(parts[i]);
    }
    std::erase_if(rest, has_record);
    if (rest.size() < before) continue;
    std::set<std::string> printed;
    for (const Exited& one : ended)
      if (one.exit_code != 0 && printed.insert(one.complaint).second) std::cerr << one.complaint;
    return;
  }
}

struct TrialsRequest {
  fs::path tasks;
  fs::path models = standard_models();
  BatchMember batch;
};

int run_trials(TrialsRequest& request) {
  join_batch(request.batch);
  const trials::TaskFile file = trials::read_tasks(request.tasks);
  result::JobLog log(log_of(request.tasks), file.purpose);
  const Recordings recordings(request.models);
  std::string loaded;  // successive trials mostly use the same recording
  std::shared_ptr<const trials::Recording> recording;
  const auto recording_of = [&](const fs::path& named, const scenario::ReadScenario& read) {
    const std::string name = named.empty() ? recordings.key(read.scenario) : named.string();
    if (name == loaded) return recording;
    loaded.clear(), recording.reset();
    std::optional<recording::CachedRecording> cached;  // in use
    if (named.empty()) cached.emplace(recordings.get(read, [](double) {}));
    recording = std::make_shared<const trials::Recording>(trials::load(cached ? cached->folder : named));
    loaded = name;
    return recording;
  };
  ProgressLine progress("trials");
  for (const trials::Task& task : file.tasks) {
    if (log.find(task.key)) continue;
    trials::write_tasks(running_file(request.tasks), {file.purpose, {task}});
    log.add(run_task(task, [&](const auto& read) { return recording_of(task.recording, read); }));
    progress.show(static_cast<double>(log.size()) / static_cast<double>(file.tasks.size()));
  }
  return 0;
}

}  // namespace

void remove_parts(const fs::path& folder) {
  for (const fs::path& part : parts_in(folder)) remove_part(part);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

RunTrials in_processes(const TrialsPlace& place, const Backend& backend) {
  return [place, backend](const std::vector<trials::Task>& tasks, result::JobLog& log) {
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
