#include "sim/trials/tuning.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "sim/trials/search.h"

namespace sim::trials {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Records = std::vector<const TrialRecord*>;

/// Metrics in tune.json, at the start and at the best setting.
constexpr std::array kCompared{"ate_se3_rmse_m",         "rmse_m",          "nees_position_mean",
                               "nees_orientation_mean",  "nis_vision_mean", "nis_gyro_mean",
                               "nis_plan_velocity_mean", "nis_height_mean"};

/// The records of training or hold-out recordings with the start and with the best setting.
struct StartAndBest {
  std::vector<std::string> runs;
  Records start, best;
};

StartAndBest compare(const Runs& runs, const Spec& spec, const std::vector<double>& start,
                     const std::vector<double>& best, TrialLog& log) {
  StartAndBest both;
  runs.prefetch({start, best}, spec.parameters, log);
  for (std::size_t i = 0; i < runs.size(); ++i) both.runs.push_back(runs.name(i));
  both.start = runs.evaluate(spec.parameters, start, log);
  both.best = runs.evaluate(spec.parameters, best, log);
  return both;
}

ordered_json number_or_null(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json column(const Records& records,
                    const std::function<std::optional<double>(const TrialRecord&)>& of) {
  ordered_json all = ordered_json::array();
  for (const TrialRecord* record : records) all.push_back(number_or_null(of(*record)));
  return all;
}

ordered_json to_json(const StartAndBest& both, const Spec& spec) {
  ordered_json document{{"runs", both.runs}};
  const auto add = [&](const std::string& name, const auto& of) {
    document["values"][name] = {{"start", column(both.start, of)}, {"best", column(both.best, of)}};
  };
  add(std::string(name(spec.objective)),
      [&](const TrialRecord& r) -> std::optional<double> { return loss_of(r, spec.objective); });
  for (const std::string metric : kCompared)
    add(metric, [&](const TrialRecord& r) { return r.value(metric); });
  return document;
}

ordered_json parameters_json(const Spec& spec, const std::vector<double>& best) {
  ordered_json all = ordered_json::array();
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Range& p = spec.parameters[i];
    all.push_back({{"key", p.key},
                   {"also", p.also},
                   {"unit", scenario::unit_of(p.key)},
                   {"from", p.low},
                   {"to", p.high},
                   {"scale", p.logarithmic ? "log" : "linear"},
                   {"start", p.value_at(p.coordinate_of(p.start))},
                   {"best", p.value_at(best[i])}});
  }
  return all;
}

std::string history(const Study& study) {
  const Spec& spec = study.spec();
  std::string csv = "#setting,origin";
  for (const Range& p : spec.parameters) csv += "," + p.key;
  csv += fmt::format(",{}\n", name(spec.objective));
  int n = 0;
  for (const Candidate& c : study.candidates()) {
    csv += fmt::format("{},{}", n++, c.origin);
    for (std::size_t i = 0; i < c.point.size(); ++i)
      csv += fmt::format(",{}", spec.parameters[i].value_at(c.point[i]));
    csv += fmt::format(",{}\n", c.loss);
  }
  return csv;
}

std::string overlay(const Spec& spec, const std::vector<double>& best, const StartAndBest& holdout) {
  std::string yaml =
      fmt::format("# Tuned by {}. On {}:\n#   {} {:.6g} -> {:.6g} (less is better)\n", spec.name,
                  files::counted(holdout.runs.size(), "hold-out run"), name(spec.objective),
                  mean_loss(holdout.start, spec.objective), mean_loss(holdout.best, spec.objective));
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Range& p = spec.parameters[i];
    yaml += fmt::format("{}: {}\n", p.key, p.value_at(best[i]));
    for (const std::string& also : p.also) yaml += fmt::format("{}: {}\n", also, p.value_at(best[i]));
  }
  return yaml;
}

std::string result_text(const Spec& spec, const std::vector<double>& best, const StartAndBest& training,
                        const StartAndBest& holdout) {
  std::string text = spec.warning.empty() ? "" : "warning: " + spec.warning + "\n";
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Range& p = spec.parameters[i];
    text += fmt::format("{:<42} {:>10.4g} -> {:.4g}\n", p.key, p.start, p.value_at(best[i]));
  }
  for (const auto& [what, both] : {std::pair{"training", &training}, std::pair{"hold-out", &holdout}})
    text += fmt::format("{:<42} {:>10.4g} -> {:<10.4g}  mean of {}, less is better\n",
                        fmt::format("{} on {}", name(spec.objective), what),
                        mean_loss(both->start, spec.objective), mean_loss(both->best, spec.objective),
                        files::counted(both->runs.size(), "run"));
  return text;
}

/// The outcome of the search, kept after its recordings are released.
struct Found {
  std::vector<double> start, best;
  StartAndBest training;
  std::string history;
};

Found find(const Spec& spec, TrialLog& log, const Execution& execution,
           const std::function<void(const Progress&)>& on_progress) {
  const Runs runs(spec.training, execution);
  Progress progress{"search", 0, spec.trials, 0};
  Study study(spec, runs, log, [&](const Candidate& c) {
    if (progress.tried == 0 || c.loss < progress.best) progress.best = c.loss;
    ++progress.tried;
    on_progress(progress);
  });
  search(study);
  Found found;
  found.start = study.candidates().front().point;
  found.best = study.best().point;
  found.training = compare(runs, spec, found.start, found.best, log);
  found.history = history(study);
  return found;
}

std::string tune_json(const Spec& spec, const Found& found, const StartAndBest& holdout, bool accepted) {
  ordered_json document{{"format_version", 3},
                        {"name", spec.name},
                        {"objective", name(spec.objective)},
                        {"accepted", accepted},
                        {"parameters", parameters_json(spec, found.best)},
                        {"training", to_json(found.training, spec)},
                        {"holdout", to_json(holdout, spec)}};
  return files::json_text(document, 2) + "\n";
}

}  // namespace

std::string log_purpose(const std::string& program, const Spec& spec) {
  return fmt::format("gaitslam tune {}, {}", spec.name, program);
}

TuningResult tune(const Spec& spec, const fs::path& out, const Execution& execution,
                  const std::string& program, const std::function<void(const Progress&)>& on_progress) {
  fs::create_directories(out);
  TrialLog log(out / "trials.jsonl", log_purpose(program, spec));
  const Found found = find(spec, log, execution, on_progress);
  on_progress({"hold-out", 0, 0, 0});
  const Runs unseen(spec.holdout, execution);
  const StartAndBest holdout = compare(unseen, spec, found.start, found.best, log);
  const bool accepted = mean_loss(holdout.best, spec.objective) <= mean_loss(holdout.start, spec.objective);
  log.sort();
  files::write_atomically(out / "history.csv", found.history);
  files::write_atomically(out / "tune.json", tune_json(spec, found, holdout, accepted));
  if (accepted)
    files::write_atomically(out / "best.yaml", overlay(spec, found.best, holdout));
  else
    fs::remove(out / "best.yaml");
  return {accepted, result_text(spec, found.best, found.training, holdout)};
}

}  // namespace sim::trials
