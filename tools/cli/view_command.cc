#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>

#include <iostream>
#include <memory>
#include <vector>

#include "sim/files/text.h"
#include "sim/view/playback.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/view_session.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace view = sim::view;

constexpr const char* kViewExamples = R"(
Examples:
  gaitslam view results/tangent_circle/seed-1
  gaitslam view results/tangent_circle/seed-1 results/tangent_circle/seed-2      # side by side
  gaitslam view results/tangent_circle/seed-1/replay --port 8020
Prints a URL; #t=SECONDS after it opens that time. Ctrl-C ends the view. gaitslam run --view shows a walk live.)";

struct RequestToView : ViewPlace {
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

/// While it exists, the signals that end a program only end wait().
class UntilInterrupted {
 public:
  UntilInterrupted() {
    ::sigemptyset(&signals_);
    for (const int one : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&signals_, one);
    ::pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  ~UntilInterrupted() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  UntilInterrupted(const UntilInterrupted&) = delete;
  UntilInterrupted& operator=(const UntilInterrupted&) = delete;

  void wait() const {
    int which = 0;
    ::sigwait(&signals_, &which);
  }

 private:
  sigset_t signals_{}, before_{};
};

int view_results(const RequestToView& request) {
  require_results(request.results);
  const view::MakeRobot make_robot = view::robot_maker(request.models);
  std::vector<view::Playback> results;
  for (const std::string& result : request.results)
    results.push_back(view::read_playback(result, make_robot));
  const UntilInterrupted interrupted;  // before the server's threads, which inherit it
  const view::PlaybackView shown({request.address, request.port, request.token}, results);
  print_view(view::url(shown.access()));
  interrupted.wait();
  return 0;
}

}  // namespace

void add_view_command(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<RequestToView>();
  CLI::App* command = app.add_subcommand(
      "view", "Show finished results in the browser: robot, images, map and errors over time");
  command->add_option("results", request->results, "one result folder, or two of one scenario")->required();
  add_view_place(*command, *request);
  add_models(*command, request->models);
  command->footer(kViewExamples);
  command->callback([request, &exit_code] { exit_code = view_results(*request); });
}

}  // namespace cli
