#include "sim/pages/paper_figures.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sim/pages/paper_depths.h"
#include "sim/pages/paper_height.h"
#include "sim/pages/run_figures.h"
#include "sim/pages/units.h"

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
  figure.title = fmt::format("{} (seed {})", title, run.score.value("seed", 0ULL));
  return figure;
}

Figure uncertainty(const RunData& run) {
  Figure f{"figure_4",
           fmt::format("Figure 4: the position's uncertainty grows until the loop closes; vision and gyro "
                       "(seed {})",
                       run.score.value("seed", 0ULL)),
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
                              "Figure 1: waist, planned and walked, facing the centre, first trial", *run));
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

}  // namespace

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
