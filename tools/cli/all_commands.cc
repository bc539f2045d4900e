#include "tools/cli/commands.h"

namespace cli {

void add_commands(CLI::App& app, int& exit_code) {
  add_run(app, exit_code);
  add_record(app, exit_code);
  add_replay(app, exit_code);
  add_evaluate(app, exit_code);
  add_export(app, exit_code);
  add_view_command(app, exit_code);
  add_video(app, exit_code);
  add_score(app, exit_code);
  add_regress(app, exit_code);
  add_compare(app, exit_code);
  add_leaderboard(app, exit_code);
  add_baseline(app, exit_code);
  add_sweep(app, exit_code);
  add_trials(app, exit_code);
  add_tune(app, exit_code);
  add_check(app, exit_code);
  add_report(app, exit_code);
  add_reproduce(app, exit_code);
  add_cache(app, exit_code);
  add_config(app, exit_code);
}

}  // namespace cli
