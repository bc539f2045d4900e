#include "sim/bench/timing.h"

#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace sim::bench {
namespace {

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

std::vector<double> column(const std::vector<FrameTiming>& frames, double FrameTiming::*member) {
  std::vector<double> values;
  for (const FrameTiming& frame : frames) values.push_back(frame.*member);
  return values;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (double value : values) total += value;
  return total;
}

// The filter's CPU time of a frame by the size of its map: how it grows is what limits a map.
nlohmann::ordered_json by_landmarks(const std::vector<FrameTiming>& frames) {
  std::map<int, std::vector<double>> tens;
  for (const FrameTiming& frame : frames) tens[frame.landmarks / 10 * 10].push_back(frame.filter_ms);
  auto json = nlohmann::ordered_json::array();
  for (const auto& [from, filter] : tens)
    json.push_back({{"landmarks_from", from},
                    {"landmarks_to", from + 9},
                    {"frames", filter.size()},
                    {"median", quantile(filter, 0.5)},
                    {"p99", quantile(filter, 0.99)}});
  return json;
}

}  // namespace

double process_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void Timing::write(const std::filesystem::path& folder, double simulated_s) const {
  std::ofstream csv(folder / "timing.csv");
  csv << "#timestamp [ns],plan_and_physics [ms],render [ms],record [ms],filter [ms],landmarks\n";
  for (const FrameTiming& f : frames)
    csv << fmt::format("{},{:.4f},{:.4f},{:.4f},{:.4f},{}\n", f.t.count(), f.plan_and_physics_ms, f.render_ms,
                       f.record_ms, f.filter_ms, f.landmarks);

  const auto filter = column(frames, &FrameTiming::filter_ms);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  nlohmann::ordered_json json;
  json["frame_cpu_ms_median"] = quantile(filter, 0.5);
  json["frame_cpu_ms_p99"] = quantile(filter, 0.99);
  json["frame_cpu_ms_by_landmarks"] = by_landmarks(frames);
  json["realtime_factor"] = simulated_s / wall_s;
  json["simulated_s"] = simulated_s;
  json["wall_s"] = wall_s;
  json["cpu_s"] = {{"all", 1e-3 * process_cpu_ms()},
                   {"plan_and_physics", 1e-3 * sum(column(frames, &FrameTiming::plan_and_physics_ms))},
                   {"render", 1e-3 * sum(column(frames, &FrameTiming::render_ms))},
                   {"record", 1e-3 * sum(column(frames, &FrameTiming::record_ms))},
                   {"filter", 1e-3 * sum(filter)}};
  std::ofstream(folder / "timing.json") << json.dump(2) << '\n';
}

}  // namespace sim::bench
