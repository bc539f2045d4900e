#include "sim/bench/result.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "sim/bench/evidence.h"
#include "sim/bench/scenario_limits.h"
#include "sim/bench/tracked_files.h"
#include "sim/stream/csv.h"
#include "sim/stream/tum.h"

namespace sim::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// What differs between writing a file of text here and there is only the text.
void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw stream::FileError(file, "cannot be written");
}

std::string tum(const std::vector<stream::TimedPose>& poses) {
  std::string text;
  for (const stream::TimedPose& pose : poses) text += stream::tum_row(pose.t, pose.X);
  return text;
}

void write_estimate(const fs::path& folder, const Tracked& tracked) {
  std::string poses, with_covariance = stream::kTumCovarianceHeader;
  for (const slam::Estimate& e : tracked.estimates()) {
    poses += stream::tum_row(e.t, e.X_WC);
    with_covariance += stream::tum_row(e.t, e.X_WC, e.covariance);
  }
  write(folder / "estimate.tum", poses);
  write(folder / "estimate_cov.txt", with_covariance);
}

// When tracking was lost and why, and how many observations were refused, wholly or in part.
ordered_json tracking_json(const Tracked& tracked) {
  const auto refused = std::count_if(tracked.frames.begin(), tracked.frames.end(),
                                     [](const TrackedFrame& frame) { return !frame.report.refused.empty(); });
  ordered_json lost = ordered_json::array();
  for (const Loss& loss : tracked.losses())
    lost.push_back({{"from_s", slam::seconds(loss.from)},
                    {"to_s", loss.to ? ordered_json(slam::seconds(*loss.to)) : ordered_json(nullptr)},
                    {"cause", loss.cause}});
  return {{"observations_refused", refused}, {"lost", lost}};
}

std::string planar_fields(const score::Planar& p) { return fmt::format(",{},{},{}", p.x, p.y, p.yaw); }

void write_feet(const fs::path& folder, const std::vector<score::FootRow>& rows) {
  std::string text =
      "#begin [ns],end [ns],foot,phase,moved_x [m],moved_y [m],moved_yaw [rad],creep_x [m],creep_y "
      "[m],creep_yaw [rad],drift_x [m],drift_y [m],drift_yaw [rad]\n";
  for (const score::FootRow& row : rows) {
    text += fmt::format("{},{},{},{}{}{}{}\n", row.begin.count(), row.end.count(),
                        row.foot == score::Foot::left ? "left" : "right",
                        score::kFootPhases[static_cast<std::size_t>(row.phase)], planar_fields(row.moved),
                        planar_fields(row.creep), planar_fields(row.drift));
  }
  write(folder / "feet.csv", text);
}

ordered_json metrics_json(const score::Metrics& metrics) {
  ordered_json json;
  for (const score::MetricDefinition& defined : score::metric_definitions()) {
    const score::Metric& metric = metrics.find(defined.name)->second;
    ordered_json& entry = json[std::string(defined.name)];
    entry["value"] = metric.value ? ordered_json(*metric.value) : ordered_json(nullptr);
    entry["unit"] = metric.unit;
    if (!metric.value) entry["reason"] = metric.reason;
  }
  return json;
}

/// Of a run that is not to be believed.
score::Metrics unscored(const std::string& cause) {
  const std::string reason = "not scored: " + (cause.empty() ? "the run failed" : cause);
  score::Metrics metrics;
  for (const score::MetricDefinition& defined : score::metric_definitions())
    metrics[std::string(defined.name)] = {std::nullopt, std::string(defined.unit), reason};
  return metrics;
}

// The limits that one run is held to; those over seeds are the summary's. A metric that is not there misses
// its limit, unless no filter was to run.
ordered_json limits_json(const Scenario& scenario, const score::Metrics& metrics, bool& all_kept) {
  ordered_json json = ordered_json::array();
  for (const MetricLimit& limit : scenario.limits.metrics) {
    if (!limit.aggregate.empty()) continue;
    const std::optional<double> value = metrics.at(limit.metric).value;
    ordered_json entry{{"metric", limit.metric},
                       {limit.bound == Bound::at_most ? "at_most" : "at_least", limit.value},
                       {"value", value ? ordered_json(*value) : ordered_json(nullptr)}};
    if (value || scenario.slam) {
      const bool kept = value && keeps(limit, *value);
      entry["passed"] = kept;
      all_kept &= kept;
    } else {
      entry["passed"] = nullptr;
      entry["reason"] = "no filter was to run";
    }
    json.push_back(entry);
  }
  return json;
}

void write_about(const fs::path& folder, const Remains& remains, const ResultPlace& place,
                 const Outcome& outcome) {
  const Scenario& scenario = remains.scenario.scenario;
  auto set_by = remains.scenario.origin;
  set_by.erase("seed");  // alone or in a batch, a seed's result is the same
  const ordered_json json{{"format_version", 1},
                          {"program", "gaitslam"},
                          {"version", place.version},
                          {"revision", place.revision},
                          {"libraries", place.libraries},
                          {"scenario", scenario.name},
                          {"seed", scenario.seed},
                          {"ending", outcome.ending},
                          {"cause", outcome.cause},
                          {"walk_ending", remains.ending},
                          {"walk_cause", remains.cause},
                          {"recording_xxh3_128", remains.recording_hash},
                          {"set_by", set_by}};
  write(folder / "about.json", json.dump(2) + "\n");
}

}  // namespace

Outcome ending_of(const Remains& remains) {
  if (remains.ending == "completed" && remains.tracked && remains.tracked->diverged())
    return {"diverged", remains.tracked->cause(), 0};
  return {remains.ending, remains.cause, 0};
}

Outcome write_result(const fs::path& folder, const Remains& remains, const ResultPlace& place,
                     const Timing& timing, double simulated_s) {
  const Scenario& scenario = remains.scenario.scenario;
  Outcome outcome = ending_of(remains);
  write(folder / "scenario.yaml", to_yaml(scenario));
  write(folder / "truth.tum", tum(remains.truth.camera));
  write(folder / "plan.tum", tum(planned_camera(remains)));
  write(folder / "waist_truth.tum", tum(remains.truth.waist));
  write(folder / "waist_plan.tum", tum(remains.truth.waist_plan));
  if (remains.tracked) {
    write_estimate(folder, *remains.tracked);
    write_tracked(folder, *remains.tracked);
  }
  const score::Run scored = evidence(remains);
  write_feet(folder, scored.feet);
  const score::Metrics metrics =
      outcome.ending == "failed" ? unscored(outcome.cause) : score::evaluate(scored);
  bool kept = true;
  ordered_json json{{"format_version", 1},
                    {"scenario", scenario.name},
                    {"seed", scenario.seed},
                    {"ending", outcome.ending}};
  json["metrics"] = metrics_json(metrics);
  if (remains.tracked) json["tracking"] = tracking_json(*remains.tracked);
  json["limits"] = limits_json(scenario, metrics, kept);
  const auto& allowed = scenario.limits.ending;
  const bool may_end_so = std::find(allowed.begin(), allowed.end(), outcome.ending) != allowed.end();
  outcome.exit_code = !may_end_so ? 3 : kept ? 0 : 1;
  write(folder / "score.json", json.dump(2) + "\n");
  write_about(folder, remains, place, outcome);
  timing.write(folder, simulated_s);
  return outcome;
}

}  // namespace sim::bench
