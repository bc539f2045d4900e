#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/pages/paper.h"
#include "sim/pages/run_figures.h"

namespace sim::pages {
namespace {

Figure uncertainty(const RunData& run) {
  Figure f{"", "", "time [s]", "mm"};
  if (!run.errors) return f;
  const Errors& e = *run.errors;
  Line sigma{"3 sigma", Role::first, e.t}, error{"error", Role::estimate, e.t};
  for (std::size_t i = 0; i < e.t.size(); ++i) {
    sigma.y.push_back(3 * kMm * std::hypot(e.sigma_x[i], e.sigma_y[i], e.sigma_z[i]));
    error.y.push_back(kMm * e.distance[i]);
  }
  f.lines = {sigma, error};
  if (const auto closed = run.metric("loop_time_s")) f.moments = {{"loop closed", *closed}};
  return f;
}

Figure depths(const RunData& run) {
  const auto file = run.folder / "depths.csv";
  return std::filesystem::exists(file) ? depths_figure(file) : Figure{};
}

/// A figure of the paper, drawn from the first run of an experiment, or from the first that closed its loop.
struct PaperFigure {
  const char *name, *title, *experiment;
  Figure (*draw)(const RunData& run);
  bool closed = false;
};

constexpr PaperFigure kFigures[]{
    {"figure_1", "Figure 1: waist, planned and walked, a tangent quadrant", "tangent_quadrant",
     waist_from_above},
    {"figure_1_circle", "Figure 1: waist, planned and walked, facing the center, first trial",
     "perpendicular_circle_trial1", waist_from_above},
    {"figure_3", "Figure 3: depth hypotheses of a new landmark collapse to a peak", "tangent_circle_paper",
     depths, true},
    {"figure_4", "Figure 4: uncertainty of the position until the loop closes; vision and gyro",
     "vision_gyro_known_landmarks", uncertainty, true},
    {"figure_6_paper", "Figure 6: plan and SLAM, experiment 1, the paper's filter", "tangent_circle_paper",
     camera_from_above, true},
    {"figure_6", "Figure 6: the same walk, this bench's filter", "tangent_circle", camera_from_above},
    {"figure_7_paper", "Figure 7: plan and SLAM, experiment 2, the paper's filter",
     "perpendicular_circle_paper", camera_from_above, true},
    {"figure_7", "Figure 7: experiment 2, this bench's filter", "perpendicular_circle", camera_from_above},
    {"figure_8", "Figure 8: height of the camera in experiment 1, the paper's filter", "tangent_circle_paper",
     camera_height, true}};

const RunData* run_of(const PaperFigure& figure, const PaperRuns& all) {
  const std::vector<RunData>& runs = runs_of(all, figure.experiment);
  for (const RunData& run : runs)
    if (!figure.closed || run.metric("loop_time_s")) return &run;
  return runs.empty() ? nullptr : &runs.front();
}

constexpr double kKnown = 0.3;  // standard deviation by mean: Davison 2003

struct Hypotheses {
  Column depth, probability;
};

// By landmark and time.
using History = std::map<double, Hypotheses>;

std::map<double, History> read(const std::filesystem::path& file) {
  const Table table(file);
  const Column t = table.seconds("timestamp"), landmark = table.numbers("landmark"),
               depth = table.numbers("depth"), probability = table.numbers("probability");
  std::map<double, History> all;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Hypotheses& at = all[landmark[i]][t[i]];
    at.depth.push_back(depth[i]);
    at.probability.push_back(probability[i]);
  }
  return all;
}

double relative_sigma(const Hypotheses& h) {
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < h.depth.size(); ++i) {
    mean += h.probability[i] * h.depth[i];
    square += h.probability[i] * h.depth[i] * h.depth[i];
  }
  return std::sqrt(std::max(0.0, square - mean * mean)) / mean;
}

}  // namespace

Figure depths_figure(const std::filesystem::path& depths_csv) {
  Figure f{"", "", "depth [m]", "probability of a hypothesis"};
  const History* longest = nullptr;
  const auto all = read(depths_csv);
  for (const auto& [landmark, history] : all)
    if (relative_sigma(history.rbegin()->second) < kKnown && (!longest || history.size() > longest->size()))
      longest = &history;
  if (!longest) return f;
  constexpr Role kRoles[] = {Role::third, Role::second, Role::first, Role::estimate};
  const std::size_t last = longest->size() - 1;
  for (std::size_t k = 0; k < std::size(kRoles); ++k) {
    const std::size_t image = k * last / (std::size(kRoles) - 1);
    const Hypotheses& h = std::next(longest->begin(), static_cast<std::ptrdiff_t>(image))->second;
    f.lines.push_back({fmt::format("after {} image{}", image + 1, image == 0 ? "" : "s"), kRoles[k], h.depth,
                       h.probability});
  }
  return f;
}

std::vector<Figure> paper_figures(const PaperRuns& all) {
  std::vector<Figure> figures;
  for (const PaperFigure& figure : kFigures) {
    const RunData* const run = run_of(figure, all);
    Figure drawn = run ? figure.draw(*run) : Figure{};
    if (drawn.lines.empty()) continue;
    drawn.name = figure.name;
    drawn.title = fmt::format("{} (seed {})", figure.title, run->seed);
    figures.push_back(std::move(drawn));
  }
  return figures;
}

}  // namespace sim::pages
