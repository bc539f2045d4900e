#include "sim/result/timing.h"

#include <fmt/format.h>
#include <time.h>

#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/score/statistics.h"

namespace sim::result {
namespace {

double clock_ms(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double thread_cpu_ms() { return clock_ms(CLOCK_THREAD_CPUTIME_ID); }

void Timing::write(const std::filesystem::path& folder, double simulated_s) const {
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
  json["realtime_factor"] = simulated_s / wall_s;
  json["simulated_s"] = simulated_s;
  json["wall_s"] = wall_s;
  json["cpu_s"] = {{"all", 1e-3 * clock_ms(CLOCK_PROCESS_CPUTIME_ID)},
                   {"plan_and_physics", total_s(&FrameTiming::plan_and_physics_ms)},
                   {"render", total_s(&FrameTiming::render_ms)},
                   {"encode", total_s(&FrameTiming::encode_ms)},
                   {"record", total_s(&FrameTiming::record_ms)},
                   {"filter", total_s(&FrameTiming::filter_ms)}};
  files::write_text(folder / "timing.json", files::json_text(json, 2) + "\n");
}

}  // namespace sim::result
