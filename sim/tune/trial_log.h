// The log of finished trials: each is on the disk before the next begins, so that a sweep or tuning that was
// killed continues where it stopped.
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

namespace sim::tune {

/// The result of one trial. Values are written so that the same bits are read back, infinity and NaN
/// included.
struct TrialRecord {
  std::string key;  ///< of all that the trial depends on: a hash, see trial_key()
  std::uint64_t seed = 0;
  std::string ending;                    ///< of a result folder, or "crashed", "not begun"
  std::string cause;                     ///< of a failure, as a sentence
  std::map<std::string, double> values;  ///< metrics and objective terms that have a value
  bool operator==(const TrialRecord&) const = default;
};

/// A record as one line of JSON, without its end of line, and back (nothing for a line that is none).
std::string to_line(const TrialRecord& record);
std::optional<TrialRecord> from_line(std::string_view line);

/// A hash (32 hexadecimal digits) of all that a trial depends on, each part told from the next.
std::string trial_key(std::initializer_list<std::string_view> parts);

/// An append-only file of records, one process at a time. Safe to use from several threads.
class TrialLog {
 public:
  /// Opens the log, or begins it. `purpose` (one line) says what the trials are of and by which program: it
  /// is the log's first line. A last line that a killed process left torn is taken away. Throws FileError:
  /// the log is of another purpose, a line before the last is damaged ("file:line"), another process writes
  /// it, or it cannot be written.
  TrialLog(const std::filesystem::path& file, std::string_view purpose);
  TrialLog(const TrialLog&) = delete;
  TrialLog& operator=(const TrialLog&) = delete;

  /// The record of that key; stays where it is as the log grows.
  const TrialRecord* find(const std::string& key) const;
  std::size_t size() const;

  /// Appends a record and forces it to the disk. A key that is there already: nothing is done, the first
  /// record stays. Throws FileError.
  void add(const TrialRecord& record);

  /// Writes the file anew with its records in order of their keys, so that it is the same whatever the order
  /// in which they were made. To be called last. Throws FileError; then the file is as it was.
  void sort();

 private:
  void read(std::string_view purpose);
  void append(std::string_view line) const;

  std::filesystem::path file_;
  std::string purpose_;
  files::FileLock lock_;
  int fd_;
  mutable std::mutex mutex_;
  std::map<std::string, TrialRecord> records_;
};

/// All records of a log that nobody writes any more, in the order of the file; a torn last line is left out.
/// Throws FileError as TrialLog does.
std::map<std::string, TrialRecord> read_trial_log(const std::filesystem::path& file,
                                                  std::string_view purpose);

}  // namespace sim::tune
