#include <iostream>

#include "sim/trials/trial.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

struct TrialsRequest {
  fs::path jobs;
  fs::path models = standard_models();
  BatchMember batch;
};

int run_trials(TrialsRequest& request) {
  join_batch(request.batch);
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
  for (const Job& job : jobs_in(request.jobs)) {
    std::cout << kBegin << job.key << std::endl;
    const trials::Task task{job.key, job.seed, job.scenario, job.folder};
    std::cout << to_line(run_task(task, [&](const auto& read) { return recording_of(job.folder, read); }))
              << std::endl;
  }
  return 0;
}

}  // namespace

trials::RunTasks in_processes(const fs::path& models, const std::string& title, const Backend& backend) {
  return [=](const std::vector<trials::Task>& tasks, result::JobLog& log) {
    std::vector<Job> jobs;
    for (const trials::Task& task : tasks)
      if (!log.find(task.key))
        jobs.push_back({.key = task.key,
                        .seed = task.seed,
                        .words = {"trials", "--models", fs::absolute(models).string()},
                        .batched = true,
                        .scenario = task.scenario,
                        .folder = task.recording});
    run_jobs(jobs, backend, fmt::format("{}, {} trials", title, jobs.size()),
             [&](const JobRecord& record) { log.add(record); });
  };
}

/// The hidden command that runs the trials of a file.
void add_trials(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "trials", "Run the trials of a file", "", run_trials);
  command.group("");
  command.add_option("jobs", request.jobs)->required();
  add_models(command, request.models);
  add_batch_member(command, request.batch);
}

}  // namespace cli
