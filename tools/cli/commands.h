// The subcommands of gaitslam: each adds itself to the program's command line and leaves its exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <stdexcept>

#include "sim/bench/scenario.h"

namespace cli {

/// What a command line asks for cannot be done; main prints it and ends with exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The option --with, which reads overlays into `changes`.
void add_with(CLI::App* command, sim::bench::Changes& changes);

void add_run(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_video(CLI::App& app, int& exit_code);
void add_score(CLI::App& app, int& exit_code);
void add_tune(CLI::App& app, int& exit_code);
void add_regress(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_baseline(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_report(CLI::App& app, int& exit_code);
void add_reproduce(CLI::App& app, int& exit_code);
void add_config(CLI::App& app, int& exit_code);

}  // namespace cli
