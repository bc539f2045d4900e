#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/pages/leaderboard.h"
#include "sim/scenario/limits.h"
#include "sim/scenario/yaml.h"
#include "sim/score/metrics.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {
namespace {

namespace pages = sim::pages;

constexpr const char* kLeaderboardExamples = R"(
Examples:
  gaitslam leaderboard results
  gaitslam leaderboard results --metric ate_sim3_rmse_m --metric tracked_fraction
  gaitslam leaderboard results --csv table.csv --html table.html
A row for each scenario, estimator and folder of results, with the best of a scenario first: by
coverage (share of true poses with an estimate; 0 of an incomplete run), then by the first metric.
Errors after an alignment have columns of their own, such as rmse_m_after_sim3. Keys are listed if
rows of the same scenario and estimator differ in them. Results that cannot be read are left out.)";

struct LeaderboardRequest {
  std::vector<fs::path> folders;
  std::vector<std::string> metrics;
  std::optional<std::string> csv, html;
  bool force = false;
};

void require_metric(const std::string& name) {
  if (!sim::score::find_metric(name))
    throw UsageError(fmt::format("--metric {}: {}", name, sim::scenario::unknown_metric(name)));
}

int show_leaderboard(const LeaderboardRequest& request) {
  for (const auto& [file, option] : {std::pair{request.csv, "--csv"}, {request.html, "--html"}})
    if (file) require_new_file(*file, request.force, option);
  for (const std::string& metric : request.metrics) require_metric(metric);
  const pages::Leaderboard board = pages::leaderboard(
      request.folders, request.metrics.empty() ? pages::leaderboard_metrics() : request.metrics);
  if (request.csv) sim::files::write_atomically(*request.csv, pages::leaderboard_csv(board));
  if (request.html) sim::files::write_atomically(*request.html, pages::leaderboard_page(board));
  std::cout << pages::leaderboard_table(board);
  for (const std::string& why : board.left_out) std::cerr << "warning: left out: " << why << '\n';
  return 0;
}

}  // namespace

void add_leaderboard(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<LeaderboardRequest>();
  CLI::App* command =
      app.add_subcommand("leaderboard", "Put the estimators in a tree of results into one table");
  command->add_option("folders", request->folders, "folders of results, at any depth")->required();
  command->add_option("--metric", request->metrics, "a metric to show; may be given several times")
      ->allow_extra_args(false);
  command->add_option("--csv", request->csv, "write the table as CSV to a file");
  command->add_option("--html", request->html, "write the table as a page to a file");
  command->add_flag("--force", request->force, "replace existing files");
  command->footer(kLeaderboardExamples);
  command->callback([request, &exit_code] { exit_code = show_leaderboard(*request); });
}

}  // namespace cli
