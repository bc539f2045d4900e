// The subcommands of gaitslam. Each function adds a command to the command line; the command sets exit_code.
#pragma once

#include <vector>

namespace CLI {
class App;
}

namespace cli {

using AddCommand = void(CLI::App& app, int& exit_code);

AddCommand add_run, add_record, add_replay, add_evaluate, add_export, add_view_command, add_video, add_score,
    add_regress, add_compare, add_baseline, add_sweep, add_trials, add_element, add_tune, add_check,
    add_report, add_reproduce, add_cache, add_config, add_robot, add_walker, add_help;

/// Returns the subcommands of the runner, which is built first (runner.cc), or of the full program.
std::vector<AddCommand*> commands();

}  // namespace cli
