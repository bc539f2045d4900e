// The assumed noises of a filter, judged by the innovations of a run.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr double kConfidence = 0.99;
constexpr int kDof = 3;  // of a position, an orientation or a velocity
// Errors of a consistent filter persist for seconds, so moments closer together are not independent draws.
constexpr double kPersistence_s = 5;

/// keys: how the keys of its white noise begin.
struct Sensor {
  std::string name, keys;
  std::optional<double> nis;
};
std::vector<Sensor> sensors_of(const RunData& run) {
  const bool legs = run.setting("slam.leg_odometry.enabled") == "true";
  return {
      {"images", "slam.vision.sigma_px", run.value("nis_vision_mean")},
      {legs ? "leg odometry" : "planned velocity",
       legs ? "slam.leg_odometry.sigma_" : "slam.plan_velocity.sigma_", run.value("nis_plan_velocity_mean")},
      {"height", "slam.height.sigma_m", run.value("nis_height_mean")},
      {"gyro", "slam.gyro.sigma_rad_s", run.value("nis_gyro_mean")}};
}

/// Returns "the assumed noise is about 3.9 times too large; slam.vision.sigma_px 0.22 → 0.056 would fit".
/// excess: assumed by fitting standard deviation. A gate removes large innovations, so noise that is too
/// small is even smaller than their squares show.
std::string noise_text(const RunData& run, const std::string& keys, double excess) {
  std::string text = fmt::format("the assumed noise is {} {:.2g} times too {}",
                                 excess > 1 ? "about" : "at least", std::max(excess, 1 / excess),
                                 excess > 1 ? "large" : "small"),
              before = "; ";
  for (auto key = run.settings.lower_bound(keys); key != run.settings.end() && key->first.starts_with(keys);
       ++key)
    if (const auto value = files::parse_number<double>(key->second); value && *value > 0)
      text += fmt::format("{}{} {:.3g} → {:.2g}", std::exchange(before, ", "), key->first, *value,
                          *value / excess);
  return text + (before == "; " ? "" : excess > 1 ? " would fit" : " or more would fit");
}

/// The filter integrates the IMU, which thus has no innovations, but its simulated noise is known.
void add_imu(std::vector<std::string>& remarks, const RunData& run) {
  for (const std::string key : {"gyro.sigma_rad_s", "accelerometer.sigma_m_s2"}) {
    const double assumed = files::parse_number<double>(run.setting("slam." + key)).value_or(0),
                 simulated = files::parse_number<double>(run.setting("errors." + key)).value_or(0),
                 excess = assumed / simulated;
    if (assumed > 0 && simulated > 0 && !run.waist_truth.t.empty() && (excess > 2 || excess < 0.5))
      remarks.push_back(
          fmt::format("errors.{} is {:.3g}: {}", key, simulated, noise_text(run, "slam." + key, excess)));
  }
}

/// Calls add("NIS 0.05 (consistent: 0.41 to 1.9)") if a mean of normalized squares is outside the band of a
/// consistent filter over so many independent draws. dof: of the mean.
void judge(const char* name, const std::optional<double>& mean, double dof, int draws, const auto& add) {
  const auto [low, high] = score::mean_band(kDof, draws, kConfidence);
  const double unit = dof / kDof;
  if (mean && *mean > 0 && (*mean < low * unit || *mean > high * unit))
    add(fmt::format("{} {:.2g} (consistent: {:.2g} to {:.2g})", name, *mean, low * unit, high * unit));
}

}  // namespace

std::vector<std::string> noise_remarks(const RunData& run) {
  std::vector<std::string> remarks;
  if (run.frames.empty()) return remarks;
  add_imu(remarks, run);
  const std::vector<Sensor> sensors = sensors_of(run);
  const double duration_s = slam::seconds(run.frames.back().t - run.frames.front().t);
  for (const Sensor& sensor : sensors)
    judge("NIS", sensor.nis, 1, std::max(1, static_cast<int>(duration_s / kPersistence_s)),
          [&](const auto& nis) {
            remarks.push_back(fmt::format("{}: {}: {}", sensor.name, nis,
                                          noise_text(run, sensor.keys, 1 / std::sqrt(*sensor.nis))));
          });
  const Sensor& largest = *std::ranges::max_element(sensors, {}, &Sensor::nis);
  for (const std::string part : {"position", "orientation"}) {
    const auto nees = run.value("nees_" + part + "_mean");
    // An error of the start persists, so a run is a single draw.
    judge("NEES", nees, kDof, 1, [&](const auto& text) {
      const bool small = *nees > kDof;
      remarks.push_back(fmt::format("{}: {}: the stated standard deviations are about {:.2g} times too {}",
                                    part, text, std::sqrt(small ? *nees / kDof : kDof / *nees),
                                    small ? "small" : "large"));
      if (small && largest.nis)
        remarks.back() += fmt::format("; the largest NIS is that of {} ({:.2g})", largest.name, *largest.nis);
    });
  }
  return remarks;
}

}  // namespace sim::pages
