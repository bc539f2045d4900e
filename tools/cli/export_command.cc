#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_yaml.h"
#include "sim/stream/export.h"
#include "tools/cli/commands.h"
#include "tools/cli/out_folder.h"

namespace cli {
namespace {

namespace bench = sim::bench;
namespace fs = std::filesystem;
namespace stream = sim::stream;

constexpr const char* kExamples = R"(
Examples:
  gaitslam export results/tangent_circle/seed-1 --format euroc --out DIR
  gaitslam export results/tangent_circle/seed-1 --format mcap
  gaitslam export results/tangent_circle/seed-1 --format kalibr --undistort
What is exported is what the filter saw, sensor noise included. The folder (RESULT/export/FORMAT unless --out
names one) has a README.md with the command line of the program that it is for.)";

struct Request {
  fs::path result;
  std::string format;
  std::optional<std::string> out;
  bool undistort = false, force = false;
};

stream::ExportFormat format_of(const std::string& name) {
  const auto& names = stream::kExportFormats;
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw UsageError(fmt::format("--format: expected one of {}, not '{}'{}", fmt::join(names, ", "), name,
                                 bench::did_you_mean(name, {names.begin(), names.end()})));
  return static_cast<stream::ExportFormat>(found - names.begin());
}

int export_result(const Request& request) {
  const stream::ExportFormat format = format_of(request.format);
  if (!fs::is_directory(request.result))
    throw UsageError(fmt::format("{}: no such result folder", request.result.string()));
  if (!fs::is_directory(request.result / "recording"))
    throw UsageError(
        fmt::format("{}: has no recording/: expected the folder of a run", request.result.string()));
  const bench::Scenario scenario = bench::read_scenario(request.result / "scenario.yaml").scenario;
  const fs::path folder = request.out ? fs::path(*request.out) : request.result / "export" / request.format;
  check_out_folder(folder, request.out.has_value(), request.force);
  const NewFolders made_for_this(folder);
  stream::export_run({request.result, scenario.name, scenario.seed, scenario.errors, request.undistort},
                     format, folder, stream::Existing::replace);
  std::cout << fmt::format("{0}/README.md says how {0} is used\n", folder.string());
  return 0;
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  CLI::App* command =
      app.add_subcommand("export", "Write a run in the format of another SLAM program or viewer");
  command->add_option("result", request->result, "a result folder, as results/tangent_circle/seed-1")
      ->required();
  command
      ->add_option("--format", request->format,
                   fmt::format("one of {}", fmt::join(stream::kExportFormats, ", ")))
      ->required();
  command->add_option("--out", request->out, "folder to write");
  command->add_flag("--undistort", request->undistort,
                    "images as a pinhole would have seen them; tum and kitti always are");
  command->add_flag("--force", request->force, "replace a folder that exists");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = export_result(*request); });
}

}  // namespace cli
