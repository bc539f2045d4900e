// The subcommands of gaitslam: each adds itself to the program's command line and sets its exit code.
#pragma once

namespace CLI {
class App;
}

namespace cli {

/// All subcommands: runner_commands.cc defines it for the runner, which is built first, all_commands.cc for
/// the whole program.
void add_commands(CLI::App& app, int& exit_code);

void add_run(CLI::App& app, int& exit_code);
void add_record(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_evaluate(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_view_command(CLI::App& app, int& exit_code);
void add_video(CLI::App& app, int& exit_code);
void add_score(CLI::App& app, int& exit_code);
void add_regress(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_leaderboard(CLI::App& app, int& exit_code);
void add_baseline(CLI::App& app, int& exit_code);
void add_sweep(CLI::App& app, int& exit_code);
void add_trials(CLI::App& app, int& exit_code);
void add_tune(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_report(CLI::App& app, int& exit_code);
void add_reproduce(CLI::App& app, int& exit_code);
void add_cache(CLI::App& app, int& exit_code);
void add_config(CLI::App& app, int& exit_code);

}  // namespace cli
