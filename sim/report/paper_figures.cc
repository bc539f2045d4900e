#include <cmath>
#include <optional>

#include "sim/report/paper.h"

namespace sim::report {
namespace {

const RunData* first(const PaperRuns& all, const std::string& experiment) {
  const auto found = all.find(experiment);
  return found == all.end() || found->second.empty() ? nullptr : &found->second.front();
}

Figure from_above(const std::string& name, const std::string& title) {
  Figure f{name, title, "x [m]", "y [m]"};
  f.equal_axes = true;
  return f;
}

Figure waist(const RunData& run) {
  Figure f = from_above("figure_1", "Figure 1: waist as planned and as walked while turning");
  f.lines = {{"plan", Role::plan, run.waist_plan.x, run.waist_plan.y},
             {"walked", Role::truth, run.waist_truth.x, run.waist_truth.y}};
  return f;
}

Figure slam(const RunData& run, const std::string& name, const std::string& title) {
  Figure f = from_above(name, title);
  f.lines = {{"plan", Role::plan, run.plan.x, run.plan.y}, {"truth", Role::truth, run.truth.x, run.truth.y}};
  if (run.estimate) f.lines.push_back({"SLAM", Role::estimate, run.estimate->x, run.estimate->y});
  return f;
}

Figure uncertainty(const RunData& run) {
  Figure f{"figure_4", "Figure 4: uncertainty of the position, vision and gyro alone", "time [s]", "m"};
  Line sigma{"3 sigma", Role::first, run.errors->t},
      error{"error", Role::estimate, run.errors->t, run.errors->distance};
  for (std::size_t i = 0; i < run.errors->t.size(); ++i)
    sigma.y.push_back(3 * std::hypot(run.errors->sigma_x[i], run.errors->sigma_y[i], run.errors->sigma_z[i]));
  f.lines = {sigma, error};
  if (const auto closed = run.metric("loop_time_s")) f.moments = {{"loop closed", *closed}};
  return f;
}

Figure height(const RunData& run) {
  Figure f{"figure_8", "Figure 8: height of the camera, experiment 1", "time [s]", "z [m]"};
  f.lines = {{"plan", Role::plan, run.plan.t, run.plan.z}, {"truth", Role::truth, run.truth.t, run.truth.z}};
  if (run.estimate) f.lines.push_back({"SLAM", Role::estimate, run.estimate->t, run.estimate->z});
  return f;
}

}  // namespace

std::vector<Figure> paper_figures(const PaperRuns& all) {
  std::vector<Figure> figures;
  const RunData* tangent = first(all, "tangent_circle");
  if (tangent) figures.push_back(waist(*tangent));
  const RunData* known = first(all, "vision_gyro_known_landmarks");
  if (known && known->errors) figures.push_back(uncertainty(*known));
  if (tangent) figures.push_back(slam(*tangent, "figure_6", "Figure 6: plan and SLAM, tangent circle"));
  if (const RunData* run = first(all, "perpendicular_circle"))
    figures.push_back(slam(*run, "figure_7", "Figure 7: plan and SLAM, circle walked facing its centre"));
  if (tangent) figures.push_back(height(*tangent));
  return figures;
}

}  // namespace sim::report
