#include "sim/pages/leaderboard.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "sim/files/atomic_file.h"
#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/files/text_table.h"
#include "sim/pages/html.h"
#include "sim/pages/run_data.h"
#include "sim/result/score_file.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOrder =
    "The best row comes first: by coverage, then by the first metric. coverage: mean over the runs of the "
    "share of true poses with an estimate; a run that did not complete counts 0.";

/// A row before its medians are taken.
struct Collected : LeaderboardRow {
  std::map<std::string, std::vector<double>> values;  // by column
  fs::path first;                                     // of its results
};
using RowKey = std::tuple<std::string, std::string, fs::path, std::string>;

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

std::optional<double> value_of(const files::Json& score, const std::string& metric) {
  const auto found = score.at("metrics").find(metric);
  return found ? found->at("value").number_or_null() : std::nullopt;
}

// Results of earlier versions lack true_poses.
double coverage_of(const files::Json& score) {
  if (score.at("ending").text() != "completed") return 0;
  const auto matched = value_of(score, "poses_matched"), poses = value_of(score, "true_poses"),
             tracked = value_of(score, "tracked_fraction");
  const double all = poses && *poses > 0 ? matched.value_or(0) / *poses : matched ? 1 : 0;
  return std::min(all, tracked.value_or(all));
}

/// Reads a whole result before anything is added. Throws FileError.
void add_result(const fs::path& result, const std::vector<std::string>& metrics,
                std::map<RowKey, Collected>& all) {
  const files::Json score = result::read_whole_score(result / "score.json");
  const auto estimator = score.find("estimator");
  const fs::path about = result / "about.json", timing = result / "timing.json";
  const std::string alignment = fs::exists(about) ? alignment_of(result::read_about(about)) : "none";
  std::map<std::string, double> values;
  for (const std::string& name : metrics)
    if (const auto value = value_of(score, name)) values[column_of(name, alignment)] = *value;
  for (const char* const of : {"mean", "median", "p99"})
    if (const auto cpu = fs::exists(timing)
                             ? files::read_json(timing).find(fmt::format("frame_cpu_ms_{}", of))
                             : std::nullopt)
      values[fmt::format("cpu_ms_{}", of)] = cpu->number();
  const std::uint64_t seed = score.at("seed").whole();
  const double coverage = coverage_of(score);
  const std::string scenario = score.at("scenario").text(), name = estimator ? estimator->text() : "filter";
  const fs::path folder = fs::absolute(result / "x").lexically_normal().parent_path().parent_path();

  Collected& row = all[{scenario, name, folder, alignment}];
  row.scenario = scenario, row.estimator = name, row.folder = folder, row.alignment = alignment;
  if (row.runs++ == 0) row.first = result;
  row.completed += score.at("ending").text() == "completed" ? 1 : 0;
  row.coverage += coverage;
  row.seeds.insert(seed);
  for (const auto& [column, value] : values) row.values[column].push_back(value);
}

using Keys = std::map<std::string, std::string>;

Keys keys_of(const fs::path& result) try {
  const scenario::Scenario read = scenario::read_scenario(result / "scenario.yaml").scenario;
  Keys keys;
  for (const auto& key : scenario::scenario_keys())
    if (key.name != "seed") keys[key.name] = scenario::has_section(read, key.name) ? key.print(read) : "none";
  return keys;
} catch (const std::exception&) {  // a part of a result, or of another version
  return {};
}

/// Names the keys that differ between rows of one scenario and estimator.
void name_changes(std::vector<Collected>& rows) {
  for (auto from = rows.begin(); from != rows.end();) {
    const auto to = std::find_if(from, rows.end(), [&](const Collected& row) {
      return row.scenario != from->scenario || row.estimator != from->estimator;
    });
    if (to - from > 1) {
      std::vector<Keys> keys;
      for (auto row = from; row != to; ++row) keys.push_back(keys_of(row->first));
      for (const auto& [key, value] : keys.front()) {
        const auto same = [&key = key, &value = value](const Keys& k) {
          return k.empty() || (k.contains(key) && k.at(key) == value);
        };
        if (std::all_of(keys.begin(), keys.end(), same)) continue;
        for (auto row = from; row != to; ++row)
          if (const Keys& own = keys[static_cast<std::size_t>(row - from)]; own.contains(key))
            row->changes += fmt::format("{}{}={}", row->changes.empty() ? "" : " ", key, own.at(key));
      }
    }
    from = to;
  }
}

/// Orders the rows of a scenario: small is good. An aligned error is never compared with an unaligned one.
std::tuple<double, std::string, double> badness(const LeaderboardRow& row, const std::string& metric) {
  const std::string column = column_of(metric, row.alignment);
  const auto value = row.medians.find(column);
  return {-std::round(100 * row.coverage), column == metric ? "" : column,
          value == row.medians.end() ? INFINITY : score::loss(value->second, score::direction_of(metric))};
}

/// The metrics, each as its columns by alignment, and the CPU times, as far as a row has them.
std::vector<std::string> value_columns(const Leaderboard& board) {
  std::vector<std::string> columns;
  for (const std::string& metric : board.metrics) {
    std::set<std::string> of_metric;
    for (const LeaderboardRow& row : board.rows) of_metric.insert(column_of(metric, row.alignment));
    columns.insert(columns.end(), of_metric.begin(), of_metric.end());
  }
  columns.insert(columns.end(), {"cpu_ms_mean", "cpu_ms_median", "cpu_ms_p99"});
  return columns;
}

/// A name as a field that neither a terminal nor a spreadsheet obeys: no control characters, and an
/// apostrophe before what would be a formula.
std::string field(std::string name) {
  name = files::sanitize(name);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '\n' || c == '\t'; }, '?');
  if (!name.empty() && std::string_view("=+-@").find(name[0]) != std::string_view::npos) name.insert(0, "'");
  return files::csv_field(name);
}

std::string seeds_text(const std::set<std::uint64_t>& seeds) {
  const bool chain = seeds.size() > 2 && *seeds.rbegin() - *seeds.begin() == seeds.size() - 1;
  return chain ? fmt::format("{}-{}", *seeds.begin(), *seeds.rbegin())
               : fmt::format("{}", fmt::join(seeds, ","));
}

std::vector<std::string> titles(const Leaderboard& board) {
  std::vector<std::string> all{"scenario", "estimator", "coverage", "completed"};
  const auto columns = value_columns(board);
  all.insert(all.end(), columns.begin(), columns.end());
  all.insert(all.end(), {"seeds", "alignment", "changed", "folder"});
  return all;
}

std::vector<std::string> cells(const LeaderboardRow& row, const std::vector<std::string>& columns) {
  std::vector<std::string> all{row.scenario, row.estimator, fmt::format("{:.0f} %", 100 * row.coverage),
                               fmt::format("{}/{}", row.completed, row.runs)};
  for (const std::string& column : columns) {
    const auto value = row.medians.find(column);
    all.push_back(value == row.medians.end() ? "-" : fmt::format("{:.4g}", value->second));
  }
  const std::string alignment = row.alignment == "none" ? "-" : row.alignment;
  all.insert(all.end(), {seeds_text(row.seeds), alignment, row.changes.empty() ? "-" : row.changes,
                         fs::proximate(row.folder).string()});
  return all;
}

/// The titles and the rows, without columns that no row has a value in.
std::vector<std::vector<std::string>> lines_of(const Leaderboard& board) {
  std::vector<std::vector<std::string>> all{titles(board)}, lines(board.rows.size() + 1);
  for (const LeaderboardRow& row : board.rows) all.push_back(cells(row, value_columns(board)));
  for (std::size_t i = 0; i < all[0].size(); ++i) {
    if (std::all_of(all.begin() + 1, all.end(), [&](const auto& line) { return line[i] == "-"; })) continue;
    for (std::size_t k = 0; k < all.size(); ++k) lines[k].push_back(all[k][i]);
  }
  return lines;
}

}  // namespace

std::vector<std::string> leaderboard_metrics() {
  return {"ate_se3_rmse_m",       "ate_sim3_rmse_m",  "rmse_m",
          "end_position_error_m", "tracked_fraction", "nees_position_mean"};
}

Leaderboard leaderboard(const std::vector<fs::path>& folders, const std::vector<std::string>& metrics) {
  std::map<RowKey, Collected> all;
  std::set<fs::path> counted;  // a folder may be below several of those given
  Leaderboard board{metrics, {}, {}};
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) throw files::FileError(folder, "is not a folder");
    std::vector<fs::path> found;
    find_results(folder, found);
    if (found.empty()) throw files::FileError(folder, "contains no result (score.json)");
    for (const fs::path& result : found) try {
        if (counted.insert(fs::canonical(result)).second) add_result(result, metrics, all);
      } catch (const files::FileError& error) {
        board.left_out.emplace_back(error.what());
      }
  }
  if (all.empty())
    throw files::FileError(folders.front(), "no result can be read: " + board.left_out.front());
  std::vector<Collected> rows;
  for (auto& [key, row] : all) rows.push_back(std::move(row));
  for (Collected& row : rows) {
    row.coverage /= static_cast<double>(row.runs);
    for (const auto& [column, values] : row.values) row.medians[column] = score::median(values);
  }
  name_changes(rows);
  board.rows.assign(rows.begin(), rows.end());
  std::stable_sort(board.rows.begin(), board.rows.end(),
                   [&](const LeaderboardRow& a, const LeaderboardRow& b) {
                     if (a.scenario != b.scenario) return a.scenario < b.scenario;
                     return badness(a, metrics.front()) < badness(b, metrics.front());
                   });
  return board;
}

std::string leaderboard_table(const Leaderboard& board) {
  return files::text_table(lines_of(board), {.naming = 2, .text = 2, .last_text = true}) +
         "medians over the runs of a row that have a value; results of different scenarios are not "
         "compared\n";
}

std::string leaderboard_csv(const Leaderboard& board) {
  const std::vector<std::string> columns = value_columns(board);
  std::string text =
      fmt::format("scenario,estimator,alignment,runs,completed,coverage,{},seeds,changed,folder\n",
                  fmt::join(columns, ","));
  for (const LeaderboardRow& row : board.rows) {
    text += fmt::format("{},{},{},{},{},{}", field(row.scenario), field(row.estimator), field(row.alignment),
                        row.runs, row.completed, row.coverage);
    for (const std::string& column : columns) {
      const auto value = row.medians.find(column);
      text += "," + (value == row.medians.end() ? "" : fmt::format("{}", value->second));
    }
    text += fmt::format(",{},{},{}\n", field(fmt::format("{}", fmt::join(row.seeds, " "))),
                        field(row.changes), field(fs::proximate(row.folder).string()));
  }
  return text;
}

std::string leaderboard_page(const Leaderboard& board) {
  const auto all = lines_of(board);
  std::vector<TableCell> heads;
  for (const std::string& title : all[0]) heads.push_back(text_cell(title));
  std::string html;
  for (std::size_t i = 0; i < board.rows.size();) {
    std::vector<TableRow> lines;
    const std::string& scenario = board.rows[i].scenario;
    for (; i < board.rows.size() && board.rows[i].scenario == scenario; ++i) {
      TableRow& line = lines.emplace_back();
      for (const std::string& cell : all[i + 1]) line.cells.push_back(text_cell(cell));
    }
    html += section_html("scenario-" + scenario, scenario, table_html(scenario, heads, lines));
  }
  for (const std::string& why : board.left_out) html += "<p class='bad'>Left out: " + escaped(why) + "</p>\n";
  html += "<h2>Metrics</h2>\n<dl>\n";
  for (const std::string& metric : board.metrics)
    html += fmt::format("<dt><code>{}</code></dt><dd>{}</dd>\n", escaped(metric),
                        escaped(score::find_metric(metric)->definition));
  return html_page("Leaderboard",
                   fmt::format("A row is a folder of results of one scenario and one estimator, with medians "
                               "over the runs that have a value. {}",
                               kOrder),
                   html + "</dl>\n");
}

}  // namespace sim::pages
