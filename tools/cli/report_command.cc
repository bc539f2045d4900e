#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string_view>

#include "sim/files/atomic_file.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/pages/run_figures.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/child.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/interruption.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace pages = sim::pages;

constexpr const char* kReportExamples = R"(
Examples:
  gaitslam report results/tangent_circle/seed-1 --out report.html
  gaitslam report results/tangent_circle --out report.html            # all seeds of the folder
  gaitslam report results/regress-ci --out report.html                # a suite, or any folder of results, by scenario
  gaitslam report results/sweep-hall --out report.html                # a sweep: heat maps or lines over its keys
  gaitslam report results/tangent_circle/seed-1 --plots svg,png --out figures   # pictures in a folder
The page contains everything that it shows and needs no network.)";

constexpr double kWidth = 720, kHeight = 300, kEqualHeight = 560;  // px of pictures

struct ReportRequest {
  std::vector<std::string> results;
  std::string out;
  std::vector<std::string> plots;
  bool force = false;
};

bool is_result(const fs::path& folder) { return fs::exists(folder / "score.json"); }

bool has_own_page(const fs::path& folder) { return pages::is_sweep(folder) || pages::is_tuning(folder); }

/// The results seed-<n> of a folder, in numerical order.
std::vector<fs::path> seeds_in(const fs::path& folder) {
  constexpr std::string_view kSeed = "seed-";
  std::vector<std::pair<std::uint64_t, fs::path>> seeds;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(kSeed) || !is_result(entry.path())) continue;
    const auto seed = sim::files::parse_number<std::uint64_t>(std::string_view(name).substr(kSeed.size()));
    if (!seed)
      throw UsageError(
          fmt::format("{}: expected a name seed-<n> with a whole number; a result of another name "
                      "is reported by naming its folder",
                      entry.path().string()));
    seeds.push_back({*seed, entry.path()});
  }
  std::sort(seeds.begin(), seeds.end());
  std::vector<fs::path> folders;
  for (const auto& [seed, path] : seeds) folders.push_back(path);
  return folders;
}

/// The folder itself if it is a result, else its seeds, else the results of the folders in it, without
/// replays, exports and results set aside.
std::vector<fs::path> results_in(const fs::path& folder) {
  if (is_result(folder)) return {folder};
  std::vector<fs::path> all = seeds_in(folder);
  if (!all.empty()) return all;
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (entry.is_directory() && !entry.is_symlink() && !name.starts_with(".") &&
        !name.starts_with("earlier-") && name != "export")
      below.push_back(entry.path());
  }
  std::sort(below.begin(), below.end());
  for (const fs::path& next : below) {
    const std::vector<fs::path> found = results_in(next);
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

std::vector<fs::path> result_folders(const std::vector<std::string>& named) {
  std::vector<fs::path> all;
  for (const std::string& name : named) {
    if (!fs::is_directory(name)) throw UsageError(fmt::format("{}: no such result folder", name));
    if (has_own_page(name))
      throw UsageError(
          fmt::format("{}: is a sweep or a tuning with its own page: report it separately, "
                      "without --plots",
                      name));
    const std::vector<fs::path> found = results_in(name);
    if (found.empty())
      throw UsageError(
          fmt::format("{}: expected a result folder (score.json), a folder of results, or the "
                      "folder of a sweep or tuning",
                      name));
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

/// Writes figures as files; rsvg-convert makes the PNG files.
void write_plots(const std::vector<pages::Figure>& figures, const fs::path& folder,
                 const ReportRequest& request) {
  const auto wanted = [&](const char* format) {
    return std::find(request.plots.begin(), request.plots.end(), format) != request.plots.end();
  };
  for (const pages::Figure& figure : figures) {
    const fs::path svg = folder / (figure.name + ".svg"), png = folder / (figure.name + ".png");
    sim::files::write_atomically(svg, to_svg(figure, kWidth, figure.equal_axes ? kEqualHeight : kHeight));
    if (wanted("png")) FedChild({"rsvg-convert", "--zoom", "2", "-o", png.string(), svg.string()}).finish();
    if (!wanted("svg")) fs::remove(svg);
  }
}

int make_plots(const std::vector<pages::RunData>& runs, const ReportRequest& request, const OutFolder& out) {
  for (const pages::RunData& run : runs) require_outside(out.path(), run.folder);
  sim::files::AtomicFolder folder(out.path(), sim::files::Existing::replace);
  for (const pages::RunData& run : runs) {
    const fs::path own = runs.size() == 1 ? folder.path() : folder.path() / run.folder.filename();
    fs::create_directories(own);
    write_plots(run_figures(run), own, request);
  }
  write_plots(comparison_figures(runs), folder.path(), request);
  folder.commit();
  std::cout << "figures in " << request.out << '\n';
  return 0;
}

std::vector<pages::RunData> read_runs(const ReportRequest& request, ProgressLine& progress) {
  const std::vector<fs::path> folders = result_folders(request.results);
  std::vector<pages::RunData> runs;
  for (const fs::path& folder : folders) {
    runs.push_back(pages::read_run(folder));
    progress.show(0.5 * static_cast<double>(runs.size()) / static_cast<double>(folders.size()), "reading");
  }
  return runs;
}

std::string page_of(const ReportRequest& request, ProgressLine& progress) {
  const fs::path first = request.results.front();
  if (request.results.size() == 1 && pages::is_sweep(first)) return pages::sweep_page(first);
  if (request.results.size() == 1 && pages::is_tuning(first)) return pages::tune_page(first);
  return pages::runs_page(read_runs(request, progress));
}

int make_report(const ReportRequest& request) {
  if (!request.plots.empty()) {
    const OutFolder out({request.out, request.force}, {}, {.replaces = true});
    ProgressLine progress("report");
    return make_plots(read_runs(request, progress), request, out);
  }
  require_new_file(request.out, request.force);
  const OnInterrupt on_interrupt("nothing was written; rerun the command");
  {
    ProgressLine progress("report");
    sim::files::write_atomically(request.out, page_of(request, progress));
  }
  std::cout << "report in " << request.out << '\n';
  return 0;
}

}  // namespace

void add_report(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<ReportRequest>();
  CLI::App* command = app.add_subcommand("report", "Write an HTML page, or pictures, about results");
  command
      ->add_option("results", request->results, "result folders or folders of results; a sweep or a tuning")
      ->required();
  command->add_option("--out", request->out, "the HTML file to write; with --plots a folder")->required();
  command->add_option("--plots", request->plots, "write pictures instead of a page: svg, png or both")
      ->delimiter(',')
      ->check(CLI::IsMember({"svg", "png"}));
  command->add_flag("--force", request->force,
                    "overwrite an existing file, or a folder of pictures made by gaitslam");
  command->footer(kReportExamples);
  command->callback([request, &exit_code] { exit_code = make_report(*request); });
}

}  // namespace cli
