#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <iostream>
#include <new>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "sim/files/text.h"
#include "sim/scenario/yaml.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/interruption.h"
#include "tools/cli/shared/usage_error.h"
#include "tools/cli/shared/version.h"

namespace {

constexpr const char* kDescription =
    "GaitSLAM simulates a humanoid robot that walks by preview control, estimates the motion of its head "
    "camera "
    "with a SLAM filter, and scores the walk and the estimate against ground truth.";

constexpr const char* kProgramExamples = R"(
Examples:
  gaitslam run scenarios/tangent_circle.yaml
  gaitslam replay results/tangent_circle/seed-1 slam.vision.sigma_px=1.5
  gaitslam export results/tangent_circle/seed-1 --format mcap
  gaitslam report results/tangent_circle/seed-1 --out report.html
  gaitslam check scenarios/*.yaml
  gaitslam config scenarios/tangent_circle.yaml
  gaitslam COMMAND --help
Exit codes: 0 passed; 1 ran and missed a limit; 2 wrong usage or configuration; 3 the run failed.)";

int fail_with(const std::string& message, int exit_code) {
  std::cerr << sim::files::sanitize(message) << '\n';
  return exit_code;
}

/// Throws UsageError if the first word is not a command; the message suggests the nearest one.
void check_command_name(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == argv[1]) return;
    if (!command->get_group().empty()) names.push_back(command->get_name());  // the others are not for users
  }
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  throw cli::UsageError(fmt::format("unknown command '{}', expected one of {}{}", argv[1],
                                    fmt::join(names, ", "),
                                    sim::scenario::did_you_mean(argv[1], candidates)));
}

/// "; did you mean '--seeds'?" for the first unknown option on the command line.
std::string suggested_option(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands())
    for (const CLI::Option* option : command->get_options())
      if (!option->get_group().empty())  // the others are not for users
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  for (const std::string& typed : app.remaining(true)) {
    if (!typed.starts_with('-')) continue;
    const std::string hint = sim::scenario::did_you_mean(typed.substr(0, typed.find('=')), candidates);
    if (!hint.empty()) return hint;
  }
  return "";
}

/// Returns the indent of the rest of a wrapped line of help: below its description, or indented as the line.
std::size_t indent_of(const std::string& line) {
  const std::size_t words = line.find_first_not_of(' ');
  if (words == line.npos || words == 0 || words > 20) return words == line.npos ? 0 : words;
  const std::size_t described = line.find_first_not_of(' ', std::min(line.find("  ", words), line.size()));
  return described < 50 ? described : words + 2;
}

/// The help with its lines wrapped at 100 columns. The rest of a line of a paragraph joins the next one.
std::string wrapped(const std::string& help) {
  constexpr std::size_t kColumns = 100;
  std::string text, rest;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    const bool begins = line.starts_with("Usage:") || line.starts_with("Exit codes:") || line.ends_with(':');
    const bool joins = !line.empty() && line[0] != ' ' && !begins;
    if (joins && !rest.empty()) line = rest + " " + line;
    if (!joins && !rest.empty()) text += rest + '\n';
    const std::size_t indent = indent_of(line);
    bool is_cut = false;
    while (line.size() > kColumns) {
      const std::size_t end = line.rfind(' ', kColumns);
      if (end == line.npos || end <= indent) break;
      text += line.substr(0, end) + '\n';
      line = std::string(indent, ' ') + line.substr(end + 1);
      is_cut = true;
    }
    rest = is_cut && indent == 0 ? line : "";
    if (rest.empty()) text += line + '\n';
  }
  return rest.empty() ? text : text + rest + '\n';
}

int run_program(int argc, char** argv) {
  cli::remember_command(argc, argv);
  CLI::App app(kDescription, "gaitslam");
  int exit_code = 0;
  app.set_version_flag("--version", cli::version_text());
  app.require_subcommand(1);
  app.footer(kProgramExamples);
  cli::add_commands(app, exit_code);
  check_command_name(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::cout << wrapped(app.help());
    return 0;
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& e) {
    return fail_with(fmt::format("gaitslam: {}{} (gaitslam --help)", e.what(), suggested_option(app)), 2);
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10,
                          8 << 20);  // blocking, and with it rounding, the same on every machine
  cv::setNumThreads(1);              // --jobs sets the number of cores
  try {
    const int exit_code = run_program(argc, argv);
    std::cout.flush();
    return std::cout ? exit_code
                     : fail_with("gaitslam: cannot write to standard output", std::max(exit_code, 2));
  } catch (const sim::scenario::ConfigError& e) {
    return fail_with(e.what(), 2);
  } catch (const std::bad_alloc&) {
    return fail_with("gaitslam: out of memory", 3);
  } catch (const std::invalid_argument& e) {
    return fail_with(fmt::format("gaitslam: {}", e.what()), 2);
  } catch (const std::runtime_error& e) {
    return fail_with(fmt::format("gaitslam: {}", e.what()), 2);
  } catch (const std::exception& e) {
    return fail_with(fmt::format("gaitslam: internal error: {}", e.what()), 3);
  }
}
