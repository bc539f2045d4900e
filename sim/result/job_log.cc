#include "sim/result/job_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "sim/files/hash.h"
#include "sim/files/json.h"

namespace sim::result {

using files::FileError;

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

std::string to_lines(const std::vector<JobRecord>& records) {
  std::string text;
  for (const JobRecord& record : records) text += to_line(record) + "\n";
  return text;
}

std::vector<JobRecord> read_records(const fs::path& file) {
  std::vector<JobRecord> records;
  for (const std::string& line : files::lines_of(files::read_text(file)))
    if (auto record = from_line(line)) records.push_back(std::move(*record));
  return records;
}

JobLog::JobLog(const fs::path& file, std::string_view purpose)
    : file_(file),
      purpose_(purpose),
      descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
  if (descriptor_.fd < 0) files::fail_by_errno(file_, "cannot be opened");
  const std::string text = files::read_text(file_);
  std::size_t whole = 0;
  for (std::size_t end = 0; (end = text.find('\n', whole)) != text.npos; whole = end + 1) {
    const std::string_view line = std::string_view(text).substr(whole, end - whole);
    const auto record = from_line(line);
    if (whole == 0 && line != purpose)
      throw FileError(file, "is another log: {}, expected {}", line, purpose);
    if (record) records_.emplace(record->key, *record);
    if (whole > 0 && !record) break;  // cut off by a power failure
  }
  if (::ftruncate(descriptor_.fd, static_cast<off_t>(whole)) != 0)
    files::fail_by_errno(file_, "cannot be written");
  if (whole == 0) append(purpose_ + "\n");
}

void JobLog::append(std::string_view text) const {
  files::write_all(descriptor_.fd, file_, text);
  if (::fsync(descriptor_.fd) != 0) files::fail_by_errno(file_, "cannot be flushed to disk");
}

const JobRecord* JobLog::find(const std::string& key) const {
  const auto found = records_.find(key);
  return found == records_.end() ? nullptr : &found->second;
}

void JobLog::add(const std::vector<JobRecord>& records) {
  std::vector<JobRecord> added;
  for (const JobRecord& record : records)
    if (records_.emplace(record.key, record).second) added.push_back(record);
  append(to_lines(added));
}

void JobLog::sort() const {
  std::string text = purpose_ + "\n";
  for (const auto& [key, record] : records_) text += to_line(record) + "\n";
  files::write_atomically(file_, text);
}

}  // namespace sim::result
