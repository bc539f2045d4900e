// The subcommands of gaitslam that keep recordings and try many settings on them; see commands.h.
#pragma once

namespace CLI {
class App;
}

namespace cli {

void add_record(CLI::App& app, int& exit_code);
void add_cache(CLI::App& app, int& exit_code);
void add_sweep(CLI::App& app, int& exit_code);
void add_trials(CLI::App& app, int& exit_code);

}  // namespace cli
