#include "tools/cli/commands.h"

namespace cli {

void add_commands(CLI::App& app, int& exit_code) {
  add_run(app, exit_code);
  add_record(app, exit_code);
  add_replay(app, exit_code);
  add_score(app, exit_code);
  add_check(app, exit_code);
  add_config(app, exit_code);
}

}  // namespace cli
