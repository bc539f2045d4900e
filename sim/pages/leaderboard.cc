#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

/// Key of a row: scenario, estimator, folder, alignment and settings.
using RowKey =
    std::tuple<std::string, std::string, fs::path, std::string, std::map<std::string, std::string>>;
using Rows = std::map<RowKey, LeaderboardRow>;

bool are_alike(const LeaderboardRow& a, const LeaderboardRow& b) {
  return a.scenario == b.scenario && a.estimator == b.estimator;
}

/// Returns the row's settings that differ between rows with the same scenario and estimator.
std::string changed(const LeaderboardRow& row, const std::vector<LeaderboardRow>& rows) {
  std::set<std::string> all;
  for (const LeaderboardRow& other : rows)
    for (const auto& [key, value] : row.settings)
      if (const auto found = other.settings.find(key);
          are_alike(row, other) && found != other.settings.end() && found->second != value)
        all.insert(key + "=" + in_one_line(value));
  return all.empty() ? "-" : fmt::format("{}", fmt::join(all, " "));
}

/// Returns a row's folder: the one that contains results seed-<n>; for replays inside these, a path with
/// seed-*.
fs::path folder_of(const fs::path& result) {
  const fs::path whole = fs::absolute(result / "x").lexically_normal().parent_path();
  fs::path folder;
  for (const fs::path& part : whole) folder /= result::seed_of(part) ? "seed-*" : part;
  return folder == whole || folder.filename() == "seed-*" ? folder.parent_path() : folder;
}

/// Reads a whole result before adding anything. Throws FileError, also if its row already has the seed.
void add_result(const fs::path& result, const std::vector<std::string>& metrics, Rows& all) {
  const result::SeedScore score = result::read_score(result / "score.json");
  const fs::path file = result / "about.json", timing = result / "timing.json";
  const result::About about = fs::exists(file) ? result::read_about(file) : result::About();
  const LeaderboardRow row{score.scenario, score.estimator, alignment_of(about), folder_of(result),
                           settings_of(result, about)};
  LeaderboardRun run{score.ending == scenario::Ending::completed, 0, {}, result};
  // Results of earlier versions lack true_poses.
  if (run.completed) run.coverage = score.coverage().value_or(score.value("poses_matched") ? 1 : 0);
  for (const std::string& name : metrics)
    if (const auto value = score.value(name)) run.values[column_of(name, row.alignment)] = *value;
  if (fs::exists(timing))
    for (const char* const of : {"cpu_ms_mean", "cpu_ms_median", "cpu_ms_p99"})
      if (const auto cpu = files::read_json(timing).find(std::string("frame_") + of))
        run.values[of] = cpu->number();
  auto& runs = all.try_emplace({row.scenario, row.estimator, row.folder, row.alignment, row.settings}, row)
                   .first->second.runs;
  if (const auto [first, is_new] = runs.emplace(score.seed, run); !is_new)
    throw files::FileError(result, "repeats seed {} of {}, with the same settings and programs", score.seed,
                           first->second.folder.string());
}

/// Sort key for the rows of a scenario: smaller is better. Never compares an aligned error with an unaligned
/// one.
std::tuple<bool, double, std::string, double> badness(const LeaderboardRow& row, const std::string& metric) {
  const std::string column = column_of(metric, row.alignment);
  const auto values = row.values(column);
  return {!row.rank, -std::round(100 * row.coverage()), column == metric ? "" : column,
          values.empty() ? INFINITY : score::loss(score::median(values), score::direction_of(metric))};
}

/// Sets the seeds and ranks of a scenario's rows, starting with the row with the most seeds. Returns the
/// common seeds.
std::vector<std::uint64_t> rank(std::span<LeaderboardRow> rows, const std::string& metric) {
  std::ranges::stable_sort(rows, std::greater(), [](const LeaderboardRow& row) { return row.runs.size(); });
  for (LeaderboardRow& row : rows)
    for (const auto& [seed, run] : row.runs) row.seeds.push_back(seed);
  std::vector<std::uint64_t> common = rows.front().seeds;
  for (LeaderboardRow& row : rows) {
    std::vector<std::uint64_t> shared;
    std::ranges::set_intersection(common, row.seeds, std::back_inserter(shared));
    if (shared.empty()) continue;
    common = shared;
    row.rank = 0;
  }
  for (LeaderboardRow& row : rows)
    if (row.rank) row.seeds = common;
  std::ranges::stable_sort(rows, {}, [&](const LeaderboardRow& row) { return badness(row, metric); });
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].rank) rows[i].rank = i + 1;
  return common;
}

/// Returns the columns: one for each metric and alignment, then the CPU times.
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

std::string completed_of(const LeaderboardRow& row) {
  return fmt::format("{}", std::ranges::count_if(row.runs, [](const auto& r) { return r.second.completed; }));
}

/// Returns the lines without the columns that have no value in any row.
std::vector<std::vector<std::string>> without_empty(const std::vector<std::vector<std::string>>& all) {
  std::vector<std::vector<std::string>> lines(all.size());
  for (std::size_t i = 0; i < all[0].size(); ++i)
    if (std::any_of(all.begin() + 1, all.end(), [&](const auto& line) { return line[i] != "-"; }))
      for (std::size_t k = 0; k < all.size(); ++k) lines[k].push_back(all[k][i]);
  return lines;
}

/// Returns titles and rows with all columns and digits.
std::vector<std::vector<std::string>> exact_lines(const Leaderboard& board) {
  const std::vector<std::string> columns = value_columns(board);
  const auto has_spread = [](const std::string& column) { return !column.starts_with("cpu_ms_"); };
  std::vector<std::vector<std::string>> lines{
      {"scenario", "estimator", "rank", "coverage", "runs", "completed"}};
  for (const std::string& column : columns) {
    lines[0].push_back(column);
    if (!has_spread(column)) continue;
    for (const char* of : {"_min", "_max", "_low_95", "_high_95"}) lines[0].push_back(column + of);
  }
  lines[0].insert(lines[0].end(), {"alignment", "seeds", "changed", "folder"});
  for (const LeaderboardRow& row : board.rows) {
    auto& line = lines.emplace_back(std::vector{
        row.scenario, row.estimator, row.rank ? fmt::format("{}", *row.rank) : "-",
        fmt::format("{}", row.coverage()), fmt::format("{}", row.runs.size()), completed_of(row)});
    for (const std::string& column : columns) {
      const auto values = row.values(column);
      const auto interval = score::median_interval(values);
      const auto text = [](const auto& value) { return fmt::format("{}", value); };
      line.push_back(values.empty() ? "-" : text(score::median(values)));
      if (!has_spread(column)) continue;
      for (const double p : {0.0, 1.0})
        line.push_back(values.size() > 1 ? text(score::quantile(values, p)) : "-");
      line.push_back(interval ? text(interval->first) : "-");
      line.push_back(interval ? text(interval->second) : "-");
    }
    std::string seeds;
    for (const auto& [seed, run] : row.runs) seeds += fmt::format("{}{}", seeds.empty() ? "" : " ", seed);
    line.insert(line.end(), {row.alignment == "none" ? "-" : row.alignment, seeds, changed(row, board.rows),
                             fs::proximate(row.folder).string()});
  }
  return lines;
}

constexpr const char* kRemark =
    "Medians over n seeds [95 % interval of the median; with fewer than 6 seeds, minimum and maximum]";

/// Returns the changed keys of a row, and also its folder if the keys do not identify a single row.
std::string difference(const LeaderboardRow& row, const std::vector<LeaderboardRow>& rows) {
  const std::string keys = changed(row, rows), folder = fs::proximate(row.folder).string();
  const auto alike = std::ranges::count_if(rows, [&](const LeaderboardRow& other) {
    return are_alike(row, other) && changed(other, rows) == keys;
  });
  return alike < 2 ? keys : keys == "-" ? folder : keys + " in " + folder;
}

/// Returns titles and rows for readers, with units and intervals, without columns that have no value.
std::vector<std::vector<std::string>> read_lines(const Leaderboard& board) {
  std::vector<std::vector<std::string>> lines{
      {"scenario", "estimator", "differs in", "rank", "n", "coverage", "completed"}};
  const std::vector<std::string> columns = value_columns(board);
  for (const std::string& column : columns) {
    const auto metric = std::ranges::find_if(board.metrics, [&](const std::string& name) {
      return column == name || column.starts_with(name + "_after_");
    });
    lines[0].push_back(metric == board.metrics.end() ? "CPU " + column.substr(7) + " [ms]"
                                                     : metric_label(*metric, column));
  }
  for (const LeaderboardRow& row : board.rows) {
    auto& line = lines.emplace_back(std::vector{
        row.scenario, row.estimator, difference(row, board.rows),
        row.rank ? fmt::format("{}", *row.rank) : "-", fmt::format("{}", row.seeds.size()),
        number_text(row.coverage()), fmt::format("{} of {}", completed_of(row), row.runs.size())});
    for (const std::string& column : columns) {
      const auto values = row.values(column);
      auto spread = score::median_interval(values);
      if (!spread && values.size() > 1) spread = {std::ranges::min(values), std::ranges::max(values)};
      line.push_back(values.empty() ? "-" : median_text(score::median(values), spread));
    }
  }
  return without_empty(lines);
}

}  // namespace

std::vector<double> LeaderboardRow::values(const std::string& column) const {
  std::vector<double> all;
  for (const std::uint64_t seed : seeds)
    if (const auto found = runs.at(seed).values.find(column); found != runs.at(seed).values.end())
      all.push_back(found->second);
  return all;
}

double LeaderboardRow::coverage() const {
  double sum = 0;
  for (const std::uint64_t seed : seeds) sum += runs.at(seed).coverage;
  return sum / static_cast<double>(seeds.size());
}

Leaderboard leaderboard(const std::vector<fs::path>& folders, const std::vector<std::string>& metrics) {
  Rows all;
  std::set<fs::path> counted;  // a result may be below several of the given folders
  Leaderboard board{metrics};
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) throw files::FileError(folder, "is not a folder");
    const std::vector<fs::path> found = result::find_results(folder, result::Nested::include);
    if (found.empty()) throw files::FileError(folder, "contains no result (score.json)");
    for (const fs::path& result : found) try {
        if (counted.insert(fs::canonical(result)).second) add_result(result, metrics, all);
      } catch (const files::FileError& error) {
        board.left_out.emplace_back(error.what());
      }
  }
  if (all.empty())
    throw files::FileError(folders.front(), "has no readable result: " + board.left_out.front());
  for (auto& [key, row] : all) board.rows.push_back(std::move(row));  // by scenario
  for (auto begin = board.rows.begin(), end = begin; begin != board.rows.end(); begin = end) {
    const std::string scenario = begin->scenario;
    end = std::find_if(begin, board.rows.end(), [&](const auto& row) { return row.scenario != scenario; });
    board.common[scenario] = rank({begin, end}, metrics.front());
  }
  return board;
}

/// Returns "walk is ranked over the seeds that all its rows have: 1 2 3".
std::string ranking_text(const std::string& scenario, const Leaderboard& board) {
  return fmt::format("{} is ranked over the seeds that all its rows have: {}", scenario,
                     fmt::join(board.common.at(scenario), " "));
}

std::string leaderboard_table(const Leaderboard& board) {
  auto lines = read_lines(board);
  const bool differs = lines[0][2] == "differs in";
  for (auto& line : lines)
    if (differs) std::rotate(line.begin() + 2, line.begin() + 3, line.end());  // to the end
  std::string text = files::text_table(lines, {.naming = 2, .text = 2, .last_text = differs});
  for (const auto& [scenario, seeds] : board.common)
    text += files::one_line(ranking_text(scenario, board)) + "\n";
  return text + kRemark + ".\nResults of different scenarios are not compared.\n";
}

std::string leaderboard_file(const Leaderboard& board, TableFormat format) {
  return written_table(format == TableFormat::csv ? exact_lines(board) : read_lines(board), format,
                       std::string(kRemark) + ".");
}

std::string leaderboard_page(const Leaderboard& board) {
  const auto all = read_lines(board);
  const std::vector<std::string> titles(all[0].begin() + 1, all[0].end());
  std::string html;
  for (const auto& [scenario, seeds] : board.common) {
    std::vector<TableRow> lines;
    for (std::size_t i = 1; i < all.size(); ++i) {
      if (all[i][0] != scenario) continue;
      TableRow& line = lines.emplace_back();
      for (std::size_t k = 1; k < all[i].size(); ++k) line.cells.push_back(text_cell(all[i][k]));
    }
    html += sections_html({{"scenario-" + scenario, scenario,
                            table_html(scenario, titles, lines, true) + "<p>" +
                                escaped(ranking_text(scenario, board)) + ".</p>\n"}});
  }
  for (const std::string& why : board.left_out) html += "<p class='bad'>Skipped: " + escaped(why) + "</p>\n";
  html += "<h2>Metrics</h2>\n<dl>\n";
  for (const std::string& metric : board.metrics)
    html += fmt::format("<dt><code>{}</code></dt><dd>{}</dd>\n", escaped(metric),
                        escaped(score::find_metric(metric)->definition));
  return html_page(
      "Leaderboard",
      std::string("A row contains a folder's results of one scenario, estimator, settings and programs. ") +
          kRemark +
          "; the seeds are those that all rows of a scenario have, and a row without these has no "
          "rank. The best row comes first: by coverage, then by the first metric. Coverage is the fraction "
          "of true poses with an estimate, averaged over the runs; a run that did not complete counts as 0.",
      html + "</dl>\n");
}

}  // namespace sim::pages
