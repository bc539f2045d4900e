// Arguments and options shared by several subcommands.
#pragma once

#include <sys/types.h>

#include <CLI/CLI.hpp>

#include "sim/scenario/robot.h"
#include "sim/score/trajectory.h"
#include "sim/view/session.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

using scenario::standard_models;
using view::Access;
using view::ViewRequest;
struct Backend;  // jobs/jobs.h

/// Adds a subcommand and returns it with its request, which `run` handles. examples: the end of its help.
template <typename Request>
std::pair<CLI::App&, Request&> add_command(CLI::App& app, int& exit_code, const char* name,
                                           const char* description, const char* examples,
                                           int (*run)(Request&)) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand(name, description);
  command->footer(std::string(examples) +
                  "\nExit code of each command: 74 the disk is full or a device failed.");
  command->callback([request, run, &exit_code] { exit_code = run(*request); });
  return {*command, *request};
}

/// Adds --quiet, or --quiet and --json, as flags.
void add_quiet(CLI::App& command);
void add_output(CLI::App& command);
/// Adds --jobs, with this help text, and --backend.
void add_backend_options(CLI::App& command, Backend& backend,
                         const char* jobs = "processes at a time (default 1), or array elements on Slurm");
/// Adds the file argument `scenario`, key=value arguments, --with and --without.
CLI::Option* add_scenario(CLI::App& command, std::string& file, scenario::Changes& changes);
/// Adds the arguments key=value. which: describes the keys that may be changed.
inline void add_overrides(CLI::App& command, std::vector<std::string>& overrides, const std::string& which) {
  command.add_option("changes", overrides, "scenario keys and their new values " + which)
      ->option_text("key=value ...");
}
inline void add_with(CLI::App& command, scenario::Changes& changes) {
  command.add_option("--with", changes.with, "YAML file with keys to set, such as a best.yaml; repeatable")
      ->option_text("FILE")
      ->allow_extra_args(false);
}
inline void add_without(CLI::App& command, scenario::Changes& changes) {
  command.add_option("--without", changes.without, "sections to omit, such as camera,slam")
      ->delimiter(',')
      ->allow_extra_args(false);
}
/// Adds the argument `result`, the folder of a run.
inline void add_result(CLI::App& command, fs::path& result, const std::string& or_else = "") {
  command.add_option("result", result, "a result folder, such as results/tangent_circle/seed-1" + or_else)
      ->required();
}
/// Adds --seeds. what: the start of its help text.
inline void add_seeds(CLI::App& command, std::optional<std::string>& seeds, const std::string& what) {
  command.add_option("--seeds", seeds, what + ": 1..5 or 1,2,7");
}
inline void add_cached(CLI::App& command, bool& cached) {
  command.add_flag("--cached", cached, "replay recordings from the cache, and record missing ones first");
}
inline void add_all_metrics(CLI::App& command, bool& all) {
  command.add_flag("--all-metrics", all, "show all metrics, not only the main ones and metrics with limits");
}

/// Hidden options for a process started by another gaitslam process.
struct BatchMember {
  std::optional<pid_t> parent;       ///< this process ends when that one ends
  std::optional<fs::path> set_by{};  ///< file with the origin of each key
};
inline void add_batch_member(CLI::App& command, BatchMember& member) {
  command.add_option("--set-by", member.set_by)->group("");
  command.add_option("--die-with-parent", member.parent)->group("");
}
/// Makes the kernel end this process when its parent ends, and reads the origin of each key from the file.
void join_batch(const BatchMember& member, scenario::ReadScenario* read = nullptr);

/// Throws UsageError, which suggests the most similar name, if `typed` is not one of the names.
void require_one_of(const std::vector<std::string>& names, const std::string& typed,
                    const std::string& option);
/// Returns the alignment typed after --align. Throws UsageError.
score::Alignment alignment_named(const std::string& name);

/// Returns the seeds typed after --seeds. Throws UsageError.
std::vector<std::uint64_t> parse_seeds(const std::string& text);

/// Adds --port, --address, --public and --token.
void add_view_place(CLI::App& command, Access& place);
/// Also adds --view, --control and --wait. An opened view prints its URL.
void add_view(CLI::App& command, ViewRequest& request);
/// Prints the URL to standard output, or to standard error with --quiet or --json.
void print_view(const std::string& url);

/// Prints the warnings of a scenario to standard error.
void print_warnings(const scenario::ReadScenario& read);
/// Throws ConfigError "file:line: world.room: is 'kitchen', expected one of ..." for a missing robot or room.
void require_models(const scenario::ReadScenario& read, const fs::path& models);

}  // namespace cli
