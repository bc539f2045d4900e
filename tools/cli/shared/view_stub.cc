// The runner, which tools/gaitslam builds for users without the view.
#include "tools/cli/shared/usage_error.h"
#include "tools/cli/shared/view_session.h"

namespace sim::view {
namespace {

void require_no_view(const ViewRequest& request) {
  if (request.view)
    throw cli::UsageError("--view: this program was built without it; tools/gaitslam builds the whole one");
}

}  // namespace

std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario&,
                                         const std::filesystem::path&) {
  require_no_view(request);
  return nullptr;
}

std::unique_ptr<ViewSession> view_of_replay(const ViewRequest& request, const scenario::ReadScenario&,
                                            const std::filesystem::path&, const std::filesystem::path&) {
  require_no_view(request);
  return nullptr;
}

}  // namespace sim::view
