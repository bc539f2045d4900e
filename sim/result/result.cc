#include "sim/result/result.h"

#include <fmt/core.h>

#include <algorithm>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/files/trajectory_file.h"
#include "sim/result/json.h"
#include "sim/result/limits.h"
#include "sim/result/score_input.h"
#include "sim/score/metrics.h"

namespace sim::result {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

std::string tum(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(pose.t, pose.X);
  return text;
}

// A pose without covariance has eight columns in both files.
void write_estimate(const fs::path& folder, const tracking::Tracked& tracked) {
  std::string poses, with_covariance = files::kTumCovarianceHeader;
  for (const estimators::PoseEstimate& e : tracked.estimates()) {
    poses += files::tum_row(e.t, e.X_WC);
    with_covariance +=
        e.covariance ? files::tum_row(e.t, e.X_WC, *e.covariance) : files::tum_row(e.t, e.X_WC);
  }
  if (!tracked.log.empty()) files::write_text(folder / "estimator.log", tracked.log);
  files::write_text(folder / "estimate.tum", poses);
  files::write_text(folder / "estimate_cov.txt", with_covariance);
}

void write_trajectories(const fs::path& folder, const RunRecord& record) {
  files::write_text(folder / "truth.tum", tum(record.truth.camera));
  files::write_text(folder / "plan.tum", tum(planned_camera(record)));
  files::write_text(folder / "waist_truth.tum", tum(record.truth.waist));
  files::write_text(folder / "waist_plan.tum", tum(record.truth.waist_plan));
  if (record.tracked) write_estimate(folder, *record.tracked);
}

/// A steered walk's desired path, and the corrections of its steps.
void write_steering(const fs::path& folder, const RunRecord& record, const score::DesiredPath& desired) {
  files::write_text(folder / "waist_desired.tum", tum(desired.waist));
  std::string steps =
      "#time [ns],foot,desired_x [m],desired_y [m],desired_yaw [rad],expected_x [m],expected_y [m],"
      "expected_yaw [rad],ahead [m],aside [m],turn [rad]\n";
  for (const score::StepCorrection& step : record.truth.corrected_steps)
    steps += fmt::format("{},{},{},{},{}\n", step.t.count(), step.left ? "left" : "right",
                         files::csv_fields(step.desired), files::csv_fields(step.expected),
                         files::csv_fields(Eigen::Vector3d(step.ahead, step.aside, step.turn)));
  files::write_text(folder / "corrected_steps.csv", steps);
}

std::string pose_fields(const score::Pose2& p) { return fmt::format(",{},{},{}", p.x, p.y, p.yaw); }

void write_feet(const fs::path& file, const std::vector<score::FootRow>& rows) {
  std::string text =
      "#begin [ns],end [ns],foot,phase,moved_x [m],moved_y [m],moved_yaw [rad],creep_x [m],creep_y "
      "[m],creep_yaw [rad],drift_x [m],drift_y [m],drift_yaw [rad]\n";
  for (const score::FootRow& row : rows) {
    text += fmt::format("{},{},{},{}{}{}{}\n", row.begin.count(), row.end.count(),
                        row.foot == score::Foot::left ? "left" : "right",
                        score::kFootPhases[static_cast<std::size_t>(row.phase)], pose_fields(row.moved),
                        pose_fields(row.creep), pose_fields(row.drift));
  }
  files::write_text(file, text);
}

// The metrics of a run that failed: none has a value.
score::Metrics unscored(const std::string& cause) {
  const std::string reason = "not scored: " + (cause.empty() ? "the run failed" : cause);
  score::Metrics metrics;
  for (const score::MetricDefinition& defined : score::metric_definitions())
    metrics[defined.name] = {std::nullopt, defined.unit, reason};
  return metrics;
}

ordered_json metrics_json(const score::Metrics& metrics) {
  ordered_json json;
  for (const score::MetricDefinition& defined : score::metric_definitions()) {
    const score::Metric& metric = metrics.find(defined.name)->second;
    ordered_json& entry = json[defined.name];
    entry["value"] = or_null(metric.value);
    entry["unit"] = metric.unit;
    if (!metric.value) entry["reason"] = metric.reason;
    if (!metric.note.empty()) entry["note"] = metric.note;
  }
  return json;
}

ordered_json faults_json(const std::vector<tracking::TrackingFault>& faults) {
  ordered_json json = ordered_json::array();
  for (const tracking::TrackingFault& fault : faults)
    json.push_back({{"from_s", slam::seconds(fault.from)},
                    {"to_s", fault.to ? ordered_json(slam::seconds(*fault.to)) : ordered_json(nullptr)},
                    {"cause", fault.cause}});
  return json;
}

// The times and causes of lost tracking and of suspect sensors, and the number of observations that were
// rejected, wholly or in part.
ordered_json tracking_json(const tracking::Tracked& tracked) {
  const auto refused =
      std::count_if(tracked.frames.begin(), tracked.frames.end(),
                    [](const tracking::TrackedFrame& frame) { return !frame.report.refused.empty(); });
  return {{"observations_refused", refused},
          {"lost", faults_json(tracked.losses())},
          {"suspect", faults_json(tracked.suspicions())}};
}

ordered_json limits_json(const std::vector<JudgedLimit>& limits) {
  ordered_json json = ordered_json::array();
  for (const JudgedLimit& judged : limits) {
    json.push_back(to_json(judged));
    if (!judged.passed) json.back()["reason"] = "no filter was to run";
  }
  return json;
}

void write_score(const fs::path& file, const scenario::Scenario& scenario, scenario::Ending ending,
                 const score::Metrics& metrics, const tracking::Tracked* tracked,
                 const std::vector<JudgedLimit>& limits) {
  ordered_json json{{"format_version", 1},
                    {"scenario", scenario.name},
                    {"estimator", scenario.estimator.name},
                    {"seed", scenario.seed},
                    {"ending", scenario::name_of(ending)}};
  json["metrics"] = metrics_json(metrics);
  if (tracked) json["tracking"] = tracking_json(*tracked);
  json["limits"] = limits_json(limits);
  write_json(file, json);
}

void write_about(const fs::path& file, const RunRecord& record, const ResultPlace& place,
                 const scenario::Ended& ended) {
  const scenario::Scenario& scenario = record.scenario.scenario;
  auto set_by = record.scenario.origin;
  set_by.erase("seed");  // a seed's result must not depend on the batch
  ordered_json json{{"format_version", 1},
                    {"program", "gaitslam"},
                    {"version", place.version},
                    {"revision", place.revision},
                    {"libraries", place.libraries},
                    {"scenario", scenario.name},
                    {"estimator", scenario.estimator.name},
                    {"seed", scenario.seed},
                    {"ending", scenario::name_of(ended.ending)},
                    {"cause", ended.cause},
                    {"walk_ending", scenario::name_of(record.walk.ending)},
                    {"walk_cause", record.walk.cause},
                    {"recording_xxh3_128", record.recording_hash},
                    {"set_by", set_by}};
  if (!place.models_hash.empty()) json["models_xxh3_128"] = place.models_hash;
  if (record.counterfactual) json["counterfactual"] = *record.counterfactual;
  if (record.alignment) json["alignment"] = *record.alignment;
  write_json(file, json);
}

}  // namespace

void write_json(const fs::path& file, const ordered_json& json) {
  files::write_text(file, files::json_text(json, 2) + "\n");
}

Outcome write_result(const fs::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s) {
  const scenario::Scenario& scenario = record.scenario.scenario;
  const scenario::Ended ended = ending_of(record);
  files::write_text(folder / "scenario.yaml", scenario::to_yaml(scenario));
  write_trajectories(folder, record);
  if (record.tracked) write_tracked(folder, *record.tracked);
  const score::Run input = score_input(record);
  write_feet(folder / "feet.csv", input.feet);
  if (input.steered && input.desired) write_steering(folder, record, *input.desired);
  const score::Metrics metrics =
      ended.ending == scenario::Ending::failed ? unscored(ended.cause) : score::evaluate(input);
  const auto limits = judge_run(scenario, [&](const std::string& name) { return metrics.at(name).value; });
  write_score(folder / "score.json", scenario, ended.ending, metrics,
              record.tracked ? &*record.tracked : nullptr, limits);
  write_about(folder / "about.json", record, place, ended);
  timing.write(folder, simulated_s);
  return {ended, exit_code(scenario, ended.ending, limits)};
}

}  // namespace sim::result
