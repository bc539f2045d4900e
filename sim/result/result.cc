#include "sim/result/result.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/files/trajectory_file.h"
#include "sim/result/json.h"
#include "sim/result/limits.h"
#include "sim/score/metrics.h"

namespace sim::result {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kFewFrames = 10;  // fewer do not show that a sensor is unused

// The first enabled sensor of the filter that was used in no frame.
std::optional<scenario::Ended> unused_sensor(const RunRecord& record) {
  const scenario::Scenario& scenario = record.scenario.scenario;
  const auto& frames = record.tracked->frames;
  if (!uses_filter(scenario) || frames.size() < kFewFrames) return std::nullopt;
  const slam::Options& options = *scenario.slam;
  const std::array<bool, slam::kSensorNames.size()> enabled{
      uses_images(scenario), options.gyro.enabled, options.plan_velocity.enabled, options.height.enabled,
      options.accelerometer.enabled};
  for (std::size_t i = 0; i < enabled.size(); ++i) {
    const auto frames_with = [&](slam::SensorUse use) {
      return std::ranges::count_if(frames, [&](const auto& frame) { return frame.report.use[i] >= use; });
    };
    const auto name = slam::kSensorNames[i];
    if (!enabled[i] || frames_with(slam::SensorUse::accepted) > 0) continue;
    const auto readings = frames_with(slam::SensorUse::readings);
    return scenario::Ended{
        scenario::Ending::sensor_unused,
        readings == 0
            ? fmt::format("the filter had no readings of {0}; slam.{0}.enabled: false expects none", name)
            : fmt::format("the filter accepted {} in none of the {} frames with readings", name, readings)};
  }
  return std::nullopt;
}

void write_tum(const fs::path& file, const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(pose.t, pose.X);
  files::write_text(file, text);
}

void write_positions(const fs::path& file, const std::vector<files::TimedPose>& poses) {
  std::string text = "# timestamp(s) tx ty tz\n";
  for (const files::TimedPose& pose : poses) {
    const std::string row = files::tum_row(pose.t, pose.X);
    text += row.substr(0, row.rfind(" 0 0 0 1")) + '\n';
  }
  files::write_text(file, text);
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

/// A steered walk's desired path, and the corrections of its steps.
void write_steering(const fs::path& folder, const RunRecord& record, const score::DesiredPath& desired) {
  write_tum(folder / "waist_desired.tum", desired.waist);
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

void write_score(const fs::path& file, const scenario::Scenario& scenario, scenario::Ending ending,
                 const score::Metrics& metrics, const tracking::Tracked* tracked,
                 const std::vector<JudgedLimit>& limits) {
  ordered_json json{{"format_version", 1},
                    {"scenario", scenario.name},
                    {"estimator", scenario.estimator.name},
                    {"seed", scenario.seed},
                    {"ending", scenario::name_of(ending)}};
  json["metrics"] = metrics_json(metrics);
  if (tracked)
    json["tracking"] = {{"observations_refused",
                         std::count_if(tracked->frames.begin(), tracked->frames.end(),
                                       [](const auto& frame) { return !frame.report.refused.empty(); })},
                        {"lost", faults_json(tracked->losses())},
                        {"suspect", faults_json(tracked->suspicions())}};
  json["limits"] = ordered_json::array();
  for (const JudgedLimit& judged : limits) {
    json["limits"].push_back(to_json(judged));
    if (!judged.passed) json["limits"].back()["reason"] = "no filter was to run";
  }
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

bool uses_filter(const scenario::Scenario& scenario) {
  const estimators::EstimatorChoice& estimator = scenario.estimator;
  return scenario.slam && estimator.source == estimators::Source::built_in &&
         (estimator.name == "filter" || estimator.name == "odometry");
}

bool uses_images(const scenario::Scenario& scenario) {
  return uses_filter(scenario) && scenario.estimator.name == "filter" && scenario.slam->vision.enabled;
}

scenario::Ended ending_of(const RunRecord& record) {
  using enum scenario::Ending;
  auto failure = record.tracked ? record.tracked->failure() : std::nullopt;
  if (!failure && record.tracked) failure = unused_sensor(record);
  // A robot stops if the estimator that steers it fails.
  const bool explains_stop = record.walk.ending == stopped && failure && failure->ending == estimator_failed;
  return failure && (record.walk.ending == completed || explains_stop) ? *failure : record.walk;
}

void write_json(const fs::path& file, const ordered_json& json) {
  files::write_text(file, files::json_text(json, 2) + "\n");
}

Outcome write_result(const fs::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s) {
  const scenario::Scenario& scenario = record.scenario.scenario;
  const scenario::Ended ended = ending_of(record);
  files::write_text(folder / "scenario.yaml", scenario::to_yaml(scenario));
  if (record.truth.positions_of)
    write_positions(folder / "truth.tum", record.truth.camera);
  else
    write_tum(folder / "truth.tum", record.truth.camera);
  write_tum(folder / "plan.tum", planned_camera(record));
  write_tum(folder / "waist_truth.tum", record.truth.waist);
  write_tum(folder / "waist_plan.tum", record.truth.waist_plan);
  if (record.tracked) {
    write_estimate(folder, *record.tracked);
    write_tracked(folder, *record.tracked);
  }
  const score::Run input = score_input(record);
  write_feet(folder / "feet.csv", input.feet);
  if (input.steered && input.desired) write_steering(folder, record, *input.desired);
  score::Metrics metrics;
  if (ended.ending != scenario::Ending::failed)
    metrics = score::evaluate(input);
  else
    for (const score::MetricDefinition& defined : score::metric_definitions())
      metrics[defined.name] = {std::nullopt, defined.unit,
                               "not scored: " + (ended.cause.empty() ? "the run failed" : ended.cause)};
  const auto limits = judge_run(scenario, [&](const std::string& name) { return metrics.at(name).value; });
  write_score(folder / "score.json", scenario, ended.ending, metrics,
              record.tracked ? &*record.tracked : nullptr, limits);
  write_about(folder / "about.json", record, place, ended);
  timing.write(folder, simulated_s);
  return {ended, exit_code(scenario, ended.ending, limits)};
}

}  // namespace sim::result
