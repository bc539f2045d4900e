#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <set>
#include <sstream>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "tools/cli/jobs/backend.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {
namespace {

namespace fs = std::filesystem;

constexpr double kElementSeconds = 30;  // a shorter element is not worth the cost of starting it
constexpr int kSubmissions = 3, kDefaultMaxArraySize = 1001;
constexpr useconds_t kQueuePollUs = 1'000'000;
constexpr int kSilentPolls = 600;  // squeue may fail for so long, as while a controller restarts

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

std::string rest_of(std::FILE* stream) {
  std::string text;
  std::array<char, 4096> piece;
  for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), stream)) > 0;)
    text.append(piece.data(), n);
  return text;
}

/// Throws UsageError if the shell cannot be started.
ShellOutput run_shell(const std::string& command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> errors(std::tmpfile(), std::fclose);
  const std::string redirected =
      errors ? fmt::format("{} 2>/proc/{}/fd/{}", command, ::getpid(), ::fileno(errors.get())) : command;
  FILE* const pipe = ::popen(redirected.c_str(), "r");
  if (!pipe) throw UsageError(command + ": cannot be started");
  ShellOutput printed{rest_of(pipe), "", 0};
  printed.status = ::pclose(pipe);
  if (errors) {
    std::rewind(errors.get());
    printed.errors = rest_of(errors.get());
  }
  return printed;
}

/// The lines of a text as one line.
std::string one_line(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos;) text.replace(at, 1, "; ");
  return text;
}

/// The job id in the standard output of `sbatch --parsable`: a line "id" or "id;cluster". Empty if there is
/// none.
std::string job_id(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string id = line.substr(0, line.find(';'));
    if (!id.empty() && id.find_first_not_of("0123456789") == id.npos) return id;
  }
  return "";
}

/// The state of a job as squeue reports it. An unknown job counts as queued: nothing is submitted again for
/// it.
struct Queue {
  bool may_have_job = false;
  std::string lines;   ///< "STATE REASON", one for each element or group of elements
  std::string failed;  ///< the error message of squeue
};

/// Slurm forgets a job some minutes after its end and then calls its id invalid.
Queue queue_of(const std::string& job) {
  const ShellOutput shown = run_shell("squeue -h -j " + sim::files::shell_word(job) + " -o '%T %r'");
  if (shown.status == 0) return {!shown.text.empty(), shown.text, ""};
  if (shown.errors.find("Invalid job id") != shown.errors.npos) return {};
  return {true, "",
          shown.errors.empty() ? fmt::format("exit status {}", shown.status) : one_line(shown.errors)};
}

std::string text_if_there(const fs::path& file) {
  return fs::exists(file) ? sim::files::read_text(file) : "";
}

/// The largest size of a job array; 1001 if Slurm does not report it.
int max_array_size() {
  const std::string text = run_shell("scontrol show config").text;
  const std::size_t at = text.find("MaxArraySize");
  int size = kDefaultMaxArraySize;
  if (at == text.npos) return size;
  const std::size_t digits = text.find_first_of("0123456789", at);
  if (digits != text.npos) std::from_chars(text.data() + digits, text.data() + text.size(), size);
  return size;
}

fs::path this_program() {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  if (!fs::exists(program))
    throw UsageError("the program's file was replaced while it ran; run the command again");
  return program;
}

std::string shell_lines(const CommandLines& lines) {
  const std::string program = sim::files::shell_word(this_program().string());
  std::string text;
  for (const auto& line : lines) {
    text += program;
    for (const std::string& word : line.words) {
      require_usable({"slurm"}, word);
      text += " " + sim::files::shell_word(word);
    }
    text += '\n';
  }
  return text;
}

/// Slurm's reason why no element of a job runs, from lines "STATE REASON". Empty if an element runs or the
/// job only waits for others.
std::string waits_for(const std::string& queue) {
  static const std::set<std::string> kPassing{"None", "Priority", "Resources", "BeginTime",
                                              "JobArrayTaskLimit"};
  std::istringstream lines(queue);
  std::string reason;
  for (std::string state, why; lines >> state && std::getline(lines >> std::ws, why);) {
    if (state != "PENDING") return "";
    if (!kPassing.contains(why)) reason = why;
  }
  return reason;
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

bool may_run(const fs::path& array) {
  const std::string job = text_if_there(array / "job");
  return !job.empty() && queue_of(job).may_have_job;
}

/// A job array and its folder.
class Array {
 public:
  Array(const CommandLines& lines, const Backend& backend)
      : backend_(backend), lines_(lines), count_(lines.size()), folder_(folder(shell_lines(lines), backend)) {
    const auto least =
        static_cast<std::size_t>(std::ceil(kElementSeconds / std::max(backend.seconds_each, 0.1)));
    const auto most_elements = static_cast<std::size_t>(std::max(max_array_size() - 1, 1));
    each_ = std::max(least, (count_ + most_elements - 1) / most_elements);
    fs::create_directories(folder_ / "ended");
    sim::files::write_atomically(folder_ / "lines", shell_lines(lines));
    sim::files::write_atomically(folder_ / "element.sh", kElement);
  }

  /// True if the job, possibly one of a killed command, is in the queue or squeue fails. Prints once
  /// why a blocked job waits. Throws UsageError if squeue fails for ten minutes.
  bool is_in_queue() {
    const std::string job = text_if_there(folder_ / "job");
    if (job.empty()) return false;
    const Queue queue = queue_of(job);
    failures_ = queue.failed.empty() ? 0 : failures_ + 1;
    const std::string reason =
        queue.failed.empty() ? waits_for(queue.lines) : "squeue fails: " + queue.failed;
    if (failures_ > kSilentPolls)
      throw UsageError(
          fmt::format("{}; job {} and its folder {} are kept, and the same command continues with it", reason,
                      job, folder_.string()));
    if (!reason.empty() && said_.insert(reason).second)
      std::cerr << fmt::format(
          "slurm: job {} waits: {} (squeue -j {}). After Ctrl-C it stays in the queue, and the same command "
          "continues with it.\n",
          job, reason, job);
    return queue.may_have_job;
  }

  void submit() const {
    const std::string elements = missing_elements();
    const ShellOutput printed =
        run_shell(fmt::format("sbatch --parsable --requeue --ntasks=1 --cpus-per-task=1 --job-name=gaitslam "
                              "--array={}{} --output={} {} {} {}",
                              elements, backend_.jobs > 0 ? fmt::format("%{}", backend_.jobs) : "",
                              sim::files::shell_word((folder_ / "element-%a.log").string()),
                              sim::files::shell_word((folder_ / "element.sh").string()),
                              sim::files::shell_word(folder_.string()), each_));
    const std::string job = job_id(printed.text);
    if (printed.status != 0 || job.empty())
      throw UsageError(fmt::format("sbatch: {}", one_line(printed.errors + printed.text)));
    sim::files::write_atomically(folder_ / "job", job);
    std::cerr << printed.errors
              << fmt::format(
                     "slurm job {}: array elements {} with {} command lines each. After an interruption the "
                     "same command continues with it.\n",
                     job, elements, each_);
  }

  std::size_t ended() const {
    std::size_t n = 0;
    for (std::size_t i = 0; i < count_; ++i) n += has_ended(i) ? 1 : 0;
    return n;
  }
  std::size_t size() const { return count_; }
  double part() const {
    return part_of_cost(
        lines_, [&](std::size_t i) { return has_ended(i) ? 1 : part_in(ended_file(i).string() + ".part"); });
  }

  std::vector<Ended> collect() const {
    std::vector<Ended> all;
    for (std::size_t i = 0; i < count_; ++i) all.push_back(outcome(i));
    return all;
  }
  void remove() const { fs::remove_all(folder_); }

 private:
  static fs::path folder(const std::string& lines, const Backend& backend) {
    sim::files::Hash hash;
    hash.add(lines);
    return fs::absolute(backend.spool) / ("array-" + hash.hex().substr(0, 12));
  }

  fs::path ended_file(std::size_t i) const { return folder_ / "ended" / std::to_string(i + 1); }
  bool has_ended(std::size_t i) const { return fs::exists(ended_file(i)); }

  /// "0,3,7": the elements with a line that has not ended.
  std::string missing_elements() const {
    std::string text;
    for (std::size_t element = 0; element * each_ < count_; ++element)
      for (std::size_t i = element * each_; i < std::min(count_, (element + 1) * each_); ++i)
        if (!has_ended(i)) {
          text += (text.empty() ? "" : ",") + std::to_string(element);
          break;
        }
    return text;
  }

  Ended outcome(std::size_t i) const {
    const fs::path file = ended_file(i);
    if (!fs::exists(file))
      return {3, fmt::format("its array element ended before it ran: {}",
                             text_if_there(folder_ / fmt::format("element-{}.log", i / each_)))};
    const std::string complaint = text_if_there(file.string() + ".err");
    const int code = std::stoi("0" + text_if_there(file));
    return {code < 128 ? code : 3,
            code < 128 ? complaint : complaint + fmt::format("killed by signal {}\n", code - 128)};
  }

  const Backend& backend_;
  const CommandLines& lines_;
  std::size_t count_, each_ = 1;
  fs::path folder_;
  std::set<std::string> said_;
  int failures_ = 0;  ///< of squeue, one after another
};

}  // namespace

void require_ended_arrays(const fs::path& spool) {
  for (const fs::path& array : arrays_in(spool))
    if (may_run(array))
      throw UsageError(fmt::format(
          "{}: belongs to the Slurm job {}, which may still run; wait for it, or end it with scancel",
          array.string(), text_if_there(array / "job")));
}

void remove_arrays(const fs::path& spool) {
  std::error_code fault;
  for (const fs::path& array : arrays_in(spool))
    if (!may_run(array)) fs::remove_all(array, fault);
  fs::remove(spool, fault);
}

std::vector<Ended> run_on_slurm(const CommandLines& command_lines, const Backend& backend,
                                const ShowPart& show) {
  Array array(command_lines, backend);
  for (int submissions = 0;; ++submissions) {
    while (array.is_in_queue()) {
      show(array.part());
      usleep(kQueuePollUs);
    }
    if (array.ended() == array.size() || submissions == kSubmissions) break;
    array.submit();
  }
  std::vector<Ended> all = array.collect();
  array.remove();
  return all;
}

}  // namespace cli
