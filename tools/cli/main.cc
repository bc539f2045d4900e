#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <iostream>
#include <new>

#include "sim/bench/scenario_yaml.h"
#include "tools/cli/commands.h"
#include "tools/cli/trial_commands.h"
#include "tools/cli/version.h"

namespace {

constexpr const char* kDescription =
    "GaitSLAM: a simulated humanoid walks by preview control, a filter tracks its head camera, and truth "
    "scores both.";

constexpr const char* kExamples = R"(
Examples:
  gaitslam run scenarios/tangent_circle.yaml
  gaitslam replay results/tangent_circle/seed-1 slam.vision.sigma_px=1.5
  gaitslam export results/tangent_circle/seed-1 --format mcap
  gaitslam report results/tangent_circle/seed-1 --out report.html
  gaitslam check scenarios/*.yaml
  gaitslam config scenarios/tangent_circle.yaml
  gaitslam COMMAND --help
Exit code: 0 passed, 1 ran and missed a limit, 2 usage or configuration, 3 the run failed.)";

int complain(const std::string& message, int exit_code) {
  std::cerr << message << '\n';
  return exit_code;
}

/// Throws UsageError for a first word that is no command, with the nearest one.
void check_command_name(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == argv[1]) return;
    if (!command->get_group().empty()) names.push_back(command->get_name());  // the others are not for users
  }
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  throw cli::UsageError(fmt::format("unknown command '{}', expected one of {}{}", argv[1],
                                    fmt::join(names, ", "), sim::bench::did_you_mean(argv[1], candidates)));
}

int run_program(int argc, char** argv) {
  CLI::App app(kDescription, "gaitslam");
  int exit_code = 0;
  app.set_version_flag("--version", cli::version_text());
  app.require_subcommand(1);
  app.footer(kExamples);
  cli::add_run(app, exit_code);
  cli::add_record(app, exit_code);
  cli::add_replay(app, exit_code);
  cli::add_export(app, exit_code);
  cli::add_video(app, exit_code);
  cli::add_score(app, exit_code);
  cli::add_regress(app, exit_code);
  cli::add_compare(app, exit_code);
  cli::add_baseline(app, exit_code);
  cli::add_sweep(app, exit_code);
  cli::add_trials(app, exit_code);
  cli::add_tune(app, exit_code);
  cli::add_check(app, exit_code);
  cli::add_report(app, exit_code);
  cli::add_reproduce(app, exit_code);
  cli::add_cache(app, exit_code);
  cli::add_config(app, exit_code);
  check_command_name(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& e) {
    return complain(fmt::format("gaitslam: {} (gaitslam --help)", e.what()), 2);
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10,
                          8 << 20);  // blocking, and with it rounding, the same on every machine
  try {
    const int exit_code = run_program(argc, argv);
    std::cout.flush();
    return std::cout ? exit_code
                     : complain("gaitslam: cannot write to standard output", std::max(exit_code, 2));
  } catch (const sim::bench::ConfigError& e) {
    return complain(e.what(), 2);
  } catch (const std::bad_alloc&) {
    return complain("gaitslam: out of memory", 3);
  } catch (const std::invalid_argument& e) {
    return complain(fmt::format("gaitslam: {}", e.what()), 2);
  } catch (const std::runtime_error& e) {
    return complain(fmt::format("gaitslam: {}", e.what()), 2);
  } catch (const std::exception& e) {
    return complain(fmt::format("gaitslam: internal error: {}", e.what()), 3);
  }
}
