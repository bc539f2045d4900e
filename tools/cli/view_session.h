// Options of the view in the browser, and the view of a run or a replay that goes on. The runner, which is
// built without the view, has none (view_none.cc).
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"

namespace sim::live {
struct RunObserver;
}

namespace cli {

/// Where the view listens.
struct ViewPlace {
  std::string address = "127.0.0.1", token;
  std::uint16_t port = 0;
};

struct ViewRequest : ViewPlace {
  bool view = false, control = false, wait = false;
  bool next_follows = false;  ///< set by a command that shows one walk after the other
};

/// --address, --port and --token.
void add_view_place(CLI::App& command, ViewPlace& place);
/// Besides these --view, --control and --wait.
void add_view(CLI::App& command, ViewRequest& request);

/// What the command line of a process has, so that it shows its walk there as one of several. The token is in
/// the environment, which other users of the machine cannot read.
inline constexpr const char* kViewToken = "GAITSLAM_VIEW_TOKEN";
std::vector<std::string> view_arguments(const ViewRequest& request);

/// A view that is open as long as this lives.
class ViewSession {
 public:
  virtual ~ViewSession() = default;
  /// What the loop of a run, or of a replay, is to call.
  virtual const sim::live::RunObserver& run_observer() const = 0;
  virtual const sim::tracking::TrackingObserver& tracking_observer() const = 0;
  /// Tells the viewers how it ended.
  virtual void end(const std::string& how) = 0;
};

/// Null unless asked for. Prints the URL. Throws UsageError in a program without the view, and what opening a
/// view throws.
std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const sim::scenario::ReadScenario& read,
                                         const std::filesystem::path& models);
/// recording: the one that is replayed.
std::unique_ptr<ViewSession> view_of_replay(const ViewRequest& request,
                                            const sim::scenario::ReadScenario& read,
                                            const std::filesystem::path& recording,
                                            const std::filesystem::path& models);

}  // namespace cli
