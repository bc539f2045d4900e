// Arguments and options shared by several subcommands.
#pragma once

#include <sys/types.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {

/// The file argument `scenario`, key=value arguments, --with and --without.
CLI::Option* add_scenario(CLI::App& command, std::string& file, sim::scenario::Changes& changes);
/// The arguments key=value; `which`: the keys that may be changed.
void add_overrides(CLI::App& command, std::vector<std::string>& overrides, const std::string& which);
/// --with: overlays for `changes`.
void add_with(CLI::App& command, sim::scenario::Changes& changes);
/// --without: sections of the scenario to remove.
void add_without(CLI::App& command, sim::scenario::Changes& changes);
/// The argument `result`, the folder of a run.
void add_result(CLI::App& command, std::filesystem::path& result, const std::string& or_else = "");
void add_models(CLI::App& command, std::filesystem::path& models);
/// --seeds, several seeds with a process each.
void add_seeds(CLI::App& command, std::optional<std::string>& seeds);
/// --jobs, processes on this machine.
void add_jobs(CLI::App& command, int& jobs);
void add_jobs(CLI::App& command, std::optional<int>& jobs, const std::string& text);

/// Hidden options of a process for one seed of a batch.
struct BatchMember {
  std::optional<pid_t> parent;                  ///< it ends when that process ends
  std::optional<std::filesystem::path> set_by;  ///< file with the origin of each key
};
/// --all-metrics, for tables on the terminal.
void add_all_metrics(CLI::App& command, bool& all);
void add_parent(CLI::App& command, std::optional<pid_t>& parent);
void add_batch_member(CLI::App& command, BatchMember& member);

/// Seeds as typed after --seeds. Throws UsageError.
std::vector<std::uint64_t> parse_seeds(const std::string& text);

}  // namespace cli
