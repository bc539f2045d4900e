// Jobs: command lines of this program with one record each, run by processes on this machine or as a job
// array of a Slurm cluster.
#pragma once

#include <sys/types.h>

#include <functional>
#include <vector>

#include "sim/result/job_log.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

/// A new temporary folder, removed by the destructor. Each also removes those of killed processes here.
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

/// Makes the kernel kill this process when its parent ends. For a process started with --die-with-parent.
void die_with(pid_t parent);

/// A word of a job's command line: the file with its scenario.
inline constexpr const char* kScenarioFile = "{scenario}";

/// A command line of this program, without its name, that accepts --die-with-parent.
struct Job {
  std::string key;  ///< differs if anything differs that the job depends on
  std::uint64_t seed = 0;
  std::vector<std::string> words;
  /// The command line takes one more word, a file of such jobs (jobs_in), and prints a record for each.
  bool batched = false;
  std::string scenario{};  ///< as YAML: as it is now, so that later edits change no waiting job
  std::map<std::string, std::string, std::less<>> origin{};  ///< of the keys of the scenario
  fs::path folder{};  ///< the result that it makes, or of a batched job the recording that it reads
  double cost = 1;    ///< relative to the other jobs, for the progress
};
void write_jobs(const fs::path& file, const std::vector<Job>& jobs);
std::vector<Job> jobs_in(const fs::path& file);
/// Printed by a process of batched jobs before each.
inline constexpr std::string_view kBegin = "begin ";

using result::JobRecord;
/// The ending of a job's process, by whether it made the folder; the cause is its standard error.
inline constexpr const char *kFinished = "finished", *kFailed = "failed";
/// Returns the exit code of a job's process, 3 when a signal killed it; 0 of a job that was not run.
int exit_code_of(const JobRecord& record);

/// Throws files::DeviceError with the last line of a process that ended with kDeviceFailed.
[[noreturn]] void fail_by_device(std::string_view complaint);

/// Called with the part of the work that is done, 0 to 1.
using ShowPart = std::function<void(double)>;
/// Called with each record as soon as a job has ended.
using OnRecord = std::function<void(const JobRecord&)>;

struct Backend {
  std::string name = "local";
  int jobs = 0;  ///< processes or array elements at a time; 0: one here, all that the cluster allows there
  /// Slurm: a folder that all nodes see. What an interrupted command left there is continued.
  fs::path spool{};
  double seconds_each = 30;  ///< Slurm: a lower bound of the time of a job that is not batched

  bool slurm() const { return name == "slurm"; }
};

/// Runs the jobs with one progress line; the reason why a batched job could not be run, and has no record, is
/// on standard error. Throws UsageError.
void run_jobs(const std::vector<Job>& jobs, const Backend& backend, const std::string& title,
              const OnRecord& on_record);

/// Runs the jobs in that many processes at a time, of this program even if its file was replaced.
void run_here(const std::vector<Job>& jobs, int processes, const ShowPart& show, const OnRecord& on_record);

/// Runs the jobs as a job array with elements of at least half a minute, restarted if their node is lost.
/// After a kill the same call continues with the array.
void run_on_slurm(std::vector<Job> jobs, const Backend& backend, const ShowPart& show,
                  const OnRecord& on_record);

/// An element of such an array: its folder, and how many jobs each element runs.
struct ElementRequest {
  fs::path folder;
  std::size_t each = 1;
};
/// Runs the share of this process, an array element, and logs the records. Returns the exit code.
int run_element(ElementRequest& request);

/// Removes a job array that an earlier call left. Throws UsageError if it may still run.
void clear_spool(const fs::path& spool);

/// The most batched jobs of a process: half a minute, enough for an array element.
inline constexpr std::size_t kMostOfBatch = 32;

}  // namespace cli
