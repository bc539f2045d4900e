// The runner, which tools/gaitslam builds for those who do not view.
#include "tools/cli/usage_error.h"
#include "tools/cli/view_session.h"

namespace cli {
namespace {

void require_no_view(const ViewRequest& request) {
  if (request.view)
    throw UsageError("--view: this program was built without it; tools/gaitslam builds the whole one");
}

}  // namespace

std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const sim::scenario::ReadScenario&,
                                         const std::filesystem::path&) {
  require_no_view(request);
  return nullptr;
}

std::unique_ptr<ViewSession> view_of_replay(const ViewRequest& request, const sim::scenario::ReadScenario&,
                                            const std::filesystem::path&, const std::filesystem::path&) {
  require_no_view(request);
  return nullptr;
}

}  // namespace cli
