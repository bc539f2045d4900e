#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/export/export.h"
#include "sim/files/atomic_file.h"
#include "sim/recording/asl_folder.h"
#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"
#include "sim/view/session.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {
namespace {

namespace exports = sim::exports;
namespace files = sim::files;
namespace scenario = sim::scenario;

constexpr const char* kExportExamples = R"(
Examples:
  gaitslam export results/tangent_circle/seed-1 --format euroc --out DIR
  gaitslam export results/tangent_circle/seed-1 --format mcap
  gaitslam export results/tangent_circle/seed-1 --format orbslam3 --undistort
The export contains the input of the filter, sensor errors included. Its folder, RESULT/export/FORMAT by default, has
a README.md with the command line of the target program. Folders that other programs recorded are not accepted.)";

struct ExportRequest : OutRequest {
  fs::path result;
  std::string format;
  bool undistort = false;
  fs::path models = standard_models();
};

void check_format(const std::string& name) {
  const std::vector<std::string>& names = exports::export_formats();
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw UsageError(
        fmt::format("--format: expected one of {}, not '{}'{}", fmt::join(names, ", "), name,
                    scenario::did_you_mean(name, std::vector<std::string_view>(names.begin(), names.end()))));
}

int export_result(const ExportRequest& request) {
  check_format(request.format);
  if (!fs::is_directory(request.result))
    throw UsageError(fmt::format("{}: no such result folder", request.result.string()));
  if (sim::recording::is_asl_folder(request.result))
    throw UsageError(
        fmt::format("{}: was recorded by another program: expected the folder of a run of gaitslam",
                    request.result.string()));
  if (!fs::is_directory(request.result / "recording"))
    throw UsageError(
        fmt::format("{}: has no recording/: expected the folder of a run", request.result.string()));
  const scenario::Scenario scenario = scenario::read_scenario(request.result / "scenario.yaml").scenario;
  const OutFolder out(request, request.result / "export" / request.format, {.replaces = true});
  require_outside(out.path(), request.result);
  if (!request.out) files::add_to_marker(request.result, {"export/", "export/" + request.format + "/"});
  ProgressLine progress(fmt::format("export of {}", request.result.string()));
  exports::export_run(
      {request.result, scenario.name, scenario.seed, scenario.errors, true, request.undistort,
       request.format == "mcap" ? sim::view::robot_description(scenario, request.models) : nullptr,
       [&](double part) { progress.show(part); }},
      request.format, out.path(), files::Existing::replace);
  std::cout << fmt::format("exported to {0}; see {0}/README.md for its use\n", out.path().string());
  return 0;
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<ExportRequest>();
  CLI::App* command =
      app.add_subcommand("export", "Write a run in the format of another SLAM program or viewer");
  add_result(*command, request->result);
  command
      ->add_option("--format", request->format,
                   fmt::format("one of {}", fmt::join(exports::export_formats(), ", ")))
      ->required();
  add_out(*command, *request);
  command->add_flag("--undistort", request->undistort,
                    "rectify images to a pinhole camera, as tum always does");
  add_models(*command, request->models);
  command->footer(kExportExamples);
  command->callback([request, &exit_code] { exit_code = export_result(*request); });
}

}  // namespace cli
