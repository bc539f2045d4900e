#include <iostream>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/trajectory_score/report.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr const char* kScoreExamples = R"(Examples:
  gaitslam score results/tangent_circle/seed-1
  gaitslam score truth.tum estimate.txt --align se3
  gaitslam score truth.tum estimate.tum -d 1 -u m --all-pairs --json
Reads result folders, TUM (8 columns between spaces, or 20 with covariance), KITTI (12, with times.txt), and tables with a
header of known names, as in EuRoC's files. --columns replaces the header: names in order, - for a column that is not used.
Names: t, time, timestamp or stamp, with [s], [ms], [us] or [ns], or sec nanosec; x y z, also as tx, px, p_x, p_RS_R_x or
position.x, in m unless [cm], [mm] or [km] follows; qw qx qy qz, also as q_w, q_RS_w or orientation.w; and the covariance
Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 ... Pt33, about the body's axes. -y mirrors an axis. Nothing is inferred from values.
A warning names the option that would cut the error at least fivefold, if one does. Terms and numbers are those of evo_ape
and, with -d or -u, of evo_rpe. NEES is computed without alignment, over the poses with a covariance. The score.json of a
result starts at the first planned motion, while this score starts at the first pose.
Exit codes: 0 scored; 2 nothing can be compared (the reason is printed).)";

constexpr const char* kRelations = "trans_part, angle_deg, angle_rad, rot_part, full or point_distance";
constexpr const char* kUnits = "f (frames), m, s, d (degrees) or r (radians)";

struct ScoreRequest {
  fs::path truth;
  std::optional<fs::path> estimate;
  std::optional<std::string> align, unit;
  std::string relation = "trans_part";
  std::optional<double> delta, delta_tolerance;
  std::vector<double> turn_deg;
  trajectory_score::Options options;
  bool a = false, s = false, all_pairs = false, pairs_from_reference = false, json = false;
};

/// Returns the enumerator for a name; names: in the order of the enumeration. Throws UsageError "option
/// name: expected ..." for any other name.
template <typename T>
T named(const char* option, const std::string& name, std::initializer_list<std::string_view> names,
        const char* expected) {
  const auto* const found = std::ranges::find(names, name);
  if (found == names.end()) throw UsageError("{} {}: expected {}", option, name, expected);
  return static_cast<T>(found - names.begin());
}

std::optional<score::Alignment> alignment(const ScoreRequest& r) {
  if (r.align && (r.a || r.s)) throw UsageError("--align: -a or -s is also given, expected one of them");
  if (r.a) return r.s ? score::Alignment::sim3 : score::Alignment::se3;
  if (r.s) return score::Alignment::scale;
  return r.align ? std::optional(alignment_named(*r.align)) : std::nullopt;
}

/// CLI::Range and CLI::NonNegativeNumber let NaN pass.
void require_not_negative(const char* option, double value) {
  if (!(value >= 0 && value <= 1e9))
    throw UsageError("{} {}: expected a number from 0 to 1e9", option, value);
}

std::optional<score::Spans> spans(const ScoreRequest& r) {
  if (!r.delta && !r.unit) {
    if (r.all_pairs || r.pairs_from_reference || r.delta_tolerance)
      throw UsageError(
          "--all-pairs, --pairs-from-reference and --delta-tol apply only to relative errors, expected -d or "
          "-u");
    return std::nullopt;
  }
  using Unit = score::Spans::Unit;
  const Unit unit = named<Unit>("-u", r.unit.value_or("f"), {"f", "m", "s", "r", "d"}, kUnits);
  const double delta = r.delta.value_or(1), tolerance = r.delta_tolerance.value_or(0.1);
  if (!(delta > 0 && delta < 1e9) || (unit == Unit::frames && delta != std::floor(delta)))
    throw UsageError("-d {}: expected a positive number below 1e9, whole for frames", delta);
  require_not_negative("--delta-tol", tolerance);
  return score::Spans{unit, delta, r.all_pairs, tolerance, r.pairs_from_reference};
}

int print(ScoreRequest& request) {
  trajectory_score::Options& options = request.options;
  require_not_negative("--t-max-diff", options.pairing.most_apart_s);
  require_not_negative("--max-gap", options.pairing.most_gap_s.value_or(0));
  options.alignment = alignment(request);
  options.relation = named<trajectory_score::Relation>(
      "-r", request.relation, {"trans_part", "angle_deg", "angle_rad", "rot_part", "full", "point_distance"},
      kRelations);
  options.relative = spans(request);
  for (std::size_t i = 0; i < request.turn_deg.size(); ++i)
    options.body_turn[int(i)] = request.turn_deg[i] * score::kDegree;
  if (!request.estimate && !fs::is_directory(request.truth))
    throw UsageError("{}: is one trajectory, expected an estimate as second argument, or a result folder",
                     request.truth.string());
  const auto report = trajectory_score::score_files(
      trajectory_score::trajectory_in(request.truth, true),
      trajectory_score::trajectory_in(request.estimate.value_or(request.truth), false), options);
  if (output() != Output::quiet)
    std::cout << (request.json ? files::json_text(report, 2) + "\n" : trajectory_score::table(report));
  return 0;
}

}  // namespace

void add_score(CLI::App& app, int& exit_code) {
  auto [command, r] = add_command(app, exit_code, "score", "Score an estimated trajectory against a true one",
                                  kScoreExamples, print);
  command.add_option("truth", r.truth, "the true trajectory, or a result folder")->required();
  command.add_option("estimate", r.estimate, "the estimated trajectory, or a result folder");
  command.add_option("--align", r.align, "none, origin, yaw, se3, sim3 or scale (default: all of them)");
  command.add_flag("-a", r.a, "the same as --align se3; -as means sim3");
  command.add_flag("-s", r.s, "the same as --align scale");
  command.add_option("--n-to-align,--n_to_align", r.options.poses_to_align, "align by this many first poses")
      ->check(CLI::Range(1, 1'000'000'000));
  command.add_option("-r,--pose-relation,--pose_relation", r.relation, kRelations)->capture_default_str();
  command.add_option("-d,--delta", r.delta, "score the relative motion over spans of this length");
  command.add_option("-u,--delta-unit,--delta_unit", r.unit, std::string("unit of -d: ") + kUnits);
  command.add_flag("--all-pairs,--all_pairs", r.all_pairs, "start a span at every pose");
  command.add_option("--delta-tol,--delta_tol", r.delta_tolerance,
                     "tolerated deviation of a span, as a fraction of -d (default 0.1)");
  command.add_flag("--pairs-from-reference,--pairs_from_reference", r.pairs_from_reference,
                   "measure spans of -u m along the true path");
  command.add_option("--columns", r.options.columns,
                     "names of the estimate's columns in order, such as \"t[ns] x y z qw qx qy qz\"");
  command.add_option("--truth-columns", r.options.truth_columns, "the same for the truth");
  command
      .add_option(
          "--turn-body", r.turn_deg,
          "rotation from the truth's to the estimate's body, to be removed: rotation vector X,Y,Z in deg")
      ->delimiter(',')
      ->expected(3);
  auto& pairing = r.options.pairing;
  command.add_option("--t-max-diff,--t_max_diff", pairing.most_apart_s, "longest time within a pair, in s")
      ->capture_default_str();
  command.add_option("--t-offset,--t_offset", pairing.offset_s, "time added to the estimate's stamps, in s");
  command.add_flag("--interpolate", pairing.interpolate, "interpolate the truth at the estimate's stamps");
  command
      .add_option("--max-gap,--max_gap", pairing.most_gap_s,
                  "longest gap that --interpolate bridges, in s (default 3 x the median, at least 0.1)")
      ->needs("--interpolate");
  command.add_flag("--json", r.json, "print JSON (schemas/trajectory.schema.json)");
  add_quiet(command);
}

}  // namespace cli
