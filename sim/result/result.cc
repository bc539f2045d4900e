#include "sim/result/result.h"

#include <time.h>

#include "sim/recording/recording_format.h"
#include "sim/result/limits.h"
#include "sim/score/metrics.h"

namespace sim::result {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kFewFrames = 10;  // fewer frames do not show that a sensor is unused

// Finds the first enabled sensor of the filter that was not used in any frame.
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
    const std::string& estimator = scenario.estimator.name;
    return scenario::Ended{
        scenario::Ending::sensor_unused,
        readings == 0 ? fmt::format("the {1} had no readings of {0}; slam.{0}.enabled: false expects none",
                                    name, estimator)
                      : fmt::format("the {} accepted {} in none of the {} frames with readings", estimator,
                                    name, readings)};
  }
  return std::nullopt;
}

void write_tum(const fs::path& file, const std::vector<files::TimedPose>& poses,
               bool positions_only = false) {
  std::string text = positions_only ? "# timestamp(s) tx ty tz\n" : "";
  for (const files::TimedPose& pose : poses) {
    text += files::tum_row(pose.t, pose.X);
    if (positions_only) text.replace(text.rfind(" 0 0 0 1"), text.npos, "\n");
  }
  files::write_text(file, text);
}

/// Writes a steered walk's desired path and the corrections of its steps.
void write_steering(const fs::path& folder, const RunRecord& record, const score::DesiredPath& desired) {
  write_tum(folder / "waist_desired.tum", desired.waist);
  std::string steps = "#time [ns]" + recording::recording_format::kCorrectionColumns + "\n";
  for (const score::StepCorrection& step : record.truth.corrected_steps)
    steps += fmt::format("{}{}\n", step.t.count(), recording::correction_fields(step));
  files::write_text(folder / "corrected_steps.csv", steps);
}

void write_feet(const fs::path& file, const std::vector<score::FootRow>& rows) {
  std::string text =
      "#begin [ns],end [ns],foot,phase,moved_x [m],moved_y [m],moved_yaw [rad],creep_x [m],creep_y "
      "[m],creep_yaw [rad],drift_x [m],drift_y [m],drift_yaw [rad]\n";
  for (const score::FootRow& row : rows) {
    text += fmt::format("{},{},{},{}", row.begin.count(), row.end.count(), row.left ? "left" : "right",
                        score::kFootPhases[std::size_t(row.phase)]);
    for (const Eigen::Vector3d& p : {row.moved, row.creep, row.drift}) text += "," + files::csv_fields(p);
    text += "\n";
  }
  files::write_text(file, text);
}

ordered_json faults_json(const std::vector<tracking::TrackingFault>& faults) {
  ordered_json json = ordered_json::array();
  for (const tracking::TrackingFault& fault : faults)
    json.push_back({{"from_s", slam::seconds(fault.from)},
                    {"to_s", fault.to ? ordered_json(slam::seconds(*fault.to)) : ordered_json(nullptr)},
                    {"cause", fault.cause}});
  return json;
}

void write_score(const fs::path& file, const scenario::Scenario& scenario, const Outcome& outcome,
                 const score::Metrics& metrics, const tracking::Tracked* tracked,
                 const std::vector<JudgedLimit>& limits) {
  ordered_json json{{"format_version", 1},
                    {"scenario", scenario.name},
                    {"estimator", scenario.estimator.name},
                    {"seed", scenario.seed},
                    {"ending", scenario::name_of(outcome.ending)},
                    {"exit_code", outcome.exit_code}};
  for (const score::MetricDefinition& defined : score::metric_definitions()) {
    const score::Metric& metric = metrics.find(defined.name)->second;
    ordered_json& entry = json["metrics"][defined.name];
    entry = {{"value", or_null(metric.value)}, {"unit", metric.unit}};
    if (!metric.value) entry["reason"] = metric.reason;
    if (metric.note) entry["note"] = *metric.note;
  }
  if (const auto model = scenario.estimator_time.model; tracked && model != scenario::TimeModel::none)
    json["estimator_time"] = {{"model", scenario::kTimeModels[std::size_t(model)]},
                              {"repeatable", model == scenario::TimeModel::fixed}};
  if (tracked)
    json["tracking"] = {{"observations_refused",
                         std::ranges::count_if(tracked->frames,
                                               [](const auto& frame) { return bool(frame.report.refused); })},
                        {"lost", faults_json(tracked->losses())},
                        {"suspect", faults_json(tracked->suspicions())}};
  json["limits"] = ordered_json::array();
  for (const JudgedLimit& judged : limits) {
    json["limits"].push_back(to_json(judged));
    if (!judged.passed) json["limits"].back()["reason"] = "no filter was requested";
  }
  files::write_text(file, files::json_text(json, 2) + "\n");
}

/// Returns whether an interrupted run of this program finished the session.
bool is_finished(const fs::path& folder, const scenario::Scenario& session, const ResultPlace& place) try {
  const About made = read_about(folder / "about.json");
  return fs::exists(folder / "recording") &&
         fs::last_write_time(folder / "about.json") > fs::last_write_time("/proc/self/exe") &&
         files::read_text(folder / "scenario.yaml") == scenario::to_yaml(session) &&
         made.revision == place.revision && made.models == place.models_hash &&
         made.estimator_files == provenance_of(session, "", "").estimator_files;
} catch (const std::exception&) {
  return false;
}

/// Returns a hash of the names and bytes of the files below a folder.
std::string hash_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.symlink_status().type() == fs::file_type::regular) files.push_back(entry.path());
  std::ranges::sort(files);
  files::Hash hash;
  for (const fs::path& file : files) {
    hash.add_part(file.lexically_relative(folder).generic_string());
    hash.add_part(files::read_text(file));
  }
  return hash.hex();
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
  if (const std::string hash = provenance_of(scenario, "", "").estimator_files; !hash.empty())
    json["estimator_xxh3_128"] = hash;
  if (fs::exists(file.parent_path() / "memory"))
    json["memory_xxh3_128"] = hash_of(file.parent_path() / "memory");
  if (record.counterfactual) json["counterfactual"] = *record.counterfactual;
  if (record.alignment) json["alignment"] = score::name_of(*record.alignment);
  files::write_text(file, files::json_text(json, 2) + "\n");
}

}  // namespace

void Timing::write(const fs::path& folder, double simulated_s) const {
  std::string csv =
      "#timestamp [ns],plan_and_physics [ms],render [ms],encode [ms],record [ms],filter [ms],landmarks\n";
  for (const FrameTiming& f : frames)
    csv += fmt::format("{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{}\n", f.t.count(), f.plan_and_physics_ms,
                       f.render_ms, f.encode_ms, f.record_ms, f.filter_ms, f.landmarks);
  files::write_text(folder / "timing.csv", csv);

  const auto total_s = [&](double FrameTiming::*stage) {
    double sum_ms = 0;
    for (const FrameTiming& frame : frames) sum_ms += frame.*stage;
    return 1e-3 * sum_ms;
  };
  std::vector<double> filter;
  for (const FrameTiming& frame : frames)
    if (frame.answered) filter.push_back(frame.filter_ms);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  nlohmann::ordered_json json;
  json["frame_cpu_ms_mean"] = filter.empty() ? 0 : score::mean(filter);
  if (each_frame)
    for (const auto& [name, p] : {std::pair{"frame_cpu_ms_median", 0.5}, {"frame_cpu_ms_p99", 0.99}})
      json[name] = filter.empty() ? 0 : score::quantile(filter, p);
  if (!controller_ms.empty())
    for (const auto& [name, p] : {std::pair{"controller_ms_median", 0.5}, {"controller_ms_p99", 0.99}})
      json[name] = score::quantile(controller_ms, p);
  json["realtime_factor"] = simulated_s / wall_s;
  json["simulated_s"] = simulated_s;
  json["wall_s"] = wall_s;
  json["cpu_s"] = {{"all", 1e-3 * tracking::cpu_ms(CLOCK_PROCESS_CPUTIME_ID)},
                   {"plan_and_physics", total_s(&FrameTiming::plan_and_physics_ms)},
                   {"render", total_s(&FrameTiming::render_ms)},
                   {"encode", total_s(&FrameTiming::encode_ms)},
                   {"record", total_s(&FrameTiming::record_ms)},
                   {"filter", total_s(&FrameTiming::filter_ms)}};
  files::write_text(folder / "timing.json", files::json_text(json, 2) + "\n");
}

bool uses_filter(const scenario::Scenario& scenario) {
  const programs::Choice& estimator = scenario.estimator;
  return scenario.slam && estimator.source == programs::Source::built_in &&
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

Outcome make_sessions(const scenario::ReadScenario& read, const ResultPlace& place, const Progress& progress,
                      const MakeSession& make) {
  const std::size_t before = read.scenario.sessions.size();
  files::AtomicFolder folder(place.folder, before > 0 ? files::Keeps::marked_folders : files::Keeps::nothing);
  const auto part_of = [&](std::size_t i) {
    return [&progress, i, before](double part) { progress((double(i) + part) / double(before + 1)); };
  };
  const auto folder_of = [&](std::size_t i) { return folder.path() / fmt::format("session-{}", i + 1); };
  estimators::Session from{.count = int(before) + 1};
  std::string file;
  fs::path kept;  // the memory of the last program that has not failed
  const auto begin = [&](const fs::path& into) {
    if (from.count == 1 || read.scenario.estimator.source == programs::Source::built_in) return;
    from.memory = fs::absolute(into) / "memory";
    fs::create_directory(from.memory);
    if (!kept.empty())
      fs::copy(kept, from.memory, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  };
  bool resumes = true;
  for (std::size_t i = 0; i < before; ++i) {
    scenario::ReadScenario session = scenario::session(read, i);
    session.scenario.slam->map.load = file;
    ResultPlace below = place;
    below.folder = folder_of(i);
    resumes = resumes && is_finished(below.folder, session.scenario, place);
    if (!resumes) {
      files::AtomicFolder into(below.folder);
      begin(into.path());
      make(session, from, below, into.path(), part_of(i));
      into.commit();
    }
    ++from.index;
    const bool failed = read_result(below.folder).ending == scenario::Ending::estimator_failed;
    if (fs::exists(below.folder / "memory") && !failed) kept = below.folder / "memory";
    if (!fs::exists(below.folder / "map.bin")) continue;  // the next session loads the same map
    from.map_file = below.folder / "map.bin";
    file = fmt::format("../session-{}/map.bin", i + 1);
  }
  for (std::size_t i = before; fs::exists(folder_of(i)); ++i) files::remove_marked(folder_of(i));
  begin(folder.path());
  const Outcome outcome = make(read, from, place, folder.path(), part_of(before));
  folder.commit();
  return outcome;
}

Outcome write_result(const fs::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s) {
  const scenario::Scenario& scenario = record.scenario.scenario;
  const scenario::Ended ended = ending_of(record);
  files::write_text(folder / "scenario.yaml", scenario::to_yaml(scenario));
  write_tum(folder / "truth.tum", record.truth.camera, record.truth.positions_of.has_value());
  write_tum(folder / "plan.tum", planned_camera(record));
  write_tum(folder / "waist_truth.tum", record.truth.waist);
  write_tum(folder / "waist_plan.tum", record.truth.waist_plan);
  if (record.tracked) {
    write_tracked(folder, *record.tracked);
    if (scenario.estimator_time.model != scenario::TimeModel::none)
      write_answers(folder / "answers.csv", *record.tracked, exposure(scenario));
  }
  const score::Run input = score_input(record);
  if (!input.odometry.empty()) write_tum(folder / "odometry.tum", input.odometry);
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
  const Outcome outcome{ended, exit_code(scenario, ended.ending, limits)};
  write_score(folder / "score.json", scenario, outcome, metrics, record.tracked ? &*record.tracked : nullptr,
              limits);
  write_about(folder / "about.json", record, place, ended);
  timing.write(folder, simulated_s);
  return outcome;
}

}  // namespace sim::result
