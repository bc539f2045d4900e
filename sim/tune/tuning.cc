#include "sim/tune/tuning.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "sim/bench/scenario_keys.h"
#include "sim/stream/durable_file.h"
#include "sim/tune/optimise.h"
#include "sim/tune/profile.h"

namespace sim::tune {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Records = std::vector<const TrialRecord*>;

/// What is shown of start and best, side by side.
constexpr std::array kCompared{"ate_se3_rmse_m",         "rmse_m",          "nees_position_mean",
                               "nees_orientation_mean",  "nis_vision_mean", "nis_gyro_mean",
                               "nis_plan_velocity_mean", "nis_height_mean"};

/// One side, training or hold-out: every run with the values of the start and with the best ones.
struct Side {
  std::vector<std::string> runs;
  Records start, best;
};

std::vector<std::size_t> all_of(std::size_t count) {
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

double mean(const Records& records, Objective objective) {
  return mean_value(records, all_of(records.size()), objective);
}

bool errors_are_tuned(const Spec& spec) {
  return std::any_of(spec.parameters.begin(), spec.parameters.end(), [](const Parameter& p) {
    return p.key.starts_with("errors.") || std::any_of(p.also.begin(), p.also.end(), [](const auto& key) {
             return key.starts_with("errors.");
           });
  });
}

Side side_of(const Runs& runs, const Spec& spec, const std::vector<double>& start,
             const std::vector<double>& best, TrialLog& log) {
  Side side;
  runs.expect({start, best}, spec.parameters, log);
  for (std::size_t i = 0; i < runs.size(); ++i) side.runs.push_back(runs.name(i));
  side.start = runs.try_on(all_of(runs.size()), spec.parameters, start, log);
  side.best = runs.try_on(all_of(runs.size()), spec.parameters, best, log);
  return side;
}

ordered_json column(const Records& records,
                    const std::function<std::optional<double>(const TrialRecord&)>& of) {
  ordered_json all = ordered_json::array();
  for (const TrialRecord* record : records) {
    const auto value = of(*record);
    all.push_back(value ? ordered_json(*value) : ordered_json(nullptr));
  }
  return all;
}

ordered_json to_json(const Side& side, const Spec& spec) {
  ordered_json json{{"runs", side.runs}};
  const auto add = [&](const std::string& name, const auto& of) {
    json["values"][name] = {{"start", column(side.start, of)}, {"best", column(side.best, of)}};
  };
  for (const Objective objective : spec.objectives)
    add(std::string(name(objective)),
        [&](const TrialRecord& r) -> std::optional<double> { return value_of(r, objective); });
  for (const std::string metric : kCompared)
    add(metric, [&](const TrialRecord& r) -> std::optional<double> {
      const auto found = r.values.find(metric);
      return found == r.values.end() ? std::nullopt : std::optional(found->second);
    });
  return json;
}

ordered_json to_json(const Profile& profile) {
  const auto end = [](const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
  };
  return {{"key", profile.key},
          {"at", profile.at},
          {"rises", profile.rises},
          {"threshold", std::isfinite(profile.threshold) ? ordered_json(profile.threshold) : ordered_json()},
          {"low", end(profile.low)},
          {"high", end(profile.high)},
          {"identifiable", profile.identifiable()}};
}

ordered_json parameters_json(const Spec& spec, const std::vector<double>& best) {
  ordered_json all = ordered_json::array();
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Parameter& p = spec.parameters[i];
    all.push_back({{"key", p.key},
                   {"also", p.also},
                   {"unit", bench::unit_of(p.key)},
                   {"from", p.low},
                   {"to", p.high},
                   {"scale", p.logarithmic ? "log" : "linear"},
                   {"start", p.at(p.part_of(p.start))},
                   {"best", p.at(best[i])}});
  }
  return all;
}

std::string history(const Study& study) {
  const Spec& spec = study.spec();
  std::string csv = "#setting,origin,complete";
  for (const Parameter& p : spec.parameters) csv += "," + p.key;
  for (const Objective objective : spec.objectives) csv += fmt::format(",{}", name(objective));
  csv += '\n';
  int n = 0;
  for (const Candidate& c : study.candidates()) {
    csv += fmt::format("{},{},{}", n++, c.origin, c.complete() ? 1 : 0);
    for (std::size_t i = 0; i < c.parts.size(); ++i)
      csv += fmt::format(",{}", spec.parameters[i].at(c.parts[i]));
    for (const double value : c.values) csv += fmt::format(",{}", value);
    csv += '\n';
  }
  return csv;
}

/// Worse than the start on recordings that the search has not seen: in the objective, or in both.
bool worse(const Side& holdout, const Spec& spec) {
  return std::all_of(spec.objectives.begin(), spec.objectives.end(), [&](Objective objective) {
    return mean(holdout.best, objective) > mean(holdout.start, objective);
  });
}

std::string overlay(const Spec& spec, const std::vector<double>& best, const Side& holdout) {
  std::string yaml = fmt::format("# Tuned by {}. On {} hold-out runs:\n", spec.name, holdout.runs.size());
  for (const Objective objective : spec.objectives)
    yaml += fmt::format("#   {} {:.6g} -> {:.6g} (less is better)\n", name(objective),
                        mean(holdout.start, objective), mean(holdout.best, objective));
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Parameter& p = spec.parameters[i];
    yaml += fmt::format("{}: {}\n", p.key, p.at(best[i]));
    for (const std::string& also : p.also) yaml += fmt::format("{}: {}\n", also, p.at(best[i]));
  }
  return yaml;
}

std::string interval_text(const Profile* profile) {
  if (!profile) return "";
  if (profile->identifiable()) return fmt::format("  95 %: {:.4g} to {:.4g}", *profile->low, *profile->high);
  return fmt::format("  not identifiable here: {} bounded {}",
                     profile->low || profile->high ? "not" : "neither",
                     profile->low    ? "above"
                     : profile->high ? "below"
                                     : "below nor above");
}

std::string answer_text(const Spec& spec, const std::vector<double>& best,
                        const std::vector<Profile>& profiles, const Side& training, const Side& holdout) {
  std::string text;
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Parameter& p = spec.parameters[i];
    text += fmt::format("{:<42} {:>10.4g} -> {:<10.4g}{}\n", p.key, p.start, p.at(best[i]),
                        interval_text(i < profiles.size() ? &profiles[i] : nullptr));
  }
  for (const auto& [what, side] : {std::pair{"training", &training}, std::pair{"hold-out", &holdout}})
    for (const Objective objective : spec.objectives)
      text += fmt::format("{:<42} {:>10.4g} -> {:<10.4g}  mean of {} runs, less is better\n",
                          fmt::format("{} on {}", name(objective), what), mean(side->start, objective),
                          mean(side->best, objective), side->runs.size());
  return text;
}

/// What is left when the search is done and its recordings are put away.
struct Found {
  std::vector<double> start, best;
  std::vector<Profile> profiles;
  Side training;
  ordered_json front = ordered_json::array();
  std::string history;
};

ordered_json front_json(const Study& study) {
  ordered_json all = ordered_json::array();
  for (const Candidate* c : pareto_front(study.candidates())) all.push_back(c->values);
  return all;
}

/// Whether the profiles passed a place that is better than where they began by more than the recordings leave
/// open.
bool passed_better(double before, double after, const std::vector<Profile>& profiles) {
  constexpr double kPart = 0.1;  // of the rise at the nearest end of a 95 % interval
  double least = std::numeric_limits<double>::infinity();
  for (const Profile& profile : profiles) least = std::min(least, profile.threshold);
  return before - after > kPart * least;
}

/// A profile that passes a better place than the best is where another polish begins.
std::vector<Profile> profiles_of_the_best(Study& study, Standing& standing) {
  const Spec& spec = study.spec();
  const auto begin = [&](const char* stage, int settings) {
    standing = {stage, standing.tried, standing.tried + settings, standing.best};
  };
  for (int restart = 0;; ++restart) {
    begin("profiles", 8 * static_cast<int>(spec.parameters.size()));
    const double before = study.best().values[0];
    std::vector<Profile> found = profiles(study);
    if (restart == spec.restarts || spec.polish == 0 || !passed_better(before, study.best().values[0], found))
      return found;
    begin("polish", spec.polish);
    polish(study, spec.polish);
  }
}

Found find(const Spec& spec, TrialLog& log, const Where& where,
           const std::function<void(const Standing&)>& told) {
  const Runs runs(spec.training, errors_are_tuned(spec), where);
  Standing standing{"search", 0, spec.trials, 0};
  Study study(spec, runs, log, [&](const Candidate& c) {
    if (c.complete() && (standing.tried == 0 || c.values[0] < standing.best)) standing.best = c.values[0];
    ++standing.tried;
    told(standing);
  });
  search(study);
  const bool front = spec.objectives.size() == 2;
  Found found;
  found.start = study.candidates().front().parts;
  if (front) found.front = front_json(study);
  if (spec.profiles && !front) found.profiles = profiles_of_the_best(study, standing);
  found.best = front ? compromise(pareto_front(study.candidates())).parts : study.best().parts;
  found.training = side_of(runs, spec, found.start, found.best, log);
  found.history = history(study);
  return found;
}

}  // namespace

std::string log_purpose(const std::string& program) { return "gaitslam tune, " + program; }

Answer tune(const Spec& spec, const fs::path& out, const Where& where, const std::string& program,
            const std::function<void(const Standing&)>& told) {
  fs::create_directories(out);
  TrialLog log(out / "trials.jsonl", log_purpose(program));
  const Found found = find(spec, log, where, told);
  told({"hold-out", 0, 0, 0});
  const Runs unseen(spec.holdout, errors_are_tuned(spec), where);
  const Side holdout = side_of(unseen, spec, found.start, found.best, log);
  Answer answer{!worse(holdout, spec),
                answer_text(spec, found.best, found.profiles, found.training, holdout)};

  ordered_json json{{"format_version", 1}, {"name", spec.name}};
  for (const Objective objective : spec.objectives) json["objectives"].push_back(name(objective));
  json["accepted"] = answer.accepted;
  json["parameters"] = parameters_json(spec, found.best);
  json["training"] = to_json(found.training, spec);
  json["holdout"] = to_json(holdout, spec);
  json["profiles"] = ordered_json::array();
  for (const Profile& profile : found.profiles) json["profiles"].push_back(to_json(profile));
  json["front"] = found.front;
  stream::write_durably(out / "history.csv", found.history);
  stream::write_durably(out / "tune.json", json.dump(2) + "\n");
  if (answer.accepted)
    stream::write_durably(out / "best.yaml", overlay(spec, found.best, holdout));
  else
    fs::remove(out / "best.yaml");
  return answer;
}

}  // namespace sim::tune
