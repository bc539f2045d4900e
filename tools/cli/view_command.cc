#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>

#include "sim/files/text.h"
#include "sim/view/site.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

namespace view = sim::view;

constexpr const char* kViewExamples = R"(
Examples:
  gaitslam view results/tangent_circle/seed-1 results/tangent_circle/seed-2      # side by side
  gaitslam view results/tangent_circle/seed-1/replay --port 8020
Prints a URL; #t=SECONDS after it opens that time. Ctrl-C ends the view. gaitslam run --view shows a walk live.)";

struct RequestToView : Access {
  std::vector<std::string> results;
  fs::path models = standard_models();
};

void require_results(const std::vector<std::string>& results) {
  if (results.size() > 2)
    throw UsageError(fmt::format("view: {} results, expected one or two of one scenario", results.size()));
  for (const std::string& result : results) {
    if (!fs::is_directory(result)) throw UsageError(fmt::format("{}: no such result folder", result));
    if (fs::exists(fs::path(result) / "score.json")) continue;
    if (fs::exists(fs::path(result) / "manifest.csv") || fs::exists(fs::path(result) / "mav0"))
      throw UsageError(fmt::format(
          "{}: is a recording, expected a result folder (score.json); gaitslam replay makes one", result));
    const std::vector<std::string> seeds = results_of_other_seeds(result, {});
    throw UsageError(fmt::format(
        "{}: expected a result folder (score.json), such as {}", result,
        seeds.empty() ? "results/tangent_circle/seed-1" : (fs::path(result) / seeds.front()).string()));
  }
}

int view_results(RequestToView& request) {
  require_results(request.results);
  const view::MakeRobot make_robot = view::robot_maker(request.models);
  std::vector<view::Playback> results;
  for (const std::string& result : request.results)
    results.push_back(view::read_playback(result, make_robot));
  sigset_t signals{};
  ::sigemptyset(&signals);
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&signals, one);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // before the server's threads, which inherit it
  const view::PlaybackView shown(request, results);
  print_view(view::url(shown.access()));
  int which = 0;
  ::sigwait(&signals, &which);
  return 0;
}

}  // namespace

void add_view_command(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "view", "Show finished results in the browser: robot, images, map and errors over time",
      kViewExamples, view_results);
  command.add_option("results", request.results, "one result folder, or two of one scenario")->required();
  add_view_place(command, request);
  add_models(command, request.models);
}

}  // namespace cli
