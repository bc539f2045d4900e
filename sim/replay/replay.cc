#include "sim/replay/replay.h"

#include "sim/result/score_file.h"

namespace sim::replay {
namespace {

// Processes the whole recording. Returns the stamp of the last observation.
slam::Stamp track(recording::RecordingReader& reader, std::optional<tracking::Tracking>& tracking,
                  result::Timing& timing, const result::Progress& progress,
                  const tracking::TrackingObserver& observer) {
  slam::Stamp last{0};
  while (auto observation = reader.next()) {
    result::FrameTiming frame{.t = observation->t};
    last = observation->t;
    const auto process = [&](slam::Observation ideal) {
      if (!tracking) return;
      const result::StageClock clock(frame.filter_ms);
      tracking->process(std::move(ideal));
      frame.filter_ms += tracking->external_cpu_ms();
    };
    tracking::process_observed(std::move(*observation), tracking ? &*tracking : nullptr, observer, process);
    frame.landmarks = tracking ? tracking->landmarks() : 0;
    timing.frames.push_back(frame);
    progress(reader.part());
  }
  return last;
}

}  // namespace

WalkEnd read_walk_end(const std::filesystem::path& result_folder) {
  const result::About about = result::read_about_of_walk(result_folder / "about.json");
  return {*about.walk, std::nullopt, about.models};
}

result::Outcome replay(const scenario::ReadScenario& scenario, const std::filesystem::path& recording,
                       const WalkEnd& walk, const result::ResultPlace& place,
                       const result::Progress& progress, Recorded recorded,
                       const tracking::TrackingObserver& observer) {
  files::DurableFolder folder(place.folder, place.existing);
  result::Timing timing;
  recording::RecordingReader reader(recording);
  std::optional<tracking::Tracking> tracking;
  if (scenario.scenario.slam)
    tracking.emplace(scenario.scenario, reader.setup().calibration, reader.setup().X_WC_start);
  const slam::Stamp last = track(reader, tracking, timing, progress, observer);
  result::RunRecord record{scenario,     walk.ended,   reader.setup(), recording::read_truth(recording),
                           std::nullopt, reader.hash()};
  record.counterfactual = walk.counterfactual;
  if (tracking) record.tracked = tracking->finish();
  const result::Outcome outcome =
      result::write_result(folder.path(), record, place, timing, 1e-9 * static_cast<double>(last.count()));
  if (recorded == Recorded::copied)
    std::filesystem::copy(recording, folder.path() / "recording", std::filesystem::copy_options::recursive);
  folder.commit();
  return outcome;
}

}  // namespace sim::replay
