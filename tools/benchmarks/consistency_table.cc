// Accuracy and consistency of the filter on a suite of walks, per scenario and over all of them, for any
// number of settings. Usage: consistency_table [--images-of RESULT] SUITE ["name: key=value ..."]... with a
// SUITE of scenarios/suites. Recordings come from the cache or are made first; --images-of gives the filter
// the images of another walk. Printed per scenario: the median over its seeds and the worst in parentheses;
// scale and NEES are means.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>

#include "sim/recording/recording.h"
#include "sim/regression/suite.h"
#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "sim/score/consistency.h"
#include "sim/score/metrics.h"
#include "sim/score/run.h"
#include "sim/score/statistics.h"
#include "sim/tracking/tracking.h"
#include "slam/vision/patch.h"

namespace {

using namespace sim;
using Nees = std::map<std::int64_t, std::vector<double>>;  // of the seeds at a time, ns

constexpr double kBeyond = 25;  // NEES of a landmark above which its position counts as wrong

/// A setting of the filter: changes "key=value" to the scenario.
struct Variant {
  std::string name;
  std::vector<std::string> changes;
};

/// Results of the seeds of one scenario under one variant.
struct Row {
  std::string name;
  std::map<std::string, std::vector<double>> values;
  Nees position, orientation;
  std::array<double, 2> inside{};  ///< of the frames, position and orientation, %
  std::vector<std::string> notes;
};

/// One recording, decoded.
struct RecordedWalk {
  explicit RecordedWalk(const std::filesystem::path& result_folder)
      : seed(scenario::read_scenario(result_folder / "scenario.yaml").scenario.seed),
        truth(recording::read_truth(result_folder / "recording")) {
    recording::RecordingReader reader(result_folder / "recording");
    setup = reader.setup();
    while (auto observation = reader.next()) observations.push_back(std::move(*observation));
  }

  std::uint64_t seed;
  recording::RecordingSetup setup;
  std::vector<slam::Observation> observations;
  recording::Truth truth;
};

/// The output of a shell command. Throws std::runtime_error if it fails.
std::string output_of(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), n);
  if (pclose(pipe) != 0) throw std::runtime_error("failed: " + command);
  return text;
}

/// Makes the recordings that the cache lacks; returns the result folders, one for each seed. They stand in
/// lines such as "seed 1: was in the cache, completed: FOLDER".
std::vector<std::filesystem::path> record(const regression::SuiteEntry& entry, const std::string& seeds) {
  std::string command = fmt::format("'{}' record '{}'", GAITSLAM_PROGRAM, entry.file.string());
  for (const std::string& change : entry.changes.overrides) command += " '" + change + "'";
  std::istringstream lines(output_of(command + " --seeds " + seeds));
  std::vector<std::filesystem::path> folders;
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(": /"); line.starts_with("seed ") && at != std::string::npos)
      folders.emplace_back(line.substr(at + 2));
  if (folders.empty()) throw std::runtime_error("no recording by " + command);
  return folders;
}

/// Adds the percentage of landmarks with a wrong position: measured to the surface at their first pixel, and
/// to any surface that their template shows.
void add_landmarks_beyond(const score::Run& run, Row& row) {
  const auto errors = score::landmark_errors(run, slam::kPatchHalf);
  std::array<double, 2> beyond{};
  for (const auto& error : errors) {
    beyond[0] += !error.nees || *error.nees > kBeyond;
    beyond[1] += !error.nees_of_template || *error.nees_of_template > kBeyond;
  }
  const double all = static_cast<double>(errors.size());
  row.values["beyond_percent"].push_back(100 * beyond[0] / all);
  row.values["beyond_template_percent"].push_back(100 * beyond[1] / all);
}

void add_nees(const score::Run& run, Row& row) {
  std::map<std::int64_t, const Eigen::Isometry3d*> truth;
  for (const auto& pose : run.truth_camera) truth[pose.t.count()] = &pose.X;
  for (const auto& estimate : *run.estimate) {
    const auto found = truth.find(estimate.t.count());
    if (found == truth.end() || !estimate.covariance || slam::seconds(estimate.t) < score::kSettled_s)
      continue;
    const auto nees = score::pose_nees(*found->second, estimate.X_WC, *estimate.covariance);
    if (!nees) continue;
    row.position[estimate.t.count()].push_back(nees->position);
    row.orientation[estimate.t.count()].push_back(nees->orientation);
  }
}

/// Replays the walk with the scenario's file under these changes, and adds its results.
void try_on(const RecordedWalk& walk, const std::filesystem::path& file, std::vector<std::string> changes,
            Row& row) {
  changes.push_back("seed=" + std::to_string(walk.seed));
  const scenario::ReadScenario read = scenario::read_scenario(file, {changes, {}});
  tracking::Tracking tracking(read.scenario, walk.setup.calibration, walk.setup.X_WC_start);
  const std::clock_t begin = std::clock();
  for (const slam::Observation& observation : walk.observations) tracking.process(observation);
  const double spent_ms = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const tracking::Tracked tracked = tracking.finish();
  const score::Run run =
      result::score_input({read, {scenario::Ending::completed}, walk.setup, walk.truth, tracked, ""});
  for (const auto& [name, metric] : score::evaluate(run))
    if (metric.value) row.values[name].push_back(*metric.value);
  row.values["filter_ms"].push_back(spent_ms / static_cast<double>(walk.observations.size()));
  add_landmarks_beyond(run, row);
  add_nees(run, row);
  for (const auto& faults : {tracked.losses(), tracked.suspicions()})
    for (const auto& fault : faults)
      row.notes.push_back(fmt::format("{}, seed {}, {:.1f} s: {}", row.name, walk.seed,
                                      slam::seconds(fault.from), fault.cause));
}

/// The share of the frames with the mean NEES of their seeds in its 95 % interval, %.
double frames_inside(const Nees& nees) {
  std::vector<std::vector<double>> moments;
  for (const auto& [t, squares] : nees) moments.push_back(squares);
  return 100 * score::band_fractions(moments, 3).value_or(score::BandFractions{}).inside;
}

void print(const std::string& name, const Row& row) {
  const auto values = [&](const char* metric) {
    const auto found = row.values.find(metric);
    return found == row.values.end() || found->second.empty() ? std::vector<double>{std::nan("")}
                                                              : found->second;
  };
  const auto mean = [&](const char* metric) { return score::mean(values(metric)); };
  const auto with_worst = [&](const char* metric, double middle, double factor, int digits) {
    const auto all = values(metric);
    return fmt::format("{:.{}f} ({:.{}f})", factor * middle, digits,
                       factor * *std::max_element(all.begin(), all.end()), digits);
  };
  const auto median_worst = [&](const char* metric, double factor, int digits) {
    return with_worst(metric, score::median(values(metric)), factor, digits);
  };
  const auto scale = values("scale_error_percent");
  const double sd = scale.size() > 1 ? score::standard_deviation(scale) : 0;
  fmt::print("{:<30}{:>15}{:>15}{:>15}{:>12}{:>15}{:>13}{:>13}{:>12}{:>11}{:>7.0f}{:>6.2f}\n", name,
             median_worst("ate_se3_rmse_m", 1e3, 1), median_worst("rmse_m", 1e3, 1),
             median_worst("end_position_error_m", 1e3, 1), median_worst("end_yaw_error_deg", 1, 2),
             fmt::format("{:+.2f} ({:.2f})", score::mean(scale), sd),
             with_worst("nees_position_mean", mean("nees_position_mean"), 1, 1),
             with_worst("nees_orientation_mean", mean("nees_orientation_mean"), 1, 1),
             fmt::format("{:.0f}, {:.0f}", row.inside[0], row.inside[1]),
             fmt::format("{:.1f}, {:.1f}", mean("beyond_percent"), mean("beyond_template_percent")),
             score::median(values("loop_landmarks")), score::median(values("filter_ms")));
}

void print(const Variant& variant, std::vector<Row>& rows) {
  if (!variant.name.empty()) fmt::print("== {}\n", variant.name);
  fmt::print("{:<30}{:>15}{:>15}{:>15}{:>12}{:>15}{:>13}{:>13}{:>12}{:>11}{:>7}{:>6}\n", "", "ATE mm",
             "rmse mm", "end mm", "yaw deg", "scale % (sd)", "NEES p", "NEES o", "in band p,o", "lm>25 %",
             "loop", "ms");
  Row all;
  for (Row& row : rows) {
    row.inside = {frames_inside(row.position), frames_inside(row.orientation)};
    print(row.name, row);
    for (const auto& [name, values] : row.values)
      all.values[name].insert(all.values[name].end(), values.begin(), values.end());
    for (std::size_t i = 0; i < 2; ++i) all.inside[i] += row.inside[i] / static_cast<double>(rows.size());
  }
  print("all", all);
  for (const Row& row : rows)
    for (const std::string& note : row.notes) fmt::print("  {}\n", note);
  std::fflush(stdout);
}

/// Reads "name: [key=value]...". Throws std::invalid_argument.
Variant read_variant(const std::string& line) {
  const std::size_t colon = line.find(':');
  if (colon == std::string::npos)
    throw std::invalid_argument("a variant is \"name: [key=value]...\", not \"" + line + "\"");
  Variant variant{line.substr(0, colon), {}};
  std::istringstream words{line.substr(colon + 1)};
  for (std::string word; words >> word;) variant.changes.push_back(word);
  return variant;
}

void work(std::vector<std::string> words) {
  std::vector<slam::Observation> images;  // of another walk, for the frames that it has
  if (words.size() > 1 && words[0] == "--images-of") {
    images = RecordedWalk(words[1]).observations;
    words.erase(words.begin(), words.begin() + 2);
  }
  if (words.empty() || words[0].starts_with("--"))
    throw std::invalid_argument("expected [--images-of RESULT] SUITE [\"name: key=value ...\"]...");
  std::vector<Variant> variants(words.size() == 1 ? 1 : 0);
  for (std::size_t i = 1; i < words.size(); ++i) variants.push_back(read_variant(words[i]));
  std::vector<std::vector<Row>> rows(variants.size());
  const auto suite = regression::read_suite(words[0]);
  for (const regression::SuiteEntry& entry : suite.entries) {
    const auto read = scenario::read_scenario(entry.file, entry.changes);
    for (auto& of_variant : rows) of_variant.push_back({read.scenario.name, {}, {}, {}, {}, {}});
    for (const auto& folder : record(entry, suite.seeds)) {
      RecordedWalk walk(folder);
      for (std::size_t i = 0; i < std::min(images.size(), walk.observations.size()); ++i)
        walk.observations[i].image = images[i].image;
      for (std::size_t v = 0; v < rows.size(); ++v) {
        std::vector<std::string> changes = entry.changes.overrides;
        changes.insert(changes.end(), variants[v].changes.begin(), variants[v].changes.end());
        try_on(walk, entry.file, changes, rows[v].back());
      }
    }
  }
  for (std::size_t v = 0; v < rows.size(); ++v) print(variants[v], rows[v]);
}

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 8 << 20);  // as the program does: the same bits
  try {
    work({argv + 1, argv + argc});
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "consistency_table: {}\n", e.what());
    return 2;
  }
}
