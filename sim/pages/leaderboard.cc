#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "sim/files/atomic_file.h"
#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/result/score_file.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

using Rows = std::map<std::tuple<std::string, std::string, fs::path, std::string>, LeaderboardRow>;

void find_results(const fs::path& folder, std::vector<fs::path>& found) {
  if (fs::exists(folder / "score.json")) found.push_back(folder);
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    const bool left_out = name == "recording" || name == "export" || name.starts_with("earlier-");
    if (entry.is_directory() && !entry.is_symlink() && !left_out && !files::is_partial(entry.path()))
      below.push_back(entry.path());
  }
  std::ranges::sort(below);
  for (const fs::path& next : below) find_results(next, found);
}

// Results of earlier versions lack true_poses.
double coverage_of(const result::SeedScore& score) {
  if (score.ending != scenario::Ending::completed) return 0;
  const auto matched = score.value("poses_matched"), poses = score.value("true_poses"),
             tracked = score.value("tracked_fraction");
  const double all = poses && *poses > 0 ? matched.value_or(0) / *poses : matched ? 1 : 0;
  return std::min(all, tracked.value_or(all));
}

std::vector<std::string> settings_of(const fs::path& result) try {
  const scenario::Scenario read = scenario::read_scenario(result / "scenario.yaml").scenario;
  std::vector<std::string> settings;
  for (const auto& key : scenario::scenario_keys())
    if (key.name != "seed")
      settings.push_back(key.name + "=" + (scenario::has_section(read, key.name) ? key.print(read) : "none"));
  return settings;
} catch (const std::exception&) {  // a part of a result, or of another version
  return {};
}

/// The settings that differ between the rows of its scenario and estimator.
std::string changed(const LeaderboardRow& row, const std::vector<LeaderboardRow>& rows) {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < row.settings.size(); ++i)
    if (std::ranges::any_of(rows, [&](const LeaderboardRow& other) {
          return other.scenario == row.scenario && other.estimator == row.estimator &&
                 !other.settings.empty() && other.settings[i] != row.settings[i];
        }))
      all.push_back(row.settings[i]);
  return all.empty() ? "-" : fmt::format("{}", fmt::join(all, " "));
}

/// Reads a whole result before anything is added. Throws FileError.
void add_result(const fs::path& result, const std::vector<std::string>& metrics, Rows& all) {
  const result::SeedScore score = result::read_score(result / "score.json");
  const fs::path about = result / "about.json", timing = result / "timing.json";
  const std::string alignment = fs::exists(about) ? alignment_of(result::read_about(about)) : "none";
  std::map<std::string, double> values;
  for (const std::string& name : metrics)
    if (const auto value = score.value(name)) values[column_of(name, alignment)] = *value;
  for (const char* const of : {"mean", "median", "p99"})
    if (const auto cpu = fs::exists(timing)
                             ? files::read_json(timing).find(fmt::format("frame_cpu_ms_{}", of))
                             : std::nullopt)
      values[fmt::format("cpu_ms_{}", of)] = cpu->number();
  const fs::path folder = fs::absolute(result / "x").lexically_normal().parent_path().parent_path();

  LeaderboardRow& row = all[{score.scenario, score.estimator, folder, alignment}];
  row.scenario = score.scenario, row.estimator = score.estimator, row.folder = folder,
  row.alignment = alignment;
  if (row.runs++ == 0) row.settings = settings_of(result);
  row.completed += score.ending == scenario::Ending::completed;
  row.coverage += coverage_of(score);
  row.seeds.insert(score.seed);
  for (const auto& [column, value] : values) row.values[column].push_back(value);
}

/// Orders the rows of a scenario: small is good. An aligned error is never compared with an unaligned one.
std::tuple<double, std::string, double> badness(const LeaderboardRow& row, const std::string& metric) {
  const std::string column = column_of(metric, row.alignment);
  const auto value = row.median(column);
  return {-std::round(100 * row.coverage), column == metric ? "" : column,
          value ? score::loss(*value, score::direction_of(metric)) : INFINITY};
}

/// The metrics, each as its columns by alignment, and the CPU times, if a row has them.
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

/// The titles and the rows. exact: all digits and columns; else without columns that no row has a value in.
std::vector<std::vector<std::string>> lines_of(const Leaderboard& board, bool exact) {
  const auto number = [&](double x) { return exact ? fmt::format("{}", x) : fmt::format("{:.4g}", x); };
  const std::vector<std::string> columns = value_columns(board);
  std::vector<std::vector<std::string>> all{{"scenario", "estimator", "coverage", "runs", "completed"}};
  all[0].insert(all[0].end(), columns.begin(), columns.end());
  all[0].insert(all[0].end(), {"alignment", "seeds", "changed", "folder"});
  for (const LeaderboardRow& row : board.rows) {
    auto& line = all.emplace_back(std::vector{row.scenario, row.estimator, number(row.coverage),
                                              fmt::format("{}", row.runs), fmt::format("{}", row.completed)});
    for (const std::string& column : columns) {
      const auto value = row.median(column);
      line.push_back(value ? number(*value) : "-");
    }
    line.insert(line.end(),
                {row.alignment == "none" ? "-" : row.alignment, fmt::format("{}", fmt::join(row.seeds, " ")),
                 changed(row, board.rows), fs::proximate(row.folder).string()});
  }
  std::vector<std::vector<std::string>> lines(all.size());
  for (std::size_t i = 0; i < all[0].size(); ++i)
    if (exact || std::any_of(all.begin() + 1, all.end(), [&](const auto& line) { return line[i] != "-"; }))
      for (std::size_t k = 0; k < all.size(); ++k) lines[k].push_back(all[k][i]);
  return lines;
}

}  // namespace

std::optional<double> LeaderboardRow::median(const std::string& column) const {
  const auto found = values.find(column);
  return found == values.end() ? std::nullopt : std::optional(score::median(found->second));
}

Leaderboard leaderboard(const std::vector<fs::path>& folders, const std::vector<std::string>& metrics) {
  Rows all;
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
  for (auto& [key, row] : all) {
    row.coverage /= static_cast<double>(row.runs);
    board.rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(board.rows, [&](const LeaderboardRow& a, const LeaderboardRow& b) {
    if (a.scenario != b.scenario) return a.scenario < b.scenario;
    return badness(a, metrics.front()) < badness(b, metrics.front());
  });
  return board;
}

std::string leaderboard_table(const Leaderboard& board) {
  return files::text_table(lines_of(board, false), {.naming = 2, .text = 2, .last_text = true}) +
         "medians over the runs of a row that have a value; results of different scenarios are not "
         "compared\n";
}

std::string leaderboard_csv(const Leaderboard& board) {
  std::string text;
  for (const std::vector<std::string>& line : lines_of(board, true)) {
    std::vector<std::string> fields;
    for (const std::string& cell : line) fields.push_back(cell == "-" ? "" : files::neutral_field(cell));
    text += fmt::format("{}\n", fmt::join(fields, ","));
  }
  return text;
}

std::string leaderboard_page(const Leaderboard& board) {
  const auto all = lines_of(board, false);
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
    html += sections_html({{"scenario-" + scenario, scenario, table_html(scenario, heads, lines)}});
  }
  for (const std::string& why : board.left_out) html += "<p class='bad'>Left out: " + escaped(why) + "</p>\n";
  html += "<h2>Metrics</h2>\n<dl>\n";
  for (const std::string& metric : board.metrics)
    html += fmt::format("<dt><code>{}</code></dt><dd>{}</dd>\n", escaped(metric),
                        escaped(score::find_metric(metric)->definition));
  return html_page(
      "Leaderboard",
      "A row is a folder of results of one scenario and one estimator, with medians over the runs that have "
      "a value. The best row comes first: by coverage, then by the first metric. coverage: mean over the "
      "runs of the share of true poses with an estimate; a run that did not complete counts 0.",
      html + "</dl>\n");
}

}  // namespace sim::pages
