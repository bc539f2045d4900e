// The commands of the runner, the smaller program that tools/gaitslam builds first; it has no view.
#include "sim/view/session.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/terminal.h"

namespace sim::view {
namespace {

std::unique_ptr<ViewSession> no_view(const ViewRequest& request) {
  if (request.view)
    throw cli::UsageError("--view: this program was built without it; tools/gaitslam builds the full one");
  return nullptr;
}

}  // namespace

std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario&,
                                         const fs::path&) {
  return no_view(request);
}

std::unique_ptr<ViewSession> view_of_replay(const ViewRequest& request, const scenario::ReadScenario&,
                                            const fs::path&, const fs::path&) {
  return no_view(request);
}

}  // namespace sim::view

std::vector<cli::AddCommand*> cli::commands() {
  return {add_run, add_record, add_replay, add_config, add_element, add_help};
}
