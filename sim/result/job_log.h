// The log of finished jobs, used for results and trials. Each job is on disk before the next one starts, so
// that a killed command can be resumed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "sim/files/atomic_file.h"

namespace sim::result {

/// The result of one job. Values are finite and written so that they read back to the same bits.
struct JobRecord {
  std::string key;  ///< for a trial: job_key() of all its inputs; for a result: its path
  std::uint64_t seed = 0;
  std::string ending;                    ///< ending of a result folder, or "crashed" or "not started"
  std::string cause;                     ///< cause of a failure, as a sentence
  std::map<std::string, double> values;  ///< metrics and objective terms that have a value
  bool operator==(const JobRecord&) const = default;

  /// Returns the value with that name, or nothing if there is none.
  std::optional<double> value(std::string_view name) const;
};

/// Returns a record as one line of JSON, without a line feed.
std::string to_line(const JobRecord& record);
/// Returns the record in a line, or nothing if the line is not one.
std::optional<JobRecord> from_line(std::string_view line);

/// Returns a hash (32 hex digits) of the parts that a job depends on. It also depends on where parts begin
/// and end.
std::string job_key(std::initializer_list<std::string_view> parts);

/// An append-only file of records, written by one process at a time. Safe to use from several threads.
class JobLog {
 public:
  /// Opens or creates the log and removes a torn last line. `purpose`, the first line, identifies the jobs
  /// and the program. Throws FileError if the log has another purpose or a damaged line, if another process
  /// is writing it, or if it cannot be written.
  JobLog(const fs::path& file, std::string_view purpose);
  JobLog(const JobLog&) = delete;
  JobLog& operator=(const JobLog&) = delete;

  /// Returns the record with that key, valid as long as the log exists, or nullptr.
  const JobRecord* find(const std::string& key) const;
  std::size_t size() const;

  /// Appends a record and flushes it to disk. Does nothing if the key already has a record. Throws FileError.
  void add(const JobRecord& record);

  /// Rewrites the file in the order of keys, so that it does not depend on the order of the jobs. Must be the
  /// last call. Throws FileError; the file is then unchanged.
  void sort();

 private:
  void append(std::string_view line) const;

  fs::path file_;
  std::string purpose_;
  files::FileLock lock_;
  int fd_;
  mutable std::mutex mutex_;
  std::map<std::string, JobRecord> records_;
};

/// Returns the records of a log that no process is writing any more, without a torn last line. Throws
/// FileError as JobLog does.
std::map<std::string, JobRecord> read_job_log(const fs::path& file, std::string_view purpose);

}  // namespace sim::result
