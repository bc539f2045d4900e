// Jobs: command lines of this program that each produce one record. They run in processes on this machine or
// as a job array on a Slurm cluster.
#pragma once

#include <sys/types.h>

#include <functional>
#include <vector>

#include "sim/result/job_log.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

/// A new temporary folder, removed by the destructor. The constructor also removes folders of killed
/// processes.
class TemporaryFolder {
 public:
  TemporaryFolder();
  fs::path operator/(const std::string& name) const { return folder_.path() / name; }

 private:
  files::AtomicFolder folder_;  ///< never committed
};

/// Standard output, standard error and exit status of a shell command.
struct ShellOutput {
  std::string text, errors;
  int status = 0;
};
ShellOutput run_shell(const std::string& command);

/// Makes the kernel kill this process when its parent ends; for processes started with --die-with-parent.
void die_with(pid_t parent);

/// Placeholder in a job's command line for the file with its scenario.
inline constexpr const char* kScenarioFile = "{scenario}";

/// A command line of this program, without its name, that accepts --die-with-parent. Its process leaves one
/// result, which appears by renaming.
struct Job {
  std::string key;  ///< changes if anything changes that the job depends on
  std::uint64_t seed = 0;
  std::vector<std::string> words;
  /// Several jobs share a process. Its command line gets two more arguments: a file of jobs (jobs_in), and
  /// the file of records to write.
  bool batched = false;
  std::string scenario{};  ///< a YAML snapshot, so that later edits do not affect waiting jobs
  std::map<std::string, std::string, std::less<>> origin{};  ///< origins of the scenario's keys
  fs::path recording{};  ///< the recording that a batched job reads; empty: one in the cache
  double cost = 1;       ///< relative to the other jobs, for the progress
  fs::path program{};    ///< another build of this program; empty: this one
};
/// Writes one line of JSON per job. Throws FileError.
void write_jobs(const fs::path& file, const std::vector<Job>& jobs);
/// Reads the jobs that write_jobs wrote. Throws FileError.
std::vector<Job> jobs_in(const fs::path& file);

using result::JobRecord;
/// Returns the exit code of a job's process: 3 if a signal killed it, 0 if the job was not run. The record's
/// cause is the process's standard error.
int exit_code_of(const JobRecord& record);

/// Throws files::DeviceError with the last line of a process that ended with kDeviceFailed.
[[noreturn]] void fail_by_device(std::string_view complaint);

/// Called with the fraction of the work that is done, 0 to 1.
using ShowPart = std::function<void(double)>;
/// Called with the records of a process when it has ended.
using OnRecords = std::function<void(const std::vector<JobRecord>&)>;

struct Backend {
  std::string name = "local";
  int jobs = 0;  ///< processes or array elements at a time; 0: one locally, or as many as the cluster allows
  /// Slurm: a folder that all nodes can access. Work left there by an interrupted command is continued.
  fs::path spool{};
  double seconds_each = 30;  ///< Slurm: a lower bound on the duration of a job that is not batched

  bool slurm() const { return name == "slurm"; }
};

/// Runs the jobs with one progress line. If a batched job could not be run, it has no record, and the reason
/// is printed on standard error. Throws UsageError.
void run_jobs(const std::vector<Job>& jobs, const Backend& backend, const std::string& title,
              const OnRecords& on_records);

/// Runs the jobs in up to `processes` processes of this program, even if its file has been replaced. Jobs of
/// a process that failed run once more, each in its own process.
void run_here(const std::vector<Job>& jobs, int processes, const ShowPart& show, const OnRecords& on_records);

/// Runs the jobs as a job array. Elements take at least half a minute and are restarted if their node is
/// lost. If this process is killed, the same call continues with the array.
void run_on_slurm(std::vector<Job> jobs, const Backend& backend, const ShowPart& show,
                  const OnRecords& on_records);

/// An element of a job array: the array's folder, and how many jobs each element runs.
struct ElementRequest {
  fs::path folder;
  std::size_t each = 1;
};
/// Runs this array element's share of the jobs and writes the records. Returns the exit code.
int run_element(ElementRequest& request);

/// Removes a job array left by an earlier call. Throws UsageError if it may still run.
void clear_spool(const fs::path& spool);

/// Maximum number of batched jobs per process, which are lost if a command is killed.
inline constexpr std::size_t kMostOfBatch = 8;

}  // namespace cli
