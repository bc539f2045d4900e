#include "tools/cli/jobs/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <set>

#include "sim/files/text.h"
#include "tools/cli/jobs/progress.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace trials = sim::trials;

constexpr std::size_t kMostTasks = 32;  // of a part: half a minute, enough for an array element

std::vector<fs::path> parts_in(const fs::path& folder) {
  std::vector<fs::path> parts;
  if (!fs::exists(folder)) return parts;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".tasks") parts.push_back(entry.path());
  std::sort(parts.begin(), parts.end());
  return parts;
}

/// As few parts as keep all processes equally busy, because each part decodes its recording.
std::size_t tasks_of_part(std::size_t n, const Backend& backend) {
  if (backend.slurm()) return kMostTasks;
  const auto up = [](std::size_t a, std::size_t b) { return (a + b - 1) / b; };
  const auto jobs = static_cast<std::size_t>(std::max(backend.jobs, 1));
  return up(n, jobs * up(n, jobs * kMostTasks));
}

std::vector<fs::path> write_parts(const std::vector<trials::Task>& tasks, const TrialsPlace& place,
                                  const Backend& backend) {
  fs::create_directories(place.folder);
  const std::size_t each = tasks_of_part(tasks.size(), backend);
  for (std::size_t first = 0; first < tasks.size(); first += each) {
    const auto begin = tasks.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(std::min(each, tasks.size() - first));
    trials::write_tasks(place.folder / fmt::format("{:06}.tasks", first), {place.purpose, {begin, end}});
  }
  return parts_in(place.folder);
}

fs::path log_of(const fs::path& part) { return fs::path(part).replace_extension(".log"); }

std::size_t lines_of(const fs::path& file) {
  if (!fs::exists(file)) return 0;
  const std::string text = sim::files::read_text(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Records that parts have written by now.
std::size_t finished(const std::vector<fs::path>& parts) {
  std::size_t n = 0;
  for (const fs::path& part : parts) n += std::max<std::size_t>(lines_of(log_of(part)), 1) - 1;
  return n;
}

void remove_part(const fs::path& part) {
  for (const char* file : {".tasks", ".log", ".under_way"})
    fs::remove(fs::path(part).replace_extension(file));
}

/// Moves the records of the parts to the log, then removes the parts.
void collect(const std::vector<fs::path>& parts, trials::TrialLog& log, const TrialsPlace& place) {
  for (const fs::path& part : parts) {
    if (fs::exists(log_of(part)))
      for (const auto& [key, record] : trials::read_trial_log(log_of(part), place.purpose)) log.add(record);
    remove_part(part);
  }
}

std::vector<trials::Task> left(const std::vector<trials::Task>& tasks, const trials::TrialLog& log) {
  std::vector<trials::Task> without_record;
  for (const trials::Task& task : tasks)
    if (!log.find(task.key)) without_record.push_back(task);
  return without_record;
}

void print_each_complaint_once(const std::vector<Ended>& ended) {
  std::set<std::string> printed;
  for (const Ended& one : ended)
    if (one.exit_code != 0 && printed.insert(one.complaint).second) std::cerr << one.complaint;
}

void run_parts(const std::vector<trials::Task>& tasks, trials::TrialLog& log, const TrialsPlace& place,
               const Backend& backend) {
  std::vector<trials::Task> rest = left(tasks, log);
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
    collect(parts, log, place);
    rest = left(tasks, log);
    if (rest.size() == before) return print_each_complaint_once(ended);
  }
}

}  // namespace

void remove_parts(const fs::path& folder) {
  for (const fs::path& part : parts_in(folder)) remove_part(part);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

trials::RunTasks in_processes(const TrialsPlace& place, const Backend& backend) {
  return [place, backend](const std::vector<trials::Task>& tasks, trials::TrialLog& log) {
    run_parts(tasks, log, place, backend);
  };
}

}  // namespace cli
