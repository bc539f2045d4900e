#include <cstdlib>
#include <future>
#include <iostream>
#include <set>

#include "sim/pages/pages.h"
#include "sim/view/site.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {
namespace {

constexpr const char* kReportExamples = R"(Examples:
  gaitslam report results/tangent_circle/seed-1 --out report.html
  gaitslam report results/regress-ci --out report.html  # a folder of results
  gaitslam report results/sweep-hall --out report.html  # a sweep, plotted over its keys
  gaitslam report results/tangent_circle/seed-1 --plots pdf --width-mm 88 --no-titles --out figures
  gaitslam report results/filter results/odometry --table table.tex   # or table.md, table.csv
  gaitslam report results/filter results/odometry --table t.tex --metrics ate_se3_rmse_m,rpe_1m_m,frame_cpu_ms_median
A table has a row per estimator, controller, robot and setting; rows with other errors.* are not ranked against each other.
Errors are in mm and deg, in a .csv file in the metric's unit. A note below it says what value and bracket are. --metrics
takes each metric of score.json and frame_cpu_ms_median, step_slip_m and joint_power_w (a recording is needed).
The page contains everything that it shows and needs no network.)";

constexpr double kPx_mm = 25.4 / 96, kHeight = 5 / 12.0, kEqualHeight = 7 / 9.0;  // per width

struct ReportRequest : OutRequest {
  std::vector<std::string> results;
  std::string plots;               ///< format of the plots; empty: a page
  double width_mm = 720 * kPx_mm;  ///< width of plots
  bool no_titles = false;
  std::optional<std::string> table;  ///< a file
  std::vector<std::string> metrics;
};

/// Returns a path relative to the current folder: pages are passed on, and a home folder's path is private.
fs::path from_here(const fs::path& path) {
  return fs::absolute(path).lexically_proximate(fs::current_path());
}

std::vector<fs::path> result_folders(const std::vector<std::string>& named) {
  std::vector<fs::path> all;
  std::set<fs::path> counted;  // a result may be below several of the given folders
  for (const std::string& name : named) {
    if (!fs::is_directory(name)) throw UsageError("{}: no such result folder", name);
    if (pages::is_sweep(name) || pages::is_tuning(name))
      throw UsageError(
          "{}: is a sweep or tuning with its own page; report it separately, without --plots or --table",
          name);
    const std::vector<fs::path> found = result::find_results(name);
    if (found.empty())
      throw UsageError(
          "{}: has no results, expected a result folder (score.json), a folder of results, or the folder of "
          "a sweep or tuning",
          name);
    for (const fs::path& one : found)
      if (counted.insert(fs::canonical(one)).second) all.push_back(from_here(one));
  }
  return all;
}

constexpr const char* kConverter = "rsvg-convert";  // from Debian's package librsvg2-bin

/// Converts an SVG file to PDF and removes it. Throws std::runtime_error.
void make_pdf(const fs::path& svg) {
  const int status =
      std::system(fmt::format("exec {} --format=pdf --output={} {}", kConverter,
                              files::shell_word(fs::path(svg).replace_extension("pdf").string()),
                              files::shell_word(svg.string()))
                      .c_str());
  if (status != 0) throw std::runtime_error(fmt::format("{} failed to convert {}", kConverter, svg.string()));
  fs::remove(svg);
}

void write_plots(const std::vector<pages::Figure>& figures, const ReportRequest& request,
                 const fs::path& folder) {
  const double width = request.width_mm / kPx_mm;
  for (const pages::Figure& figure : figures) {
    const fs::path svg = folder / (figure.name + ".svg");
    files::write_atomically(
        svg, to_svg(figure, width, width * (figure.equal_axes ? kEqualHeight : kHeight),
                    request.no_titles ? pages::Surroundings::untitled : pages::Surroundings::titled));
    if (request.plots == "pdf") make_pdf(svg);
  }
}

void make_plots(const std::vector<pages::RunData>& runs, const ReportRequest& request, const OutFolder& out) {
  for (const pages::RunData& run : runs) require_separate(out.path(), run.folder);
  files::AtomicFolder folder(out.path());
  for (const pages::RunData& run : runs) {
    const fs::path own = runs.size() == 1 ? folder.path() : folder.path() / run.folder.filename();
    fs::create_directories(own);
    write_plots(run_figures(run), request, own);
  }
  for (const auto& [scenario, figures] : comparison_figures(runs))
    write_plots(figures, request, folder.path());
  folder.commit();
}

std::vector<pages::RunData> read_runs(const ReportRequest& request, ProgressLine& progress) {
  const std::vector<fs::path> folders = result_folders(request.results);
  std::vector<pages::RunData> runs;
  for (const fs::path& folder : folders) {
    runs.push_back(pages::read_run(folder));
    progress.show(0.5 * double(runs.size()) / double(folders.size()), "reading");
  }
  return runs;
}

/// Throws UsageError.
void write_table(const ReportRequest& request) {
  pages::TableFormat format;
  try {
    format = pages::table_format(*request.table);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--table {}", error.what());
  }
  require_new_file(*request.table, request.force, "--table");
  ProgressLine progress("report");
  files::write_atomically(*request.table,
                          pages::runs_table(read_runs(request, progress), format, request.metrics));
}

/// Throws UsageError.
void require_metrics(const ReportRequest& request) {
  const std::vector<std::string> known = pages::table_metrics();
  const fs::path first = request.results.front();
  if (!request.metrics.empty() && !request.table &&
      (!request.plots.empty() || pages::is_sweep(first) || pages::is_tuning(first)))
    throw UsageError("--metrics: applies to --table and to the page of runs only");
  for (const std::string& metric : request.metrics) {
    if (std::ranges::count(known, metric) == 0)
      throw UsageError("--metrics: unknown metric '{}'{}; gaitslam config --keys lists them", metric,
                       scenario::did_you_mean(metric, known));
    if (std::ranges::count(request.metrics, metric) > 1)
      throw UsageError("--metrics: {} is given twice", metric);
  }
}

int make_report(ReportRequest& request) {
  require_metrics(request);
  if (!request.out && (!request.table || !request.plots.empty()))
    throw UsageError("--out: is missing, expected the HTML file to write, or --table with a file");
  if (request.table) {
    write_table(request);
    std::cout << "table in " << *request.table << '\n';
  }
  if (!request.out) return 0;
  if (request.plots == "pdf" && std::system(fmt::format("command -v {} >/dev/null", kConverter).c_str()) != 0)
    throw UsageError(
        "--plots pdf: {} is missing; install Debian's package librsvg2-bin, or use "
        "--plots svg",
        kConverter);
  if (!request.plots.empty()) {
    const OutFolder out(request, {}, OutUse::result);
    {
      ProgressLine progress("report");
      make_plots(read_runs(request, progress), request, out);
    }
    std::cout << "figures in " << *request.out << '\n';
    return 0;
  }
  require_new_file(*request.out, request.force);
  if (const fs::path kind = fs::path(*request.out).extension(); kind != ".html" && kind != ".htm")
    throw UsageError("--out {}: expected a name ending in .html; --plots writes pictures", *request.out);
  const OnInterrupt on_interrupt("nothing was written; rerun the command");
  {
    ProgressLine progress("report");
    const fs::path first = from_here(request.results.front());
    const bool alone = request.results.size() == 1;
    files::write_atomically(*request.out,
                            alone && pages::is_sweep(first) ? pages::sweep_page(first)
                            : alone && pages::is_tuning(first)
                                ? pages::tune_page(first)
                                : pages::runs_page(read_runs(request, progress), request.metrics));
  }
  std::cout << "report in " << *request.out << '\n';
  return 0;
}

constexpr const char* kViewExamples = R"(Examples:
  gaitslam view results/tangent_circle/seed-1 results/tangent_circle/seed-1/replay   # compared in one scene
  gaitslam view results/tangent_circle/seed-1/replay --port 8020
Prints a URL; append #t=SECONDS to open it at that time. Ctrl-C ends the view. gaitslam run --view shows a walk live.)";

struct RequestToView : Access {
  std::vector<std::string> results;
};

void require_results(const std::vector<std::string>& results) {
  if (results.size() > view::kMostRuns)
    throw UsageError("view: {} results, expected 1 to {} of one scenario", results.size(), view::kMostRuns);
  for (const std::string& result : results) {
    if (!fs::is_directory(result)) throw UsageError("{}: no such result folder", result);
    if (result::is_result(result)) continue;
    if (fs::exists(fs::path(result) / "manifest.csv") || fs::exists(fs::path(result) / "mav0"))
      throw UsageError("{}: is a recording, expected a result folder (score.json); gaitslam replay makes one",
                       result);
    const std::vector<fs::path> found = result::find_results(result);
    throw UsageError("{}: expected a result folder (score.json), such as {}", result,
                     found.empty() ? "results/tangent_circle/seed-1" : found.front().string());
  }
}

int view_results(RequestToView& request) {
  require_results(request.results);
  const BlockedInterrupts blocked;  // also in the server's thread
  view::PlaybackView shown(request);
  print_view(view::url(shown.access()));
  auto read = std::async(std::launch::async, [&] {
    const view::MakeRobot make_robot = view::robot_maker(standard_models());
    std::vector<view::Playback> results;
    for (const std::string& result : request.results)
      results.push_back(
          view::read_playback(result, make_robot, {request.results.begin(), request.results.end()}));
    shown.show(std::move(results));
  });
  while (read.wait_for(std::chrono::milliseconds(10)) != std::future_status::ready)
    if (blocked.pending()) std::_Exit(0);  // reading leaves nothing to tidy up
  read.get();
  blocked.wait();
  return 0;
}

}  // namespace

void add_report(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "report", "Write an HTML page, or pictures, about results", kReportExamples,
                  make_report);
  command.add_option("results", request.results, "result folders, folders of results, a sweep or a tuning")
      ->required();
  command.add_option("--out", request.out, "the HTML file to write; with --plots, a folder");
  command.add_option("--table", request.table,
                     "write a table by estimator, controller, robot and setting to a .csv, .md or .tex file");
  command
      .add_option("--metrics", request.metrics,
                  "metrics of the table, such as ate_se3_rmse_m,rmse_m; the first one ranks the rows")
      ->delimiter(',')
      ->allow_extra_args(false);
  auto* const plots =
      command.add_option("--plots", request.plots, "write pictures instead of a page: svg, pdf")
          ->check(CLI::IsMember({"svg", "pdf"}));
  command.add_option("--width-mm", request.width_mm, "width of the pictures, 60 to 400; text keeps its size")
      ->check(CLI::Range(60, 400))
      ->needs(plots);
  command.add_flag("--no-titles", request.no_titles, "omit titles, for figures with captions")->needs(plots);
  command.add_flag("--force", request.force, "replace a file, or a folder of pictures made by gaitslam");
}

void add_view_command(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "view", "Show finished results in the browser: robot, images, map and errors over time",
      kViewExamples, view_results);
  command.add_option("results", request.results, "one result folder, or up to four of one scenario")
      ->required();
  add_view_place(command, request);
}

}  // namespace cli
