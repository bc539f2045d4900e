#include "sim/bench/replay.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/stream/file_error.h"

namespace sim::bench {
namespace {

/// The whole recording through the filter. Gives the stamp of its last observation.
slam::Stamp track(stream::RecordingReader& reader, std::optional<Tracking>& tracking, Timing& timing,
                  const Progress& progress) {
  slam::Stamp last{0};
  while (auto observation = reader.next()) {
    FrameTiming frame{.t = observation->t};
    last = observation->t;
    if (tracking) {
      const StageClock clock(frame.filter_ms);
      tracking->take(std::move(*observation));
    }
    frame.landmarks = tracking ? tracking->landmarks() : 0;
    timing.frames.push_back(frame);
    progress(0);
  }
  return last;
}

}  // namespace

WalkEnd read_walk_end(const std::filesystem::path& result_folder) {
  const std::filesystem::path about = result_folder / "about.json";
  std::ifstream in(about);
  if (!in) throw stream::FileError(about, "cannot be read");
  try {
    const auto json = nlohmann::json::parse(in);
    return {json.at("walk_ending"), json.value("walk_cause", "")};
  } catch (const nlohmann::json::exception&) {
    throw stream::FileError(about, "expected JSON with walk_ending");
  }
}

Outcome replay(const ReadScenario& scenario, const std::filesystem::path& recording, const WalkEnd& walk,
               const ResultPlace& place, const Progress& progress, Recorded recorded) {
  stream::DurableFolder folder(place.folder, place.existing);
  Timing timing;
  stream::RecordingReader reader(recording);
  std::optional<Tracking> tracking;
  if (scenario.scenario.slam)
    tracking.emplace(scenario.scenario, reader.setup().calibration, reader.setup().X_WC_start);
  const slam::Stamp last = track(reader, tracking, timing, progress);
  Remains remains{scenario,     walk.ending,  walk.cause, reader.setup(), stream::read_truth(recording),
                  std::nullopt, reader.hash()};
  if (tracking) remains.tracked = tracking->finish();
  const Outcome outcome =
      write_result(folder.path(), remains, place, timing, 1e-9 * static_cast<double>(last.count()));
  if (recorded == Recorded::copied)
    std::filesystem::copy(recording, folder.path() / "recording", std::filesystem::copy_options::recursive);
  folder.commit();
  return outcome;
}

}  // namespace sim::bench
