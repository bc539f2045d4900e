// Jobs: command lines of this program that each produce one record. They run in processes on this machine or
// as a job array on a Slurm cluster.
#pragma once

#include <sys/types.h>

#include <functional>
#include <vector>

#include "sim/result/job_log.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

/// A new temporary folder, removed by the destructor. The constructor also removes those of killed processes.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
  std::optional<files::FileLock> lock_;
};

/// Makes the kernel kill this process when its parent ends; for processes started with --die-with-parent.
void die_with(pid_t parent);

/// Placeholder in a job's command line for the file with its scenario.
inline constexpr const char* kScenarioFile = "{scenario}";

/// A command line of this program, without its name, that accepts --die-with-parent.
struct Job {
  std::string key;  ///< changes if anything changes that the job depends on
  std::uint64_t seed = 0;
  std::vector<std::string> words;
  /// The command line gets one more argument, a file of jobs (jobs_in), and prints a record for each of them.
  bool batched = false;
  std::string scenario{};  ///< a YAML snapshot, so that later edits do not affect waiting jobs
  std::map<std::string, std::string, std::less<>> origin{};  ///< origins of the scenario's keys
  fs::path folder{};  ///< the result that it makes; for a batched job, the recording that it reads
  double cost = 1;    ///< relative to the other jobs, for the progress
};
void write_jobs(const fs::path& file, const std::vector<Job>& jobs);
std::vector<Job> jobs_in(const fs::path& file);
/// Printed before each job by a process that runs a batch.
inline constexpr std::string_view kBegin = "begin ";

using result::JobRecord;
/// Endings of a job's process: finished if it made the folder, else failed; the cause is its standard error.
inline constexpr const char *kFinished = "finished", *kFailed = "failed";
/// Returns the exit code of a job's process: 3 if a signal killed it, 0 if the job was not run.
int exit_code_of(const JobRecord& record);

/// Throws files::DeviceError with the last line of a process that ended with kDeviceFailed.
[[noreturn]] void fail_by_device(std::string_view complaint);

/// Called with the fraction of the work that is done, 0 to 1.
using ShowPart = std::function<void(double)>;
/// Called with each record as soon as a job has ended.
using OnRecord = std::function<void(const JobRecord&)>;

struct Backend {
  std::string name = "local";
  int jobs = 0;  ///< processes or array elements at a time; 0: one locally, or as many as the cluster allows
  /// Slurm: a folder that all nodes can access. Work that an interrupted command left there is continued.
  fs::path spool{};
  double seconds_each = 30;  ///< Slurm: a lower bound on the duration of a job that is not batched

  bool slurm() const { return name == "slurm"; }
};

/// Runs the jobs with one progress line. If a batched job could not be run, it has no record, and the reason
/// is printed on standard error. Throws UsageError.
void run_jobs(const std::vector<Job>& jobs, const Backend& backend, const std::string& title,
              const OnRecord& on_record);

/// Runs the jobs in up to `processes` processes of this program, even if its file has been replaced.
void run_here(const std::vector<Job>& jobs, int processes, const ShowPart& show, const OnRecord& on_record);

/// Runs the jobs as a job array. Elements take at least half a minute and are restarted if their node is
/// lost. If this process is killed, the same call continues with the array.
void run_on_slurm(std::vector<Job> jobs, const Backend& backend, const ShowPart& show,
                  const OnRecord& on_record);

/// An element of a job array: the array's folder, and how many jobs each element runs.
struct ElementRequest {
  fs::path folder;
  std::size_t each = 1;
};
/// Runs this array element's share of the jobs and logs the records. Returns the exit code.
int run_element(ElementRequest& request);

/// Removes a job array that an earlier call left. Throws UsageError if it may still run.
void clear_spool(const fs::path& spool);

/// Maximum number of batched jobs per process: about half a minute, enough for an array element.
inline constexpr std::size_t kMostOfBatch = 32;

}  // namespace cli
