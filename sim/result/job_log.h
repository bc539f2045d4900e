// Records of jobs, and the log of finished trials. Trials are on disk before the next ones start, so that a
// killed command can be resumed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/atomic_file.h"

namespace sim::result {

/// The result of one job. Values are finite and written so that they read back to the same bits.
struct JobRecord {
  std::string key;  ///< job_key() of all inputs
  std::uint64_t seed = 0;
  std::string ending;                    ///< ending of a trial, or "crashed" or "not started"
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

/// Returns the records as lines, and the records in a file of such lines.
std::string to_lines(const std::vector<JobRecord>& records);
std::vector<JobRecord> read_records(const fs::path& file);

/// Returns a hash (32 hex digits) of the parts that a job depends on, which also depends on the boundaries
/// of the parts.
std::string job_key(std::initializer_list<std::string_view> parts);

/// An append-only file of records, written by one process at a time.
class JobLog {
 public:
  /// Opens or creates the log and removes its first incomplete line, left by a killed process or a
  /// power failure, and everything after it. `purpose`, the first line, identifies the jobs and the program.
  /// Throws FileError if the log has a different purpose or cannot be written.
  JobLog(const fs::path& file, std::string_view purpose);

  /// Returns the record with that key, valid as long as the log exists, or nullptr.
  const JobRecord* find(const std::string& key) const;
  std::size_t size() const { return records_.size(); }

  /// Appends the records whose keys have none yet, and flushes them to disk. Throws FileError.
  void add(const std::vector<JobRecord>& records);

  /// Rewrites the file in the order of keys, so that it does not depend on the order of the jobs. Must be the
  /// last call. Throws FileError; the file is then unchanged.
  void sort() const;

 private:
  void append(std::string_view text) const;

  fs::path file_;
  std::string purpose_;
  files::Descriptor descriptor_;
  std::map<std::string, JobRecord> records_;
};

}  // namespace sim::result
