#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <set>
#include <sstream>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "tools/cli/jobs/backend.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/terminal.h"

namespace cli {
namespace {

constexpr double kElementSeconds = 30;  // a shorter element is not worth the cost of starting it
constexpr int kSubmissions = 3;
constexpr std::size_t kMostElements = 1000;  // of Slurm's default MaxArraySize, 1001
constexpr useconds_t kQueuePollUs = 1'000'000;

/// Each element runs its share of the lines, one after another, and records atomically that a line has ended.
/// A line during which the element itself ended (node lost, requeued) is run again, five times at most.
constexpr const char* kElement = R"sh(#!/bin/sh
spool=$1 each=$2
i=$((SLURM_ARRAY_TASK_ID * each))
last=$((i + each))
while [ $i -lt $last ]; do
  i=$((i + 1))
  line=$(sed -n "${i}p" "$spool/lines")
  [ -n "$line" ] || exit 0
  ended=$spool/ended/$i
  [ ! -e "$ended" ] || continue
  echo "${SLURMD_NODENAME:-a node}" >>"$ended.tries"
  if [ "$(wc -l <"$ended.tries")" -gt 5 ]; then
    echo "aborted: its array element ended during it on $(tr '\n' ' ' <"$ended.tries")" >"$ended.err"
    code=3
  else
    code=0
    GAITSLAM_PROGRESS_FILE=$ended.part
    export GAITSLAM_PROGRESS_FILE
    eval "$line" </dev/null >/dev/null 2>"$ended.err" || code=$?
    [ $code -ne 75 ] || exit 75
  fi
  echo $code >"$ended.new"
  mv "$ended.new" "$ended"
done
)sh";

/// Standard output, standard error and exit status of a shell command.
struct ShellOutput {
  std::string text, errors;
  int status = 0;
};

ShellOutput run_shell(const std::string& command) {
  const TemporaryFolder scratch;
  const std::string text = (scratch / "text").string(), errors = (scratch / "errors").string();
  std::FILE* const shell = ::popen(
      fmt::format("{} >{} 2>{}", command, files::shell_word(text), files::shell_word(errors)).c_str(), "w");
  const int status = shell ? ::pclose(shell) : -1;
  return {files::read_text(text), files::read_text(errors), status};
}

/// The job id in the output of `sbatch --parsable`: a line "id" or "id;cluster", if there is one.
std::optional<std::string> job_id(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const std::string id = line.substr(0, line.find(';')); files::parse_number<std::uint64_t>(id))
      return id;
  return std::nullopt;
}

/// True if squeue lists the job or fails: nothing is submitted again for an unknown job. Slurm forgets a job
/// some minutes after its end and then calls its id invalid.
bool may_run(const std::string& job) {
  if (job.empty()) return false;
  const ShellOutput shown = run_shell("squeue -h -j " + files::shell_word(job));
  if (shown.status == 0) return !shown.text.empty();
  return shown.errors.find("Invalid job id") == shown.errors.npos;
}

std::string text_if_there(const fs::path& file) { return fs::exists(file) ? files::read_text(file) : ""; }

std::string shell_lines(const CommandLines& lines) {
  const fs::path file = fs::read_symlink("/proc/self/exe");
  if (!fs::exists(file))
    throw UsageError("the program's file was replaced while it ran; run the command again");
  const std::string program = files::shell_word(file.string());
  std::string text;
  for (const auto& line : lines) {
    text += program;
    for (const std::string& word : line.words) {
      require_usable({"slurm"}, word);
      text += " " + files::shell_word(word);
    }
    text += '\n';
  }
  return text;
}

std::vector<fs::path> arrays_in(const fs::path& spool) {
  std::vector<fs::path> arrays;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(spool, fault))
    if (entry.path().filename().string().starts_with("array-") &&
        fs::exists(entry.path() / "element.sh", fault))
      arrays.push_back(entry.path());
  return arrays;
}

/// A job array and its folder.
class Array {
 public:
  Array(const CommandLines& lines, const Backend& backend) : backend_(backend), lines_(lines) {
    const std::string text = shell_lines(lines);
    files::Hash hash;
    hash.add(text);
    folder_ = fs::absolute(backend.spool) / ("array-" + hash.hex().substr(0, 12));
    const auto least =
        static_cast<std::size_t>(std::ceil(kElementSeconds / std::max(backend.seconds_each, 0.1)));
    each_ = std::max(least, (lines.size() + kMostElements - 1) / kMostElements);
    fs::create_directories(folder_ / "ended");
    files::write_atomically(folder_ / "lines", text);
    files::write_atomically(folder_ / "element.sh", kElement);
  }

  /// True if the job, possibly one of a killed command, may be in the queue.
  bool is_in_queue() const { return may_run(text_if_there(folder_ / "job")); }

  /// The elements with a line that has not ended.
  std::set<std::size_t> missing() const {
    std::set<std::size_t> elements;
    for (std::size_t i = 0; i < lines_.size(); ++i)
      if (!has_ended(i)) elements.insert(i / each_);
    return elements;
  }

  void submit() const {
    const std::string elements = fmt::format("{}", fmt::join(missing(), ","));
    const ShellOutput printed = run_shell(fmt::format(
        "sbatch --parsable --requeue --ntasks=1 --cpus-per-task=1 --job-name=gaitslam "
        "--array={}{} --output={} {} {} {}",
        elements, backend_.jobs > 0 ? fmt::format("%{}", backend_.jobs) : "",
        files::shell_word((folder_ / "element-%a.log").string()),
        files::shell_word((folder_ / "element.sh").string()), files::shell_word(folder_.string()), each_));
    const std::optional<std::string> job = job_id(printed.text);
    if (printed.status != 0 || !job) {
      std::string why = printed.errors + printed.text;
      std::replace(why.begin(), why.end(), '\n', ' ');
      throw UsageError("sbatch: " + why);
    }
    files::write_atomically(folder_ / "job", *job);
    std::cerr << printed.errors
              << fmt::format(
                     "slurm job {}: array elements {} with {} command lines each. After an interruption the "
                     "same command continues with it.\n",
                     *job, elements, each_);
  }

  double part() const {
    return part_of_cost(
        lines_, [&](std::size_t i) { return has_ended(i) ? 1 : part_in(ended_file(i).string() + ".part"); });
  }

  /// How each line ended. Removes the folder.
  std::vector<Exited> collect() const {
    std::vector<Exited> all;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const std::string file = ended_file(i);
      const int code = has_ended(i) ? std::stoi("0" + text_if_there(file)) : 3;
      all.push_back({code < 128 ? code : 3,
                     has_ended(i) ? text_if_there(file + ".err")
                                  : "its array element ended before it ran: " +
                                        text_if_there(folder_ / fmt::format("element-{}.log", i / each_))});
      if (code < 128) continue;
      all.back().signal = code - 128;
      all.back().complaint += fmt::format("killed by signal {}\n", code - 128);
    }
    fs::remove_all(folder_);
    return all;
  }

 private:
  fs::path ended_file(std::size_t i) const { return folder_ / "ended" / std::to_string(i + 1); }
  bool has_ended(std::size_t i) const { return fs::exists(ended_file(i)); }

  const Backend& backend_;
  const CommandLines& lines_;
  std::size_t each_ = 1;  ///< lines of an element
  fs::path folder_;
};

}  // namespace

void require_ended_arrays(const fs::path& spool) {
  for (const fs::path& array : arrays_in(spool))
    if (may_run(text_if_there(array / "job")))
      throw UsageError(
          "{}: belongs to the Slurm job {}, which may still run; wait for it, or end it with scancel",
          array.string(), text_if_there(array / "job"));
}

void remove_arrays(const fs::path& spool) {
  std::error_code fault;
  for (const fs::path& array : arrays_in(spool))
    if (!may_run(text_if_there(array / "job"))) fs::remove_all(array, fault);
  fs::remove(spool, fault);
}

std::vector<Exited> run_on_slurm(const CommandLines& command_lines, const Backend& backend,
                                 const ShowPart& show) {
  const Array array(command_lines, backend);
  for (int submissions = 0;; ++submissions) {
    while (array.is_in_queue()) {
      show(array.part());
      usleep(kQueuePollUs);
    }
    if (array.missing().empty() || submissions == kSubmissions) break;
    array.submit();
  }
  return array.collect();
}

}  // namespace cli
