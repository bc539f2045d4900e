#include "sim/result/job_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "sim/files/hash.h"
#include "sim/files/json.h"

namespace sim::result {
namespace {

using files::FileError;

constexpr int kTriesOfTheLock = 20;
constexpr useconds_t kPauseUs = 100'000;

/// Waits briefly, for a killed process that has not ended yet.
files::FileLock lock_for_writing(const fs::path& file) {
  using files::FileLock;
  for (int attempt = 0; attempt <= kTriesOfTheLock; ++attempt) {
    if (auto lock = FileLock::acquire(file, FileLock::How::try_exclusive)) return std::move(*lock);
    ::usleep(kPauseUs);
  }
  throw FileError(file, "is being written by another process");
}

/// The records of a log, and the length in bytes of its complete lines.
struct Parsed {
  std::map<std::string, JobRecord> records;
  std::size_t whole_bytes = 0;
};

Parsed parse(const fs::path& file, std::string_view text, std::string_view purpose) {
  Parsed parsed;
  std::string_view rest = text;
  for (int line_number = 1;; ++line_number) {
    const std::size_t end = rest.find('\n');
    if (end == rest.npos) return parsed;
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    if (line_number == 1) {
      if (line != purpose) throw FileError(file, "is another log: {}, expected {}", line, purpose);
    } else if (auto record = from_line(line)) {
      parsed.records.emplace(record->key, std::move(*record));
    } else if (rest.empty()) {
      return parsed;  // torn by a power failure: the file has its length but not its content
    } else {
      throw FileError(file, "line {} is not a record; the log was changed after it was written", line_number);
    }
    parsed.whole_bytes = text.size() - rest.size();
  }
}

}  // namespace

std::optional<double> JobRecord::value(std::string_view name) const {
  const auto found = values.find(std::string(name));
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

std::string to_line(const JobRecord& record) {
  nlohmann::ordered_json line{{"key", record.key}, {"seed", record.seed}, {"ending", record.ending}};
  if (!record.cause.empty()) line["cause"] = record.cause;
  line["values"] = record.values;
  return files::json_text(line);
}

std::optional<JobRecord> from_line(std::string_view line) {
  try {
    const files::Json read("record", line);
    JobRecord record{read.at("key").text(), read.at("seed").whole(), read.at("ending").text(), "", {}};
    if (const auto cause = read.find("cause")) record.cause = cause->text();
    for (const auto& [name, value] : read.at("values").entries()) record.values[name] = value.number();
    return record;
  } catch (const FileError&) {
    return std::nullopt;
  }
}

std::string job_key(std::initializer_list<std::string_view> parts) {
  files::Hash hash;
  for (const std::string_view part : parts) hash.add_part(part);
  return hash.hex();
}

JobLog::JobLog(const fs::path& file, std::string_view purpose)
    : file_(file), purpose_(purpose), lock_(lock_for_writing(file)), fd_(lock_.fd()) {
  if (::fcntl(fd_, F_SETFL, O_APPEND) != 0) files::fail_by_errno(file_, "cannot be opened");
  Parsed parsed = parse(file_, files::read_text(file_), purpose);
  records_ = std::move(parsed.records);
  if (::ftruncate(fd_, static_cast<off_t>(parsed.whole_bytes)) != 0)
    files::fail_by_errno(file_, "cannot be written");
  if (parsed.whole_bytes == 0) append(purpose);
}

void JobLog::append(std::string_view line) const {
  files::write_all(fd_, file_, std::string(line) + "\n");
  if (::fsync(fd_) != 0) files::fail_by_errno(file_, "cannot be flushed to disk");
}

const JobRecord* JobLog::find(const std::string& key) const {
  const std::scoped_lock lock(mutex_);
  const auto found = records_.find(key);
  return found == records_.end() ? nullptr : &found->second;
}

std::size_t JobLog::size() const {
  const std::scoped_lock lock(mutex_);
  return records_.size();
}

void JobLog::add(const JobRecord& record) {
  const std::scoped_lock lock(mutex_);
  if (records_.contains(record.key)) return;
  append(to_line(record));
  records_.emplace(record.key, record);
}

void JobLog::sort() {
  const std::scoped_lock lock(mutex_);
  std::string text = purpose_ + "\n";
  for (const auto& [key, record] : records_) text += to_line(record) + "\n";
  files::write_atomically(file_, text);
}

std::map<std::string, JobRecord> read_job_log(const fs::path& file, std::string_view purpose) {
  return parse(file, files::read_text(file), purpose).records;
}

}  // namespace sim::result
