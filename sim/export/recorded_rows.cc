#include "sim/export/recorded_rows.h"

#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {

RecordedRows::RecordedRows(const std::filesystem::path& folder, const std::string& sensor) {
  const recording::Manifest manifest(folder);
  const std::string file = recording::recording_format::body_sensor_rows(sensor);
  if (!manifest.lists(file)) return;
  rows_.emplace(files::CsvReader(manifest.check(file), 1), recording::kEpoch);
  const std::vector<std::string>& titles = rows_->row().titles();
  for (std::size_t i = 1; i < titles.size(); ++i) names_.push_back(titles[i].substr(0, titles[i].find(" [")));
}

std::optional<RecordedRows::Row> RecordedRows::latest(slam::Stamp until) {
  std::optional<Row> latest;
  for (; rows_ && rows_->stamp() && *rows_->stamp() <= until; rows_->advance()) {
    latest.emplace();
    latest->t = *rows_->stamp();
    for (std::size_t i = 1; i < rows_->row().fields(); ++i) latest->values.push_back(rows_->row().number(i));
  }
  return latest;
}

}  // namespace sim::exports
