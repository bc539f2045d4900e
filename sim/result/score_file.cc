#include "sim/result/score_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sim/files/json.h"
#include "sim/result/json.h"
#include "sim/score/metrics.h"

namespace sim::result {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

ordered_json metrics_json(const score::Metrics& metrics) {
  ordered_json json;
  for (const score::MetricDefinition& defined : score::metric_definitions()) {
    const score::Metric& metric = metrics.find(defined.name)->second;
    ordered_json& entry = json[defined.name];
    entry["value"] = or_null(metric.value);
    entry["unit"] = metric.unit;
    if (!metric.value) entry["reason"] = metric.reason;
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

// When tracking was lost and why, when a sensor was suspect, and how many observations were refused, wholly
// or in part.
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

// A limit as to_json(JudgedLimit) writes it.
void check_limit(const files::Json& limit) {
  limit.at("metric").text();
  limit.at("value").number_or_null();
  limit.at(limit.find("at_most") ? "at_most" : "at_least").number();
  if (const files::Json passed = limit.at("passed"); !passed.is_null()) passed.flag();
}

}  // namespace

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

std::optional<double> SeedScore::value(const std::string& metric) const {
  const auto found =
      std::find_if(metrics.begin(), metrics.end(), [&](const SeedMetric& m) { return m.name == metric; });
  return found == metrics.end() ? std::nullopt : found->value;
}

scenario::Ending read_ending(const files::Json& json) {
  if (const auto ending = scenario::ending_named(json.text())) return *ending;
  json.fail(
      fmt::format("is '{}', expected one of {}", json.text(), fmt::join(scenario::kResultEndings, ", ")));
}

SeedScore read_score(const fs::path& file) {
  const files::Json json = files::read_json(file);
  SeedScore score{0, read_ending(json.at("ending")), 0, {}};
  if (const auto seed = json.find("seed")) score.seed = seed->whole();
  for (const auto& [name, metric] : json.at("metrics").entries())
    score.metrics.push_back({name, metric.at("unit").text(), metric.at("value").number_or_null()});
  return score;
}

files::Json read_whole_score(const fs::path& file) {
  files::Json json = files::read_json(file);
  json.at("scenario").text();
  read_ending(json.at("ending"));
  json.at("seed").whole();
  if (const auto estimator = json.find("estimator")) estimator->text();
  for (const auto& [name, metric] : json.at("metrics").entries()) {
    metric.at("unit").text();
    metric.at("value").number_or_null();
    if (const auto reason = metric.find("reason")) reason->text();
  }
  for (const files::Json& limit : json.at("limits").items()) check_limit(limit);
  if (const auto tracking = json.find("tracking"))
    for (const char* kind : {"lost", "suspect"})
      if (const auto faults = tracking->find(kind))
        for (const files::Json& fault : faults->items())
          fault.at("from_s").number(), fault.at("cause").text();
  return json;
}

SeedScore read_seed_score(const fs::path& root, std::uint64_t seed, int exit_code) {
  const fs::path file = root / fmt::format("seed-{}", seed) / "score.json";
  if (!fs::exists(file) && exit_code > 1)
    return {seed, exit_code == 2 ? scenario::Ending::not_started : scenario::Ending::crashed, exit_code, {}};
  SeedScore score = read_score(file);
  score.seed = seed;
  score.exit_code = exit_code;
  return score;
}

}  // namespace sim::result
