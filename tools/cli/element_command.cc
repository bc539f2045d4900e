#include "tools/cli/commands.h"
#include "tools/cli/jobs/jobs.h"
#include "tools/cli/shared/options.h"

namespace cli {

/// The hidden command of an array element.
void add_element(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "element", "Run the jobs of an array element", "", run_element);
  command.group("");
  command.add_option("folder", request.folder)->required();
  command.add_option("each", request.each)->required();
}

}  // namespace cli
