// Accuracy and consistency of the filter on a suite of walks, per scenario and over all of them, for any
// number of settings. Usage: consistency_table [--images-of RESULT] SUITE ["name: key=value ..."]... with a
// SUITE of scenarios/suites. Recordings come from the cache or are made first; --images-of gives the filter
// the images of another walk. Printed per scenario: the median over its seeds and the worst in parentheses;
// scale, NEES, likelihood (the objective innovation_nll of tune), NIS and the correlation of successive
// innovations are means, the latter two for images, leg odometry and height.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <sstream>
#include <stdexcept>

#include "sim/files/text.h"
#include "sim/regression/suite.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"
#include "sim/score/trajectory.h"
#include "sim/trials/trial.h"
#include "slam/vision/patch.h"

namespace {

using namespace sim;

constexpr double kImage_px2 = 320 * 240;  // of all, so that their likelihoods can be compared
constexpr double kBeyond = 25;            // NEES of a landmark above which its position counts as wrong

/// A setting of the filter: changes "key=value" to the scenario.
struct Variant {
  std::string name;
  std::vector<std::string> changes;
};

/// Results of the seeds of one scenario under one variant.
struct Row {
  std::string name;
  std::map<std::string, std::vector<double>> values{};
  std::map<std::int64_t, std::vector<double>> position{}, orientation{};  ///< NEES of the seeds at a time, ns
  std::array<double, 2> inside{};  ///< of the frames, position and orientation, %
  std::vector<std::string> notes{};
};

/// Makes the recordings that the cache lacks; returns the result folders, one for each seed. They stand in
/// lines such as "seed 1: was in the cache, completed: FOLDER".
std::vector<std::string> record(const regression::SuiteEntry& entry, const std::string& seeds) {
  std::string command = files::shell_word(GAITSLAM_PROGRAM) + " record " + files::shell_word(entry.file);
  for (const std::string& change : entry.changes.overrides) command += " " + files::shell_word(change);
  FILE* const pipe = popen((command + " --seeds " + seeds).c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::vector<std::string> folders;
  for (std::array<char, 4096> line{}; std::fgets(line.data(), line.size(), pipe) != nullptr;)
    if (const std::string text(line.data()); text.starts_with("seed ") && text.find(": /") != text.npos)
      folders.push_back(text.substr(text.find(": /") + 2, text.find('\n') - text.find(": /") - 2));
  if (pclose(pipe) != 0 || folders.empty()) throw std::runtime_error("no recording by " + command);
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
    const auto nees = score::pose_nees(*found->second, estimate.X, *estimate.covariance);
    if (!nees) continue;
    row.position[estimate.t.count()].push_back(nees->position);
    row.orientation[estimate.t.count()].push_back(nees->orientation);
  }
}

/// Replays the recording with this scenario and adds the results.
void try_on(const trials::Recording& recording, const scenario::ReadScenario& read, Row& row) {
  const std::clock_t begin = std::clock();
  const result::RunRecord record = trials::replay(recording, read);
  const double spent_ms = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const score::Run run = result::score_input(record);
  for (const auto& [name, metric] : score::evaluate(run))
    if (metric.value) row.values[name].push_back(*metric.value);
  row.values["filter_ms"].push_back(spent_ms / static_cast<double>(recording.observations.size()));
  add_landmarks_beyond(run, row);
  if (const auto nll = trials::innovation_nll(*record.tracked, kImage_px2))
    row.values["innovation_nll"].push_back(*nll);
  add_nees(run, row);
  for (const auto& faults : {record.tracked->losses(), record.tracked->suspicions()})
    for (const auto& fault : faults)
      row.notes.push_back(fmt::format("{}, seed {}, {:.1f} s: {}", row.name, read.scenario.seed,
                                      slam::seconds(fault.from), fault.cause));
}

/// The share of the frames with the mean NEES of their seeds in its 95 % interval, %.
double frames_inside(const std::map<std::int64_t, std::vector<double>>& nees) {
  std::vector<std::vector<double>> moments;
  for (const auto& [t, squares] : nees) moments.push_back(squares);
  return 100 * score::band_fractions(moments, 3).value_or(score::BandFractions{}).inside;
}

std::vector<std::string> cells(const Row& row) {
  const auto values = [&](const char* metric) {
    const auto found = row.values.find(metric);
    return found == row.values.end() ? std::vector<double>{std::nan("")} : found->second;
  };
  const auto with_worst = [&](double middle, const char* metric, double factor, int digits) {
    const auto all = values(metric);
    return fmt::format("{:.{}f} ({:.{}f})", factor * middle, digits,
                       factor * *std::max_element(all.begin(), all.end()), digits);
  };
  const auto mean = [&](const char* metric) { return score::mean(values(metric)); };
  const auto median = [&](const char* metric) { return score::median(values(metric)); };
  const auto of_sensors = [&](std::string_view metric, std::string_view format) {
    std::vector<std::string> all;
    for (const char* sensor : {"vision", "plan_velocity", "height"})
      all.push_back(
          fmt::format(fmt::runtime(format), mean(fmt::format(fmt::runtime(metric), sensor).c_str())));
    return fmt::format("{}", fmt::join(all, " "));
  };
  return {row.name,
          with_worst(median("ate_se3_rmse_m"), "ate_se3_rmse_m", 1e3, 1),
          with_worst(median("rmse_m"), "rmse_m", 1e3, 1),
          with_worst(median("end_position_error_m"), "end_position_error_m", 1e3, 1),
          with_worst(median("end_yaw_error_deg"), "end_yaw_error_deg", 1, 2),
          fmt::format("{:+.2f} ({:.2f})", mean("scale_error_percent"),
                      score::standard_deviation(values("scale_error_percent"))),
          with_worst(mean("nees_position_mean"), "nees_position_mean", 1, 1),
          with_worst(mean("nees_orientation_mean"), "nees_orientation_mean", 1, 1),
          fmt::format("{:.0f}, {:.0f}", row.inside[0], row.inside[1]),
          fmt::format("{:.1f}, {:.1f}", mean("beyond_percent"), mean("beyond_template_percent")),
          fmt::format("{:.0f}", median("loop_landmarks")),
          fmt::format("{:.2f}", median("filter_ms")),
          fmt::format("{:.3f}", mean("innovation_nll")),
          of_sensors("nis_{}_mean", "{:.2f}"),
          of_sensors("innovation_lag1_{}", "{:+.2f}")};
}

void print(const Variant& variant, std::vector<Row>& rows) {
  if (!variant.name.empty()) fmt::print("== {}\n", variant.name);
  std::vector<std::vector<std::string>> table{{"", "ATE mm", "rmse mm", "end mm", "yaw deg", "scale % (sd)",
                                               "NEES p", "NEES o", "in band p,o", "lm>25 %", "loop", "ms",
                                               "likelihood", "NIS", "lag 1"}};
  Row all{"all"};
  for (Row& row : rows) {
    row.inside = {frames_inside(row.position), frames_inside(row.orientation)};
    table.push_back(cells(row));
    for (const auto& [name, values] : row.values)
      all.values[name].insert(all.values[name].end(), values.begin(), values.end());
    for (std::size_t i = 0; i < 2; ++i) all.inside[i] += row.inside[i] / static_cast<double>(rows.size());
    all.notes.insert(all.notes.end(), row.notes.begin(), row.notes.end());
  }
  table.push_back(cells(all));
  for (const std::vector<std::string>& line : table) {
    for (const std::string& cell : line) fmt::print("{:>{}}", cell, &cell == &line[0] ? 30 : 18);
    fmt::print("\n");
  }
  for (const std::string& note : all.notes) fmt::print("  {}\n", note);
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
  trials::Recording images;  // of another walk, for the frames that it has
  if (words.size() > 1 && words[0] == "--images-of") {
    images = trials::load(words[1]);
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
    for (auto& of_variant : rows) of_variant.push_back({read.scenario.name});
    for (const std::filesystem::path folder : record(entry, suite.seeds)) {
      trials::Recording walk = trials::load(folder);
      for (std::size_t i = 0; i < std::min(images.observations.size(), walk.observations.size()); ++i)
        walk.observations[i].image = images.observations[i].image;
      const auto seed = scenario::read_scenario(folder / "scenario.yaml").scenario.seed;
      for (std::size_t v = 0; v < rows.size(); ++v) {
        scenario::Changes changes = entry.changes;
        changes.overrides.insert(changes.overrides.end(), variants[v].changes.begin(),
                                 variants[v].changes.end());
        changes.overrides.push_back(fmt::format("seed={}", seed));
        try_on(walk, scenario::read_scenario(entry.file, changes), rows[v].back());
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
