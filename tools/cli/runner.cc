// The commands of the runner, the smaller program that tools/gaitslam builds first; it has no view.
#include "sim/view/session.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/terminal.h"

std::unique_ptr<sim::view::ViewSession> sim::view::view_of_run(const ViewRequest& request,
                                                               const scenario::ReadScenario&,
                                                               const fs::path&) {
  if (request.view)
    throw cli::UsageError("--view: this program was built without it; tools/gaitslam builds the full one");
  return nullptr;
}

std::vector<cli::AddCommand*> cli::commands() {
  return {add_run, add_record, add_replay, add_config, add_element, add_help};
}
