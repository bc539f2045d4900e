// Accuracy and consistency of the filter on a suite of walks, per scenario and over all of them, for any
// number of settings. Usage: consistency_table [--images-of RESULT] SUITE ["name: key=value ..."]... with a
// SUITE of scenarios/suites. Recordings come from the cache or are made first; --images-of gives the filter
// the images of another walk. Printed per scenario: the median over its seeds and the worst in parentheses;
// scale and NEES are means.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>

#include "sim/score/consistency.h"
#include "sim/score/landmarks.h"
#include "sim/score/statistics.h"
#include "slam/vision/patch.h"
#include "tools/benchmarks/recorded_walks.h"

namespace {

constexpr double kBeyond = 25;  // NEES of a landmark above which its position counts as wrong

/// Results of the seeds of one scenario under one variant.
struct Row {
  std::string name;
  std::map<std::string, std::vector<double>> values;
  std::map<std::int64_t, std::vector<double>> position, orientation;  // NEES of the seeds at a time, ns
  std::vector<std::string> notes;
};

/// Percentage of landmarks with a wrong position: measured to the surface at their first pixel, and to any
/// surface that their template shows.
std::array<double, 2> landmarks_beyond(const sim::score::Run& run) {
  const auto errors = sim::score::landmark_errors(run.map, run.landmarks, run.truth_camera, run.surfaces,
                                                  run.camera, slam::kPatchHalf);
  std::array<double, 2> beyond{};
  for (const auto& error : errors) {
    beyond[0] += !error.nees || *error.nees > kBeyond;
    beyond[1] += !error.nees_of_template || *error.nees_of_template > kBeyond;
  }
  const double all = static_cast<double>(errors.size());
  return {100 * beyond[0] / all, 100 * beyond[1] / all};
}

void add_nees(const sim::score::Run& run, Row& row) {
  std::map<std::int64_t, const Eigen::Isometry3d*> truth;
  for (const auto& pose : run.truth_camera) truth[pose.t.count()] = &pose.X;
  for (const auto& estimate : *run.estimate) {
    const auto found = truth.find(estimate.t.count());
    if (found == truth.end() || !estimate.covariance ||
        1e-9 * static_cast<double>(estimate.t.count()) < sim::score::kSettled_s)
      continue;
    const auto nees = sim::score::pose_nees(*found->second, estimate.X_WC, *estimate.covariance);
    if (!nees) continue;
    row.position[estimate.t.count()].push_back(nees->position);
    row.orientation[estimate.t.count()].push_back(nees->orientation);
  }
}

void add(const Trial& trial, std::uint64_t seed, Row& row) {
  for (const auto& [name, metric] : trial.metrics)
    if (metric.value) row.values[name].push_back(*metric.value);
  const auto beyond = landmarks_beyond(trial.run);
  row.values["beyond_percent"].push_back(beyond[0]);
  row.values["beyond_template_percent"].push_back(beyond[1]);
  row.values["filter_ms"].push_back(trial.filter_ms);
  add_nees(trial.run, row);
  const auto note = [&](const auto& faults) {
    for (const auto& fault : faults)
      row.notes.push_back(
          fmt::format("{}, seed {}, {:.1f} s: {}", row.name, seed, slam::seconds(fault.from), fault.cause));
  };
  note(trial.tracked.losses());
  note(trial.tracked.suspicions());
}

std::vector<double> moments_inside(const std::map<std::int64_t, std::vector<double>>& nees) {
  std::vector<std::vector<double>> moments;
  for (const auto& [t, squares] : nees) moments.push_back(squares);
  const auto share = sim::score::band_fractions(moments, 3).value_or(sim::score::BandFractions{});
  return {100 * share.inside, 100 * share.below};
}

void print_header() {
  fmt::print("{:<30}{:>15}{:>15}{:>15}{:>12}{:>15}{:>13}{:>13}{:>12}{:>11}{:>7}{:>6}\n", "", "ATE mm",
             "rmse mm", "end mm", "yaw deg", "scale % (sd)", "NEES p", "NEES o", "in band p,o", "lm>25 %",
             "loop", "ms");
}

/// inside: of the frames, position and orientation, %.
void print(const std::string& name, const Row& row, const std::array<double, 2>& inside) {
  const auto values = [&](const char* metric) {
    const auto found = row.values.find(metric);
    return found == row.values.end() || found->second.empty() ? std::vector<double>{std::nan("")}
                                                              : found->second;
  };
  const auto median_worst = [&](const char* metric, double factor, int digits) {
    const auto all = values(metric);
    return fmt::format("{:.{}f} ({:.{}f})", factor * sim::score::median(all), digits,
                       factor * *std::max_element(all.begin(), all.end()), digits);
  };
  const auto mean_worst = [&](const char* metric) {
    const auto all = values(metric);
    return fmt::format("{:.1f} ({:.1f})", sim::score::mean(all), *std::max_element(all.begin(), all.end()));
  };
  const auto scale = values("scale_error_percent");
  const double sd = scale.size() > 1 ? sim::score::standard_deviation(scale) : 0;
  fmt::print("{:<30}{:>15}{:>15}{:>15}{:>12}{:>15}{:>13}{:>13}{:>12}{:>11}{:>7.0f}{:>6.2f}\n", name,
             median_worst("ate_se3_rmse_m", 1e3, 1), median_worst("rmse_m", 1e3, 1),
             median_worst("end_position_error_m", 1e3, 1), median_worst("end_yaw_error_deg", 1, 2),
             fmt::format("{:+.2f} ({:.2f})", sim::score::mean(scale), sd), mean_worst("nees_position_mean"),
             mean_worst("nees_orientation_mean"), fmt::format("{:.0f}, {:.0f}", inside[0], inside[1]),
             fmt::format("{:.1f}, {:.1f}", sim::score::mean(values("beyond_percent")),
                         sim::score::mean(values("beyond_template_percent"))),
             sim::score::median(values("loop_landmarks")), sim::score::median(values("filter_ms")));
}

void print(const Variant& variant, const std::vector<Row>& rows) {
  if (!variant.name.empty()) fmt::print("== {}\n", variant.name);
  print_header();
  Row all;
  std::array<double, 2> mean_inside{0, 0};
  for (const Row& row : rows) {
    const std::array<double, 2> inside{moments_inside(row.position)[0], moments_inside(row.orientation)[0]};
    print(row.name, row, inside);
    for (const auto& [name, values] : row.values)
      all.values[name].insert(all.values[name].end(), values.begin(), values.end());
    for (std::size_t i = 0; i < inside.size(); ++i)
      mean_inside[i] += inside[i] / static_cast<double>(rows.size());
  }
  print("all", all, mean_inside);
  for (const Row& row : rows)
    for (const std::string& note : row.notes) fmt::print("  {}\n", note);
  std::fflush(stdout);
}

struct Arguments {
  std::string images_of, suite;
  std::vector<Variant> variants;
};

Arguments read_arguments(std::vector<std::string> words) {
  Arguments arguments;
  if (words.size() > 1 && words[0] == "--images-of") {
    arguments.images_of = words[1];
    words.erase(words.begin(), words.begin() + 2);
  }
  if (words.empty() || words[0].starts_with("--"))
    throw std::invalid_argument("expected [--images-of RESULT] SUITE [\"name: key=value ...\"]...");
  arguments.suite = words[0];
  for (std::size_t i = 1; i < words.size(); ++i) arguments.variants.push_back(read_variant(words[i]));
  if (arguments.variants.empty()) arguments.variants.push_back({});
  return arguments;
}

void work(const Arguments& arguments) {
  std::vector<std::vector<Row>> rows(arguments.variants.size());
  const auto suite = sim::regression::read_suite(arguments.suite);
  for (const RecordedEntry& entry : record_suite(suite, GAITSLAM_PROGRAM)) {
    for (auto& of_variant : rows) of_variant.push_back({entry.name, {}, {}, {}, {}});
    for (const auto& folder : entry.folders) {
      RecordedWalk walk(folder);
      if (!arguments.images_of.empty()) walk.take_images_of(RecordedWalk(arguments.images_of));
      for (std::size_t v = 0; v < rows.size(); ++v) {
        std::vector<std::string> changes = entry.changes;
        changes.insert(changes.end(), arguments.variants[v].changes.begin(),
                       arguments.variants[v].changes.end());
        add(try_on(walk, entry.scenario, changes), walk.seed, rows[v].back());
      }
    }
  }
  for (std::size_t v = 0; v < rows.size(); ++v) print(arguments.variants[v], rows[v]);
}

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 8 << 20);  // as the program does: the same bits
  try {
    work(read_arguments({argv + 1, argv + argc}));
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "consistency_table: {}\n", e.what());
    return 2;
  }
}
