#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/pages/paper.h"
#include "sim/pages/run_figures.h"

namespace sim::pages {
namespace {

const RunData* first(const PaperRuns& all, const std::string& experiment) {
  const auto& runs = runs_of(all, experiment);
  return runs.empty() ? nullptr : &runs.front();
}

// The first run that closed its loop, or the first run.
const RunData* first_closed(const PaperRuns& all, const std::string& experiment) {
  const auto& runs = runs_of(all, experiment);
  const auto closed = std::find_if(runs.begin(), runs.end(),
                                   [](const RunData& run) { return run.metric("loop_time_s").has_value(); });
  return closed != runs.end() ? &*closed : first(all, experiment);
}

Figure renamed(Figure figure, const std::string& name, const std::string& title, const RunData& run) {
  figure.name = name;
  figure.title = fmt::format("{} (seed {})", title, run.seed);
  return figure;
}

Figure uncertainty(const RunData& run) {
  Figure f{"figure_4",
           fmt::format("Figure 4: the position's uncertainty grows until the loop closes; vision and gyro "
                       "(seed {})",
                       run.seed),
           "time [s]", "mm"};
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

void add_walks(std::vector<Figure>& figures, const PaperRuns& all) {
  if (const RunData* run = first(all, "tangent_quadrant"))
    figures.push_back(renamed(waist_from_above(*run), "figure_1",
                              "Figure 1: waist, planned and walked, a tangent quadrant", *run));
  if (const RunData* run = first(all, "perpendicular_circle_trial1"))
    figures.push_back(renamed(waist_from_above(*run), "figure_1_circle",
                              "Figure 1: waist, planned and walked, facing the center, first trial", *run));
}

void add_slam(std::vector<Figure>& figures, const PaperRuns& all) {
  if (const RunData* run = first_closed(all, "tangent_circle_paper"))
    figures.push_back(renamed(camera_from_above(*run), "figure_6_paper",
                              "Figure 6: plan and SLAM, experiment 1, the paper's filter", *run));
  if (const RunData* run = first(all, "tangent_circle"))
    figures.push_back(
        renamed(camera_from_above(*run), "figure_6", "Figure 6: the same walk, this bench's filter", *run));
  if (const RunData* run = first_closed(all, "perpendicular_circle_paper"))
    figures.push_back(renamed(camera_from_above(*run), "figure_7_paper",
                              "Figure 7: plan and SLAM, experiment 2, the paper's filter", *run));
  if (const RunData* run = first(all, "perpendicular_circle"))
    figures.push_back(
        renamed(camera_from_above(*run), "figure_7", "Figure 7: experiment 2, this bench's filter", *run));
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
  Figure f{"figure_3", "Figure 3: depth hypotheses of a new landmark collapse to a peak", "depth [m]",
           "probability of a hypothesis"};
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
  add_walks(figures, all);
  const RunData* paper = first_closed(all, "tangent_circle_paper");
  if (paper && std::filesystem::exists(paper->folder / "depths.csv"))
    figures.push_back(depths_figure(paper->folder / "depths.csv"));
  const RunData* known = first_closed(all, "vision_gyro_known_landmarks");
  if (known && known->errors) figures.push_back(uncertainty(*known));
  add_slam(figures, all);
  if (paper)
    figures.push_back(renamed(camera_height(*paper), "figure_8",
                              "Figure 8: height of the camera in experiment 1, the paper's filter", *paper));
  figures.push_back(impact_figure(runs_of(all, "tangent_circle_paper")));
  std::erase_if(figures, [](const Figure& figure) { return figure.lines.empty(); });
  return figures;
}

}  // namespace sim::pages
