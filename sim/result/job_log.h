// The log of finished jobs, of results and of trials: each is on the disk before the next starts, so that a
// killed command can be resumed.
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

/// The result of one job. Values are finite and written so that the same bits are read back.
struct JobRecord {
  std::string key;  ///< of a trial: job_key() of all that it depends on; of a result: its path
  std::uint64_t seed = 0;
  std::string ending;                    ///< of a result folder, or "crashed", "not started"
  std::string cause;                     ///< of a failure, as a sentence
  std::map<std::string, double> values;  ///< metrics and objective terms that have a value
  bool operator==(const JobRecord&) const = default;

  /// Returns the value of that name, or nullopt if it has none.
  std::optional<double> value(std::string_view name) const;
};

/// Returns a record as one line of JSON, without a line feed.
std::string to_line(const JobRecord& record);
/// Returns the record in a line, or nullopt if it is not one.
std::optional<JobRecord> from_line(std::string_view line);

/// Returns a hash (32 hex digits) of the parts that a job depends on; it differs if their borders differ.
std::string job_key(std::initializer_list<std::string_view> parts);

/// An append-only file of records, one process at a time. Safe to use from several threads.
class JobLog {
 public:
  /// Opens or creates the log and removes a torn last line. `purpose`, the first line, identifies the jobs
  /// and the program. Throws FileError if the log has another purpose or a damaged line, if another process
  /// writes it, or if it cannot be written.
  JobLog(const fs::path& file, std::string_view purpose);
  JobLog(const JobLog&) = delete;
  JobLog& operator=(const JobLog&) = delete;

  /// Returns the record of that key, valid as long as the log, or nullptr.
  const JobRecord* find(const std::string& key) const;
  std::size_t size() const;

  /// Appends a record and syncs it to the disk; does nothing if the key has a record. Throws FileError.
  void add(const JobRecord& record);

  /// Rewrites the file in the order of keys, so that it does not depend on the order of the jobs; the last
  /// call. Throws FileError; then the file is unchanged.
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

/// Returns the records of a log that no process writes any more, without a torn last line. Throws FileError
/// as JobLog does.
std::map<std::string, JobRecord> read_job_log(const fs::path& file, std::string_view purpose);

}  // namespace sim::result
