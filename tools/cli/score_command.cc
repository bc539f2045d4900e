#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>

#include "sim/result/score_input.h"
#include "sim/scenario/scenario.h"
#include "sim/trajectory_score/report.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {
namespace {

namespace result = sim::result;
namespace scenario = sim::scenario;
namespace score = sim::score;
namespace trajectory_score = sim::trajectory_score;
namespace fs = std::filesystem;

constexpr const char* kScoreExamples = R"(
Examples:
  gaitslam score results/tangent_circle/seed-1
  gaitslam score truth.tum estimate.txt --align se3
  gaitslam score truth.csv estimate.txt -as -r angle_deg
  gaitslam score truth.tum estimate.tum -d 1 -u m --all-pairs --csv
  gaitslam score results/tangent_circle/seed-1 -d 2 -u step      # over two footsteps
Reads TUM (8 columns, or 20 with covariance), KITTI (with times.txt) and EuRoC csv files and result folders, with time
stamps in seconds or nanoseconds. Terms and numbers are those of evo_ape and, with -d or -u, of evo_rpe. NEES is
computed without alignment, over the poses with a covariance. The score.json of a result starts at the first planned motion, this score at the first
pose.
Exit codes: 0 scored; 2 nothing can be compared (the reason is printed).)";

struct ScoreRequest {
  fs::path truth;
  std::optional<fs::path> estimate;
  std::optional<std::string> align;
  std::string relation = "trans_part", unit = "f";
  std::optional<double> delta;
  trajectory_score::Options options;
  double delta_tolerance = 0.1;
  bool a = false, s = false, unit_typed = false, tolerance_typed = false, all_pairs = false,
       pairs_from_reference = false;
  bool json = false, csv = false, latex = false;
};

std::optional<score::Alignment> alignment(const ScoreRequest& r) {
  if (r.align && (r.a || r.s)) throw UsageError("--align and -a or -s are both given, expected one of them");
  if (r.a) return r.s ? score::Alignment::sim3 : score::Alignment::se3;
  if (r.s) return score::Alignment::scale;
  if (!r.align) return std::nullopt;
  const auto named = score::alignment_of(*r.align);
  if (!named)
    throw UsageError(fmt::format("--align {}: expected none, origin, yaw, se3, sim3 or scale", *r.align));
  return named;
}

trajectory_score::Relation relation(const std::string& name) {
  using enum trajectory_score::Relation;
  static const std::map<std::string, trajectory_score::Relation> all{
      {"trans_part", trans_part}, {"angle_deg", angle_deg}, {"angle_rad", angle_rad},
      {"rot_part", rot_part},     {"full", full},           {"point_distance", point_distance}};
  const auto found = all.find(name);
  if (found == all.end())
    throw UsageError(fmt::format(
        "-r {}: expected trans_part, angle_deg, angle_rad, rot_part, full or point_distance", name));
  return found->second;
}

/// Planned landings of feet of the result that contains the trajectory.
std::vector<score::Stamp> footsteps(const fs::path& truth) {
  const fs::path scenario = (fs::is_directory(truth) ? truth : truth.parent_path()) / "scenario.yaml";
  if (!fs::exists(scenario))
    throw UsageError(
        fmt::format("-u step: needs a result folder with footsteps, and {} is not in one", truth.string()));
  return result::planned_times(scenario::read_scenario(scenario).scenario.walk).footsteps;
}

std::optional<score::Spans> spans(const ScoreRequest& r) {
  if (!r.delta && !r.unit_typed) {
    if (r.all_pairs || r.pairs_from_reference || r.tolerance_typed)
      throw UsageError(
          "--all-pairs, --pairs-from-reference and --delta-tol need -d or -u: they are about relative "
          "errors");
    return std::nullopt;
  }
  using Unit = score::Spans::Unit;
  static const std::map<std::string, Unit> units{{"f", Unit::frames},  {"m", Unit::meters},
                                                 {"s", Unit::seconds}, {"r", Unit::radians},
                                                 {"d", Unit::degrees}, {"step", Unit::footsteps}};
  const auto unit = units.find(r.unit);
  if (unit == units.end())
    throw UsageError(
        fmt::format("-u {}: expected f (frames), m, s, d (degrees), r (radians) or step", r.unit));
  const double delta = r.delta.value_or(1);
  const bool counted = unit->second == Unit::frames || unit->second == Unit::footsteps;
  if (!(delta > 0 && delta < 1e9) || (counted && delta != std::floor(delta)))
    throw UsageError(
        fmt::format("-d {}: expected a positive number below 1e9, whole for frames and footsteps", delta));
  return score::Spans{unit->second,
                      delta,
                      r.all_pairs,
                      r.delta_tolerance,
                      r.pairs_from_reference,
                      unit->second == Unit::footsteps ? footsteps(r.truth) : std::vector<score::Stamp>{}};
}

/// CLI::Range and CLI::NonNegativeNumber let NaN pass.
void require_not_negative(const char* option, double value, double most) {
  if (!(value >= 0 && value <= most))
    throw UsageError(fmt::format("{} {}: expected a number from 0 to {}", option, value, most));
}

void print(const ScoreRequest& request) {
  require_not_negative("--t-max-diff", request.options.pairing.most_apart_s, 1e9);
  require_not_negative("--delta-tol", request.delta_tolerance, 1e9);
  require_not_negative("--max-gap", request.options.pairing.most_gap_s.value_or(0), 1e9);
  trajectory_score::Options options = request.options;
  options.alignment = alignment(request);
  options.relation = relation(request.relation);
  options.relative = spans(request);
  if (!request.estimate && !fs::is_directory(request.truth))
    throw UsageError(fmt::format("{}: expected a second argument, the estimate, or a result folder",
                                 request.truth.string()));
  const auto report = trajectory_score::score_files(
      trajectory_score::trajectory_in(request.truth, true),
      trajectory_score::trajectory_in(request.estimate.value_or(request.truth), false), options);
  if (output() == Output::quiet) return;
  std::cout << (request.json    ? trajectory_score::json_text(report)
                : request.csv   ? trajectory_score::csv_text(report)
                : request.latex ? trajectory_score::latex_text(report)
                                : trajectory_score::table(report));
}

void add_options(CLI::App& command, ScoreRequest& r) {
  command.add_option("truth", r.truth, "the true trajectory, or a result folder")->required();
  command.add_option("estimate", r.estimate, "the estimated trajectory, or a result folder");
  command.add_option("--align", r.align,
                     "none, origin, yaw, se3, sim3 or scale; without this option all are shown");
  command.add_flag("-a", r.a, "the same as --align se3; -as means sim3");
  command.add_flag("-s", r.s, "the same as --align scale");
  command.add_option("--n-to-align,--n_to_align", r.options.poses_to_align,
                     "number of first poses to align by");
  command
      .add_option("-r,--pose-relation,--pose_relation", r.relation,
                  "trans_part, angle_deg, angle_rad, rot_part, full or point_distance")
      ->capture_default_str();
  command.add_option("-d,--delta", r.delta, "score the relative motion over spans of this length");
  command
      .add_option("-u,--delta-unit,--delta_unit", r.unit,
                  "unit of -d: f (frames), m, s, d (degrees), r (radians) or step (footsteps)")
      ->capture_default_str();
  command.add_flag("--all-pairs,--all_pairs", r.all_pairs,
                   "start a span at each pose instead of at the end of the previous one");
  command
      .add_option("--delta-tol,--delta_tol", r.delta_tolerance,
                  "tolerated deviation of a span, as a fraction of -d")
      ->capture_default_str();
  command.add_flag("--pairs-from-reference,--pairs_from_reference", r.pairs_from_reference,
                   "measure spans of -u m along the true path");
  command
      .add_option("--t-max-diff,--t_max_diff", r.options.pairing.most_apart_s,
                  "largest time between the stamps of a pair, in s")
      ->capture_default_str();
  command.add_option("--t-offset,--t_offset", r.options.pairing.offset_s,
                     "time added to the stamps of the estimate, in s");
  command.add_flag("--interpolate", r.options.pairing.interpolate,
                   "interpolate the true trajectory at the stamps of the estimate");
  command
      .add_option("--max-gap,--max_gap", r.options.pairing.most_gap_s,
                  "longest time between two true poses that --interpolate crosses, in s; unless given three "
                  "times the median, at least 0.1")
      ->needs("--interpolate");
}

}  // namespace

void add_score(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<ScoreRequest>();
  CLI::App* command = app.add_subcommand("score", "Score an estimated trajectory against a true one");
  add_options(*command, *request);
  CLI::Option* json =
      command->add_flag("--json", request->json, "print JSON (schemas/trajectory.schema.json)");
  CLI::Option* csv = command->add_flag("--csv", request->csv, "print CSV")->excludes(json);
  command->add_flag("--latex", request->latex, "print a LaTeX table")->excludes(json)->excludes(csv);
  add_quiet(*command);
  command->footer(kScoreExamples);
  command->callback([request, command, &exit_code] {
    request->unit_typed = command->count("-u") > 0;
    request->tolerance_typed = command->count("--delta-tol") > 0;
    print(*request);
    exit_code = 0;
  });
}

}  // namespace cli
