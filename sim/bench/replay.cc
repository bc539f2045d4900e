#include "sim/bench/replay.h"

namespace sim::bench {

Outcome replay(const ReadScenario& scenario, const std::filesystem::path& recording,
               const std::string& walk_ending, const ResultPlace& place, const Progress& progress) {
  stream::DurableFolder folder(place.folder, place.existing);
  Timing timing;
  stream::RecordingReader reader(recording);
  Tracking tracking(scenario.scenario, reader.setup().calibration, reader.setup().X_WC_start);
  slam::Stamp last{0};
  while (auto observation = reader.next()) {
    FrameTiming frame{.t = observation->t};
    last = observation->t;
    {
      const StageClock clock(frame.filter_ms);
      tracking.take(std::move(*observation));
    }
    frame.landmarks = tracking.landmarks();
    timing.frames.push_back(frame);
    progress(0);
  }
  const Remains remains{scenario,          walk_ending,  "", reader.setup(), stream::read_truth(recording),
                        tracking.finish(), reader.hash()};
  const Outcome outcome =
      write_result(folder.path(), remains, place, timing, 1e-9 * static_cast<double>(last.count()));
  folder.commit();
  return outcome;
}

}  // namespace sim::bench
