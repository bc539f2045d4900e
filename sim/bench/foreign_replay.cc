#include "sim/bench/foreign_replay.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

#include "sim/stream/asl_folder.h"

namespace sim::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kReading_s = 0.005;  // that the filter's standard deviation of a reading is meant for

// No noise on top of the sensors' own; there is no walk to be described.
constexpr const char* kText = R"(
walk: {commands: [stand: {duration_s: 1}]}
errors:
  gyro: {sigma_rad_s: 0}
  accelerometer: {sigma_m_s2: 0}
  image: {read_sigma_grey: 0, shot_sigma_grey: 0}
camera: {}
slam: {}
)";

std::string name_of(const fs::path& folder) {
  std::string name = fs::absolute(folder / "x").lexically_normal().parent_path().filename().string();
  for (char& letter : name)
    if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '_';
  return name.empty() ? "recording" : name;
}

std::string setting(const char* key, double value) { return fmt::format("{}={}", key, value); }

// What the folder's own files say of its IMU.
std::vector<std::string> settings_of(const stream::AslSensors& sensors) {
  std::vector<std::string> settings;
  if (sensors.noise.gyro_density > 0)
    settings.push_back(setting("slam.gyro.sigma_rad_s", sensors.noise.gyro_density / std::sqrt(kReading_s)));
  if (sensors.noise.accelerometer_density > 0)
    settings.push_back(setting("slam.accelerometer.sigma_m_s2",
                               sensors.noise.accelerometer_density / std::sqrt(kReading_s)));
  if (sensors.has_plan) return settings;
  settings.push_back("slam.accelerometer.enabled=false");
  settings.push_back(setting("slam.gyro.sigma_bias_rad_s", 0.1));
  if (sensors.noise.gyro_walk > 0)
    settings.push_back(setting("slam.gyro.sigma_bias_walk_rad_s2", sensors.noise.gyro_walk));
  return settings;
}

// Nothing in images and turning rates tells how large the world is.
std::string why_no_scale(const slam::Options& options, bool has_plan) {
  if (options.accelerometer.enabled || (has_plan && options.plan_velocity.enabled)) return "";
  return "camera and gyro do not tell the scale: see ate_sim3_rmse_m";
}

}  // namespace

ReadScenario foreign_scenario(const fs::path& folder, const Changes& changes) {
  ReadScenario plain = read_scenario_text(kText, folder.string(), changes);  // complains of what was typed
  Changes all = changes;
  std::vector<std::string> settings{"name=" + name_of(folder)};
  for (const std::string& said : settings_of(stream::AslFolder(folder).sensors()))
    if (!plain.origin.contains(said.substr(0, said.find('=')))) settings.push_back(said);
  all.overrides.insert(all.overrides.begin(), settings.begin(), settings.end());
  return read_scenario_text(kText, folder.string(), all);
}

Outcome replay_foreign(const ReadScenario& scenario, const fs::path& folder, const ResultPlace& place,
                       const Progress& progress) {
  stream::DurableFolder result(place.folder, place.existing);
  stream::AslFolder reader(folder);
  const stream::AslSensors& sensors = reader.sensors();
  Tracking tracking(scenario.scenario, sensors.setup.calibration, sensors.setup.X_WC_start);
  Timing timing;
  std::vector<slam::Stamp> times;
  std::vector<stream::TimedPose> plan;
  while (auto observation = reader.next()) {
    FrameTiming frame{.t = observation->t};
    times.push_back(observation->t);
    if (observation->plan) plan.push_back({observation->t, observation->plan->X_PC});
    {
      const StageClock clock(frame.filter_ms);
      tracking.take(std::move(*observation));
    }
    timing.frames.push_back(frame);
    progress(0);
  }
  Remains remains{scenario, "completed", "", sensors.setup, {}, tracking.finish(), ""};
  remains.truth.camera = stream::read_asl_truth(folder, sensors, times);
  remains.planned_camera = std::move(plan);
  remains.no_scale = why_no_scale(*scenario.scenario.slam, sensors.has_plan);
  const Outcome outcome =
      write_result(result.path(), remains, place, timing, times.empty() ? 0 : slam::seconds(times.back()));
  result.commit();
  return outcome;
}

}  // namespace sim::bench
