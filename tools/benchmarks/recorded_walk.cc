#include "tools/benchmarks/recorded_walk.h"

#include <time.h>

#include <sstream>
#include <stdexcept>

#include "sim/bench/evidence.h"
#include "sim/bench/scenario.h"

namespace {

using slam::Observation;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

const Eigen::Isometry3d& true_pose(const RecordedWalk& walk, std::size_t frame) {
  return walk.truth.camera.at(frame).X;
}

double path_length(const RecordedWalk& walk, const auto& pose_at) {
  double sum = 0;  // over half seconds, so that swaying hardly counts
  constexpr std::size_t kApart = 48;
  for (std::size_t i = kApart; i < walk.observations.size(); i += kApart)
    sum += (pose_at(i).translation() - pose_at(i - kApart).translation()).template head<2>().norm();
  return sum;
}

/// Strides as planned, but by the factor that makes their sum true.
void tell_speed(const RecordedWalk& walk, std::vector<Observation>& observations) {
  const auto planned = [&](std::size_t i) { return walk.observations[i].plan->X_PC; };
  const auto walked = [&](std::size_t i) { return true_pose(walk, i); };
  const double factor = path_length(walk, walked) / path_length(walk, planned);
  const Eigen::Vector3d start = walk.observations.front().plan->X_PC.translation();
  for (Observation& o : observations) {
    const Eigen::Vector3d moved = o.plan->X_PC.translation() - start;
    o.plan->X_PC.translation().head<2>() = (start + factor * moved).head<2>();
  }
}

/// The plan of a robot that walked just so.
void tell_strides(const RecordedWalk& walk, std::vector<Observation>& observations) {
  for (std::size_t i = 0; i < observations.size(); ++i) observations[i].plan->X_PC = true_pose(walk, i);
}

std::vector<Observation> told(const RecordedWalk& walk, const std::string& truth) {
  std::vector<Observation> observations = walk.observations;
  if (truth == "speed") tell_speed(walk, observations);
  if (truth == "strides") tell_strides(walk, observations);
  return observations;
}

}  // namespace

RecordedWalk::RecordedWalk(const std::filesystem::path& result_folder)
    : folder(result_folder), truth(sim::stream::read_truth(result_folder / "recording")) {
  sim::stream::RecordingReader reader(result_folder / "recording");
  setup = reader.setup();
  while (auto observation = reader.next()) observations.push_back(std::move(*observation));
}

Variant read_variant(std::string_view line) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos)
    throw std::invalid_argument("a variant is \"name: [key=value]...\", not \"" + std::string(line) + "\"");
  Variant variant{std::string(line.substr(0, colon)), {}, {}, {}};
  std::istringstream words{std::string(line.substr(colon + 1))};
  for (std::string word; words >> word;) {
    if (word.starts_with("scenario="))
      variant.scenario = word.substr(9);
    else if (word.starts_with("truth="))
      variant.truth = word.substr(6);
    else
      variant.changes.push_back(word);
  }
  if (!variant.truth.empty() && variant.truth != "speed" && variant.truth != "strides")
    throw std::invalid_argument("truth=" + variant.truth + ": expected speed or strides");
  return variant;
}

Trial try_on(const RecordedWalk& walk, const Variant& variant) {
  using namespace sim;
  const auto own = walk.folder / "scenario.yaml";
  bench::Changes changes{variant.changes, {}};
  changes.overrides.insert(changes.overrides.begin(),
                           "seed=" + std::to_string(bench::read_scenario(own).scenario.seed));
  const bench::ReadScenario read =
      bench::read_scenario(variant.scenario.empty() ? own : std::filesystem::path(variant.scenario), changes);
  bench::Tracking tracking(read.scenario, walk.setup.calibration, walk.setup.X_WC_start);
  double spent_ms = 0;
  for (const Observation& observation : told(walk, variant.truth)) {
    const double begin = cpu_ms();
    tracking.take(observation);
    spent_ms += cpu_ms() - begin;
  }
  Trial trial;
  trial.tracked = tracking.finish();
  trial.filter_ms = spent_ms / static_cast<double>(walk.observations.size());
  trial.run = bench::evidence({read, "completed", "", walk.setup, walk.truth, trial.tracked, ""});
  trial.metrics = score::evaluate(trial.run);
  return trial;
}
