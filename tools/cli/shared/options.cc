#include "tools/cli/shared/options.h"

#include <fmt/format.h>

#include "sim/scenario/yaml_map.h"

namespace cli {

CLI::Option* add_scenario(CLI::App& command, std::string& file, sim::scenario::Changes& changes) {
  CLI::Option* const scenario = command.add_option("scenario", file, "the scenario's YAML file");
  add_overrides(command, changes.overrides, "(gaitslam config --keys lists the keys)");
  add_with(command, changes);
  add_without(command, changes);
  return scenario;
}

void add_overrides(CLI::App& command, std::vector<std::string>& overrides, const std::string& which) {
  command.add_option("changes", overrides, "keys of the scenario and their new values " + which)
      ->option_text("key=value ...");
}

void add_with(CLI::App& command, sim::scenario::Changes& changes) {
  command
      .add_option("--with", changes.with,
                  "YAML file with keys to replace in the scenario, such as the best.yaml of a tuning; "
                  "later files win")
      ->option_text("FILE")
      ->allow_extra_args(false);
}

void add_without(CLI::App& command, sim::scenario::Changes& changes) {
  command.add_option("--without", changes.without, "sections to leave out, as in camera,slam")
      ->delimiter(',')
      ->allow_extra_args(false);
}

void add_result(CLI::App& command, std::filesystem::path& result, const std::string& or_else) {
  command.add_option("result", result, "a result folder, such as results/tangent_circle/seed-1" + or_else)
      ->required();
}

void add_models(CLI::App& command, std::filesystem::path& models) {
  command.add_option("--models", models, "folder of the models of the robot and the rooms");
}

void add_seeds(CLI::App& command, std::optional<std::string>& seeds) {
  command.add_option("--seeds", seeds, "run several seeds, each in its own process: 1..5 or 1,2,7");
}

void add_jobs(CLI::App& command, int& jobs) {
  command.add_option("--jobs", jobs, "number of processes at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

void add_jobs(CLI::App& command, std::optional<int>& jobs, const std::string& text) {
  command.add_option("--jobs", jobs, text)->check(CLI::Range(1, 1024));
}

void add_all_metrics(CLI::App& command, bool& all) {
  command.add_flag("--all-metrics", all,
                   "show all metrics, not only the most important ones and those with limits");
}

void add_parent(CLI::App& command, std::optional<pid_t>& parent) {
  command.add_option("--die-with-parent", parent)->group("");
}

void add_batch_member(CLI::App& command, BatchMember& member) {
  command.add_option("--set-by", member.set_by)->group("");
  add_parent(command, member.parent);
}

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  try {
    return sim::scenario::parse_seeds(text);
  } catch (const std::invalid_argument& e) {
    throw UsageError(fmt::format("--seeds {}: {}", text, e.what()));
  }
}

}  // namespace cli
