#include "sim/pages/page_data.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/files/number.h"
#include "sim/files/printed_text.h"
#include "sim/pages/comparison_figures.h"
#include "sim/pages/pictures.h"
#include "sim/pages/run_figures.h"
#include "sim/pages/scene_data.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"

namespace sim::pages {
namespace {

using nlohmann::ordered_json;

constexpr int kPictures = 8;
constexpr std::size_t kInFull = 12;                     // runs
constexpr double kWide = 640, kHigh = 520, kLow = 300;  // px of an SVG in the page

ordered_json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  return files::parse_number<double>(fmt::format("{:.5g}", value)).value_or(0);
}

ordered_json rounded(const std::vector<double>& values) {
  ordered_json json = ordered_json::array();
  for (const double value : values) json.push_back(rounded(value));
  return json;
}

ordered_json definitions() {
  ordered_json json;
  for (const score::MetricDefinition& metric : score::metric_definitions())
    json[std::string(metric.name)] = metric.definition;
  return json;
}

struct Verdict {
  int exit_code = 0;
  std::string text;
};

Verdict verdict_of(const RunData& run, const scenario::Scenario& scenario) {
  const std::string ending = run.score.value("ending", "?");
  const auto named = scenario::ending_named(ending);
  if (!named || !result::is_allowed(scenario, *named)) return {3, ending};
  for (const auto& limit : run.score["limits"])
    if (limit["passed"] == false) return {1, "missed a limit"};
  return {0, "passed"};
}

ordered_json configuration(const RunData& run, const scenario::Scenario& scenario) {
  ordered_json rows = ordered_json::array();
  for (const auto& key : scenario::scenario_keys()) {
    if (!scenario::has_section(scenario, key.name)) continue;
    const auto set_by = run.about.set_by.find(key.name);
    rows.push_back({{"key", key.name},
                    {"value", key.print(scenario)},
                    {"unit", scenario::unit_of(key.name)},
                    {"origin", set_by == run.about.set_by.end() ? "default" : set_by->second}});
  }
  return rows;
}

ordered_json all(const std::vector<Figure>& figures) {
  ordered_json json = ordered_json::array();
  for (const Figure& figure : figures) json.push_back(to_json(figure));
  return json;
}

/// "by its yaw alignment": of a trajectory that the truth placed in the world.
std::string alignment_text(const RunData& run) {
  const std::string& by = run.about.alignment;
  if (by.empty()) return "";
  return by == "none"
             ? "Its trajectory was scored as it is, without alignment."
             : fmt::format(
                   "Its trajectory was aligned with the truth ({}) before it was scored, so that errors "
                   "are those that remain.",
                   by);
}

/// What the table of runs shows of every run.
ordered_json row_data(const RunData& run, const Verdict& verdict) {
  return {{"label", run.label},
          {"folder", run.folder.string()},
          {"scenario", run.score.value("scenario", "?")},
          {"verdict", verdict.text},
          {"exit_code", verdict.exit_code},
          {"score", run.score}};
}

ordered_json run_data(const RunData& run, bool in_full) {
  const scenario::Scenario scenario = scenario::read_scenario(run.folder / "scenario.yaml").scenario;
  const Verdict verdict = verdict_of(run, scenario);
  ordered_json json = row_data(run, verdict);
  if (!in_full) return json;
  json.update({{"cause", run.about.cause},
               {"counterfactual", run.about.counterfactual},
               {"alignment", alignment_text(run)},
               {"steered", run.waist_desired.has_value()},
               {"figures", all(run_figures(run))},
               {"has_estimate", run.errors.has_value()}});
  json["pictures"] = ordered_json::array();
  for (const Picture& picture : pictures(run, kPictures))
    json["pictures"].push_back({{"t", picture.t}, {"svg", picture.svg}});
  json["scene"] = run.map && run.errors ? scene_data(run) : ordered_json(nullptr);
  json["configuration"] = configuration(run, scenario);
  json["view"] = "tools/gaitslam view " + files::shell_word(run.folder.string());
  json["command"] = fmt::format("tools/gaitslam run {} --out DIR",
                                files::shell_word((run.folder / "scenario.yaml").string()));
  return json;
}

/// "tangent_circle, seed 1", or "tangent_circle, hall: 6 runs".
std::string title(const std::vector<RunData>& runs) {
  if (runs.size() == 1) return runs[0].label;
  std::vector<std::string> scenarios;
  for (const RunData& run : runs)
    if (const std::string name = run.score.value("scenario", "?");
        std::find(scenarios.begin(), scenarios.end(), name) == scenarios.end())
      scenarios.push_back(name);
  return fmt::format("{}: {}", fmt::join(scenarios, ", "), files::counted(runs.size(), "run"));
}

/// What a page of many runs shows in full: the first and the worst run of each scenario and estimator.
std::vector<bool> runs_in_full(const std::vector<RunData>& runs) {
  std::vector<bool> in_full(runs.size(), runs.size() <= kInFull);
  std::map<std::string, std::size_t> worst;  // by scenario and estimator
  const auto ate = [&](std::size_t i) { return runs[i].metric("ate_se3_rmse_m").value_or(INFINITY); };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string group =
        runs[i].score.value("scenario", "?") + "\n" + runs[i].score.value("estimator", "filter");
    const auto [found, is_first] = worst.emplace(group, i);
    if (is_first) in_full[i] = true;
    if (ate(i) > ate(found->second)) found->second = i;
  }
  for (const auto& [group, i] : worst) in_full[i] = true;
  return in_full;
}

std::string subtitle(const RunData& run) {
  const auto known = [](const std::string& text) { return text.empty() ? "?" : text; };
  return fmt::format("{} {}, revision {}", known(run.about.program), known(run.about.version),
                     known(run.about.revision));
}

}  // namespace

ordered_json to_json(const Figure& figure) {
  ordered_json json{{"name", figure.name}, {"title", figure.title}};
  if (!figure.runs.empty()) json["runs"] = figure.runs;
  if (figure.is_still()) {
    json["svg"] = to_svg(figure, kWide, figure.equal_axes ? kHigh : kLow);
    return json;
  }
  json.update({{"x_label", figure.x_label},
               {"y_label", figure.y_label},
               {"logarithmic", figure.logarithmic},
               {"whole_x", figure.whole_x},
               {"whole_y", figure.whole_y}});
  for (const char* list : {"lines", "envelopes", "levels", "moments"}) json[list] = ordered_json::array();
  for (const Line& line : figure.lines)
    json["lines"].push_back({{"name", line.name},
                             {"role", role_name(line.role)},
                             {"x", rounded(line.x)},
                             {"y", rounded(line.y)},
                             {"dots", line.dots}});
  for (const Envelope& e : figure.envelopes)
    json["envelopes"].push_back({{"name", e.name},
                                 {"role", role_name(e.role)},
                                 {"x", rounded(e.x)},
                                 {"low", rounded(e.low)},
                                 {"high", rounded(e.high)}});
  for (const Level& level : figure.levels) json["levels"].push_back({{"name", level.name}, {"y", level.y}});
  for (const Moment& moment : figure.moments)
    json["moments"].push_back({{"name", moment.name}, {"x", moment.x}});
  return json;
}

ordered_json page_data(const std::vector<RunData>& runs) {
  ordered_json json{{"title", title(runs)},
                    {"subtitle", subtitle(runs[0])},
                    {"definitions", definitions()},
                    {"figures", all(comparison_figures(runs))},
                    {"runs", ordered_json::array()}};
  const std::vector<bool> in_full = runs_in_full(runs);
  for (std::size_t i = 0; i < runs.size(); ++i) json["runs"].push_back(run_data(runs[i], in_full[i]));
  return json;
}

}  // namespace sim::pages
