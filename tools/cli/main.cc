#include <fmt/ranges.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>
#include <new>
#include <opencv2/core/utility.hpp>
#include <system_error>

#include "tools/cli/commands.h"
#include "tools/cli/shared/version.h"

namespace {

using sim::scenario::did_you_mean;

constexpr const char* kDescription =
    "GaitSLAM simulates a humanoid robot that walks by preview control, estimates the motion of its head\n"
    "camera with a SLAM filter, and scores the walk and the estimate against ground truth.";

constexpr const char* kProgramExamples = R"(
Examples:
  gaitslam run scenarios/tangent_circle.yaml
  gaitslam replay results/tangent_circle/seed-1 slam.vision.sigma_px=1.5
  gaitslam report results/tangent_circle/seed-1 --out report.html
  gaitslam check scenarios/*.yaml
  gaitslam help run
Exit codes: 0 passed; 1 missed a limit; 2 wrong usage or configuration; 3 the run failed; 74 the disk is full or
a device failed.)";

/// Wraps help at 100 columns: prose is refilled, options keep their column, commands continue after a "\\".
struct Formatter : CLI::Formatter {
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    constexpr std::size_t kWidth = 100, kColumn = 30;
    std::string text, rest;  // rest: the part of a prose line that is not yet printed
    for (std::string line : sim::files::lines_of(CLI::Formatter::make_help(app, name, mode))) {
      const bool prose = !line.empty() && line[0] != ' ', command = line.starts_with("  gaitslam ");
      if (!rest.empty()) {
        if (prose && !line.starts_with("Exit codes") && !line.starts_with("Usage:"))
          line = rest + ' ' + line;
        else
          text += rest + '\n';
      }
      const bool is_long = line.size() > kWidth;
      const std::string indent(prose ? 0 : command ? 6 : kColumn, ' ');
      while (line.size() > kWidth) {
        const std::size_t end = line.rfind(' ', kWidth - (command ? 2 : 0));
        if (end == line.npos || end <= indent.size()) break;
        text += line.substr(0, end) + (command ? " \\\n" : "\n");
        line = indent + line.substr(end + 1);
      }
      rest = is_long && prose ? line : "";
      if (rest.empty()) text += line + '\n';
    }
    return text + (rest.empty() ? "" : rest + '\n');
  }
};

int fail_with(const std::string& message, int exit_code) {
  std::cerr << sim::files::sanitize(message) << '\n';
  return exit_code;
}

/// Throws UsageError if the first word is not a command; the message suggests the most similar one.
void check_command_name(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == argv[1]) return;
    if (!command->get_group().empty()) names.push_back(command->get_name());  // the others are not for users
  }
  throw cli::UsageError("unknown command '{}', expected one of {}{}", argv[1], fmt::join(names, ", "),
                        did_you_mean(argv[1], names));
}

/// Returns "; did you mean '--seeds'?" for the first unknown option on the command line, or "".
std::string suggested_option(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands())
    for (const CLI::Option* option : command->get_options())
      if (!option->get_group().empty())  // the others are not for users
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const std::string& typed : app.remaining(true))
    if (typed.starts_with('-'))
      if (const std::string hint = did_you_mean(typed.substr(0, typed.find('=')), names); !hint.empty())
        return hint;
  return "";
}

int run_program(int argc, char** argv) {
  cli::remember_command(argc, argv);
  CLI::App app(kDescription, "gaitslam");
  int exit_code = 0;
  app.formatter(std::make_shared<Formatter>());
  app.set_version_flag("--version", cli::version_text());
  app.require_subcommand(1);
  app.footer(kProgramExamples);
  for (cli::AddCommand* const add : cli::commands()) add(app, exit_code);
  check_command_name(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& e) {
    const auto typed = app.get_subcommands();
    const std::string page = typed.empty() ? "" : " " + typed[0]->get_name();
    return fail_with(fmt::format("gaitslam: {}{} (gaitslam help{})", e.what(), suggested_option(app), page),
                     2);
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  // Fixed cache sizes make Eigen's blocking, and thus rounding, the same on every machine.
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 8 << 20);
  cv::setNumThreads(1);           // --jobs sets the number of cores
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is then an error, as on a full disk
  // Reuses memory of pictures, because mapping it again takes a fifth of a short run.
  mallopt(M_MMAP_THRESHOLD, 64 << 20);
  try {
    const int exit_code = run_program(argc, argv);
    std::cout.flush();
    return std::cout ? exit_code : fail_with("gaitslam: cannot write to standard output", cli::kDeviceFailed);
  } catch (const sim::scenario::ConfigError& e) {
    return fail_with(e.what(), 2);
  } catch (const std::bad_alloc&) {
    return fail_with("gaitslam: out of memory", 3);
  } catch (const std::exception& e) {
    const auto* const of_system = dynamic_cast<const std::system_error*>(&e);
    if (dynamic_cast<const sim::files::DeviceError*>(&e) ||
        (of_system && sim::files::is_of_device(of_system->code().value())))
      return fail_with(fmt::format("gaitslam: {}", e.what()), cli::kDeviceFailed);
    const bool of_input = dynamic_cast<const std::invalid_argument*>(&e) != nullptr ||
                          dynamic_cast<const std::runtime_error*>(&e) != nullptr;
    return fail_with(fmt::format("gaitslam: {}{}", of_input ? "" : "internal error: ", e.what()),
                     of_input ? 2 : 3);
  }
}
