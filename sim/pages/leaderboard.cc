#include "sim/pages/leaderboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "sim/files/atomic_file.h"
#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/files/text_table.h"
#include "sim/pages/html.h"
#include "sim/result/score_file.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;

/// The results of a row before their medians are taken.
struct Collected {
  std::size_t runs = 0, completed = 0;
  std::map<std::string, std::vector<double>> values;
  std::vector<double> cpu_ms;
};
using RowKey = std::tuple<std::string, std::string, fs::path>;  // scenario, estimator, folder

bool is_left_out(const fs::path& folder) {
  const std::string name = folder.filename();
  return name == "recording" || name == "export" || name.starts_with("earlier-") || files::is_partial(folder);
}

void find_results(const fs::path& folder, std::vector<fs::path>& found) {
  if (fs::exists(folder / "score.json")) found.push_back(folder);
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && !entry.is_symlink() && !is_left_out(entry.path()))
      below.push_back(entry.path());
  std::sort(below.begin(), below.end());
  for (const fs::path& next : below) find_results(next, found);
}

void add_result(const fs::path& result, const std::vector<std::string>& metrics,
                std::map<RowKey, Collected>& all) {
  const files::Json score = result::read_whole_score(result / "score.json");
  const auto estimator = score.find("estimator");
  const fs::path whole = fs::absolute(result / "x").lexically_normal().parent_path();
  Collected& row =
      all[{score.at("scenario").text(), estimator ? estimator->text() : "filter", whole.parent_path()}];
  ++row.runs;
  row.completed += score.at("ending").text() == "completed" ? 1 : 0;
  for (const std::string& name : metrics)
    if (const auto metric = score.at("metrics").find(name))
      if (const auto value = metric->at("value").number_or_null()) row.values[name].push_back(*value);
  if (!fs::exists(result / "timing.json")) return;
  if (const auto cpu = files::read_json(result / "timing.json").find("frame_cpu_ms_mean"))
    row.cpu_ms.push_back(cpu->number());
}

std::optional<double> median_of(const std::vector<double>& values) {
  return values.empty() ? std::nullopt : std::optional(score::median(values));
}

/// Orders the rows of a scenario: small is good.
std::pair<double, double> badness(const LeaderboardRow& row, const std::string& metric) {
  const auto& value = row.medians.at(metric);
  const double failed = 1 - static_cast<double>(row.completed) / static_cast<double>(row.runs);
  return {failed,
          value ? score::loss(*value, score::direction_of(metric)) : std::numeric_limits<double>::infinity()};
}

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

std::vector<std::string> titles(const std::vector<std::string>& metrics) {
  std::vector<std::string> all{"scenario", "estimator", "completed"};
  all.insert(all.end(), metrics.begin(), metrics.end());
  all.insert(all.end(), {"cpu_ms", "folder"});
  return all;
}

std::vector<std::string> cells(const LeaderboardRow& row, const std::vector<std::string>& metrics) {
  std::vector<std::string> all{row.scenario, row.estimator, fmt::format("{}/{}", row.completed, row.runs)};
  for (const std::string& metric : metrics) all.push_back(number(row.medians.at(metric)));
  all.push_back(number(row.cpu_ms));
  all.push_back(fs::proximate(row.folder).string());
  return all;
}

}  // namespace

std::vector<std::string> leaderboard_metrics() {
  return {"ate_se3_rmse_m",       "ate_sim3_rmse_m",  "rmse_m",
          "end_position_error_m", "tracked_fraction", "nees_position_mean"};
}

std::vector<LeaderboardRow> leaderboard(const std::vector<fs::path>& folders,
                                        const std::vector<std::string>& metrics) {
  std::vector<fs::path> found;
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) throw files::FileError(folder, "is not a folder");
    const std::size_t before = found.size();
    find_results(folder, found);
    if (found.size() == before) throw files::FileError(folder, "contains no result (score.json)");
  }
  std::map<RowKey, Collected> all;
  std::set<fs::path> counted;  // a folder may be below several of those given
  for (const fs::path& result : found)
    if (counted.insert(fs::canonical(result)).second) add_result(result, metrics, all);
  std::vector<LeaderboardRow> rows;
  for (const auto& [key, collected] : all) {
    LeaderboardRow row{
        std::get<0>(key), std::get<1>(key), std::get<2>(key), collected.runs, collected.completed, {}, {}};
    for (const std::string& metric : metrics) {
      const auto values = collected.values.find(metric);
      row.medians[metric] = values == collected.values.end() ? std::nullopt : median_of(values->second);
    }
    row.cpu_ms = median_of(collected.cpu_ms);
    rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), [&](const LeaderboardRow& a, const LeaderboardRow& b) {
    if (a.scenario != b.scenario) return a.scenario < b.scenario;
    return badness(a, metrics.front()) < badness(b, metrics.front());
  });
  return rows;
}

std::string leaderboard_table(const std::vector<LeaderboardRow>& rows,
                              const std::vector<std::string>& metrics) {
  std::vector<std::vector<std::string>> lines{titles(metrics)};
  for (const LeaderboardRow& row : rows) lines.push_back(cells(row, metrics));
  return files::text_table(lines, {.naming = 2, .text = 2, .last_text = true}) +
         "medians over the runs of a row that have a value; results of different scenarios are not "
         "compared\n";
}

std::string leaderboard_csv(const std::vector<LeaderboardRow>& rows,
                            const std::vector<std::string>& metrics) {
  std::string text = "scenario,estimator,runs,completed";
  for (const std::string& metric : metrics) text += "," + metric;
  text += ",cpu_ms,folder\n";
  const auto exact = [](const std::optional<double>& value) {
    return value ? fmt::format("{}", *value) : "";
  };
  for (const LeaderboardRow& row : rows) {
    text += fmt::format("{},{},{},{}", files::csv_field(row.scenario), files::csv_field(row.estimator),
                        row.runs, row.completed);
    for (const std::string& metric : metrics) text += "," + exact(row.medians.at(metric));
    text += fmt::format(",{},{}\n", exact(row.cpu_ms), files::csv_field(fs::proximate(row.folder).string()));
  }
  return text;
}

std::string leaderboard_page(const std::vector<LeaderboardRow>& rows,
                             const std::vector<std::string>& metrics) {
  std::vector<TableCell> heads;
  for (const std::string& title : titles(metrics)) heads.push_back(text_cell(title));
  std::string html;
  for (auto row = rows.begin(); row != rows.end();) {
    std::vector<TableRow> lines;
    const std::string& scenario = row->scenario;
    for (; row != rows.end() && row->scenario == scenario; ++row) {
      TableRow& line = lines.emplace_back();
      for (const std::string& cell : cells(*row, metrics)) line.cells.push_back(text_cell(cell));
    }
    html += section_html("scenario-" + scenario, scenario, table_html(scenario, heads, lines));
  }
  html += "<h2>Metrics</h2>\n<dl>\n";
  for (const std::string& metric : metrics)
    html += fmt::format("<dt><code>{}</code></dt><dd>{}</dd>\n", escaped(metric),
                        escaped(score::find_metric(metric)->definition));
  return html_page(
      "Leaderboard",
      "A row is a folder of results of one scenario and one estimator, with medians over the runs "
      "that have a value. The best row comes first: by completed runs, then by the first metric.",
      html + "</dl>\n");
}

}  // namespace sim::pages
