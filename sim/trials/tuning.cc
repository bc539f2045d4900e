#include "sim/trials/tuning.h"

#include <iterator>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/recording/manifest.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"

namespace sim::trials {
namespace {

using nlohmann::ordered_json;
using Point = std::vector<double>;  ///< a setting, in the unit cube (see Range)
using Records = std::vector<const JobRecord*>;

constexpr double kFailure = 1e6;     // larger than the loss of any success
constexpr double kFirstStep = 0.25;  // first step of the search, as a fraction of the range

/// Metrics in tune.json, at the start and at the best setting.
constexpr std::array kCompared{"ate_se3_rmse_m",         "rmse_m",          "nees_position_mean",
                               "nees_orientation_mean",  "nis_vision_mean", "nis_gyro_mean",
                               "nis_plan_velocity_mean", "nis_height_mean"};

/// The recordings of training or of the hold-out. Each trial on them runs once and is logged.
class Runs {
 public:
  Runs(const Spec& spec, const std::vector<SpecRun>& runs, const RunTasks& run_tasks, JobLog& log)
      : spec_(spec), runs_(runs), log_(log), run_tasks_(run_tasks) {
    for (const SpecRun& run : runs) hashes_.push_back(recording::Manifest(run.folder / "recording").hash());
  }

  /// Returns the records of each setting on each recording, from the log if it has them. The tasks of a
  /// recording are consecutive, so that it is decoded only once for them.
  std::vector<Records> evaluate(const std::vector<Point>& points) const {
    std::vector<Task> tasks, missing;
    for (std::size_t i = 0; i < runs_.size(); ++i)
      for (const Point& point : points) tasks.push_back(task(i, point));
    std::ranges::copy_if(tasks, std::back_inserter(missing),
                         [&](const Task& task) { return !log_.find(task.key); });
    if (!missing.empty()) run_tasks_(missing, log_);
    std::vector<Records> records(points.size());
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      const JobRecord* const record = log_.find(tasks[k].key);
      if (!record) throw files::FileError(tasks[k].recording, "the filter could not be tried on it");
      records[k % points.size()].push_back(record);
    }
    return records;
  }

 private:
  /// A walk steered by its estimate differs for each setting, so its task names no recording.
  Task task(std::size_t i, const Point& point) const {
    scenario::Scenario scenario = runs_[i].read.scenario;
    for (std::size_t k = 0; k < point.size(); ++k) {
      const Range& p = spec_.parameters[k];
      set(scenario, p.key, p.value_at(point[k]));
      for (const std::string& also : p.also) set(scenario, also, p.value_at(point[k]));
    }
    const std::string text = scenario::to_yaml(scenario);
    const bool simulate = scenario.walk.steering.by == walking::SteeredBy::estimate;
    return {result::job_key({hashes_[i], text}), scenario.seed, text,
            simulate ? fs::path() : fs::absolute(runs_[i].folder)};
  }

  const Spec& spec_;
  const std::vector<SpecRun>& runs_;
  JobLog& log_;
  const RunTasks& run_tasks_;
  std::vector<std::string> hashes_;
};

/// The records of recordings with the start and with the best setting.
struct StartAndBest {
  Records start, best;
};

StartAndBest compare(const Runs& runs, const Point& start, const Point& best) {
  const std::vector<Records> records = runs.evaluate({start, best});
  return {records[0], records[1]};
}

ordered_json to_json(const StartAndBest& both, const std::vector<SpecRun>& runs, const Spec& spec) {
  ordered_json document;
  for (const SpecRun& run : runs) document["runs"].push_back(run.name);
  const auto add = [&](const std::string& name, const auto& of) {
    for (const auto& [which, records] : {std::pair("start", &both.start), std::pair("best", &both.best)}) {
      ordered_json& column = document["values"][name][which] = ordered_json::array();
      for (const JobRecord* record : *records) column.push_back(result::or_null(std::optional(of(*record))));
    }
  };
  add(std::string(name(spec.objective)), [&](const JobRecord& r) { return loss_of(r, spec.objective); });
  for (const std::string metric : kCompared) add(metric, [&](const JobRecord& r) { return r.value(metric); });
  return document;
}

enum class Verdict { better, worse, undecided, unchanged };
constexpr std::array kVerdicts{"better", "worse", "undecided", "unchanged"};

/// The change of the hold-out loss from the start to the best setting, paired by recording.
struct Judgment {
  std::vector<double> changes;   ///< if neither failed
  std::size_t newly_failed = 0;  ///< failed only with the best setting
  std::optional<score::MeanTest> test{};
  Verdict verdict = Verdict::undecided;
  std::string text;
};

/// Judges by the 95 % confidence interval of the mean change, and by failures that do not occur at the start.
Judgment judge(const StartAndBest& holdout, Objective objective) {
  Judgment judgment;
  for (std::size_t i = 0; i < holdout.best.size(); ++i) {
    const auto before = holdout.start[i]->value(name(objective)),
               after = holdout.best[i]->value(name(objective));
    if (before && after) judgment.changes.push_back(*after - *before);
    judgment.newly_failed += before && !after;
  }
  judgment.test = score::t_test(judgment.changes);
  if (judgment.newly_failed > 0 || (judgment.test && judgment.test->low > 0))
    judgment.verdict = Verdict::worse;
  else if (judgment.test && judgment.test->high < 0)
    judgment.verdict = Verdict::better;
  judgment.text =
      fmt::format("{} on hold-out: {}", name(objective), kVerdicts[std::size_t(judgment.verdict)]);
  const std::string pairs = files::counted(judgment.changes.size(), "pair");
  if (judgment.test)
    judgment.text +=
        fmt::format(", changes by {:+.4g} on average over {} (95 % interval {:+.4g} to {:+.4g})",
                    score::mean(judgment.changes), pairs, judgment.test->low, judgment.test->high);
  else
    judgment.text += fmt::format(", {} of finished runs give no interval, expected at least 2", pairs);
  if (judgment.verdict == Verdict::undecided)
    judgment.text += "; add recordings to holdout and run the command again: it reuses the finished trials";
  if (judgment.newly_failed > 0)
    judgment.text += fmt::format("; {} of {} fail only with the best setting", judgment.newly_failed,
                                 files::counted(holdout.best.size(), "run"));
  return judgment;
}

/// The outcome of the search, kept after its recordings are released.
struct Found {
  Point start, best;
  StartAndBest training;
  std::string history;        ///< as CSV
  int tried = 0, failed = 0;  ///< number of settings, and of their trials without a loss
};

/// Tries the spec's start, then generations of CMA-ES; the last generation is cut off at spec.trials
/// settings. The settings depend only on the spec and the losses found.
Found find(const Spec& spec, JobLog& log, const RunTasks& run_tasks, const ShowProgress& show) {
  const Runs runs(spec, spec.training, run_tasks, log);
  double least = 0;
  Found found;
  found.history = "#setting,origin";
  for (const Range& p : spec.parameters) {
    found.start.push_back(p.coordinate_of(p.start));
    found.history += "," + p.key;
  }
  found.history += fmt::format(",{}\n", name(spec.objective));
  const auto evaluate = [&](const char* origin, const std::vector<Point>& points) {
    std::vector<double> losses;
    for (const Records& records : runs.evaluate(points)) {
      const Point& point = points[losses.size()];
      losses.push_back(mean_loss(records, spec.objective));
      for (const JobRecord* record : records) found.failed += !record->value(name(spec.objective));
      if (found.tried == 0 || losses.back() < least) found.best = point, least = losses.back();
      found.history += fmt::format("{},{}", found.tried++, origin);
      for (std::size_t i = 0; i < point.size(); ++i)
        found.history += fmt::format(",{}", spec.parameters[i].value_at(point[i]));
      found.history += fmt::format(",{}\n", losses.back());
    }
    show(double(found.tried) / spec.trials,
         fmt::format("search, setting {}, best {:.5g}", found.tried, least));
    return losses;
  };
  evaluate("start", {found.start});
  CmaEs cma_es(found.start, kFirstStep, spec.population, spec.seed);
  while (found.tried < spec.trials) {
    std::vector<Point> generation = cma_es.ask();
    const bool whole = found.tried + spec.population <= spec.trials;
    if (!whole) generation.resize(std::size_t(spec.trials - found.tried));
    const std::vector<double> losses = evaluate("search", generation);
    if (whole) cma_es.tell(losses);
  }
  found.training = compare(runs, found.start, found.best);
  return found;
}

std::string overlay(const Spec& spec, const Point& best, const Judgment& judgment) {
  std::string yaml = fmt::format("# Tuned by {}.\n# {}\n", spec.name, judgment.text);
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Range& p = spec.parameters[i];
    yaml += fmt::format("{}: {}\n", p.key, p.value_at(best[i]));
    for (const std::string& also : p.also) yaml += fmt::format("{}: {}\n", also, p.value_at(best[i]));
  }
  return yaml;
}

std::string result_text(const Spec& spec, const Found& found, const StartAndBest& holdout,
                        const Judgment& judgment) {
  const std::size_t trials = std::size_t(found.tried) * spec.training.size();
  std::string text = fmt::format("{} tried on {}, {} of {} failed\n", files::counted(found.tried, "setting"),
                                 files::counted(spec.training.size(), "training run"), found.failed,
                                 files::counted(trials, "trial"));
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Range& p = spec.parameters[i];
    text += fmt::format("{:<42} {:>10.4g} -> {:.4g}\n", p.key, p.start, p.value_at(found.best[i]));
  }
  for (const auto& [what, both] : {std::pair{"training", &found.training}, std::pair{"hold-out", &holdout}})
    text += fmt::format("{:<42} {:>10.4g} -> {:<10.4g}  mean of {}, less is better\n",
                        fmt::format("{} on {}", name(spec.objective), what),
                        mean_loss(both->start, spec.objective), mean_loss(both->best, spec.objective),
                        files::counted(both->start.size(), "run"));
  return text + judgment.text + '\n';
}

std::string tune_json(const Spec& spec, const Found& found, const StartAndBest& holdout,
                      const Judgment& judgment) {
  ordered_json parameters = ordered_json::array();
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) {
    const Range& p = spec.parameters[i];
    parameters.push_back({{"key", p.key},
                          {"also", p.also},
                          {"unit", scenario::unit_of(p.key).value_or("")},
                          {"from", p.low},
                          {"to", p.high},
                          {"scale", p.logarithmic ? "log" : "linear"},
                          {"start", p.value_at(p.coordinate_of(p.start))},
                          {"best", p.value_at(found.best[i])}});
  }
  const auto& test = judgment.test;
  const ordered_json change{{"pairs", judgment.changes.size()},
                            {"mean", test ? ordered_json(score::mean(judgment.changes)) : ordered_json()},
                            {"interval_95", test ? ordered_json{test->low, test->high} : ordered_json()},
                            {"newly_failed", judgment.newly_failed},
                            {"verdict", kVerdicts[std::size_t(judgment.verdict)]},
                            {"text", judgment.text}};
  return files::json_text(ordered_json{{"format_version", 4},
                                       {"name", spec.name},
                                       {"objective", name(spec.objective)},
                                       {"accepted", judgment.verdict == Verdict::better},
                                       {"settings", found.tried},
                                       {"failed_trials", found.failed},
                                       {"change", change},
                                       {"parameters", parameters},
                                       {"training", to_json(found.training, spec.training, spec)},
                                       {"holdout", to_json(holdout, spec.holdout, spec)}},
                          2) +
         "\n";
}

}  // namespace

double loss_of(const JobRecord& record, Objective objective) {
  if (const auto term = record.value(name(objective))) return std::min(*term, kFailure / 2);
  return kFailure * (2 - record.value("lasted_fraction").value_or(0));
}

double mean_loss(const Records& records, Objective objective) {
  double sum = 0;
  for (const JobRecord* record : records) sum += loss_of(*record, objective);
  return sum / double(records.size());
}

std::string log_purpose(const std::string& program, const Spec& spec) {
  return fmt::format("gaitslam tune {}, {}", spec.name, program);
}

TuningResult tune(const Spec& spec, const fs::path& out, const RunTasks& run_tasks,
                  const std::string& program, const ShowProgress& show) {
  fs::create_directories(out);
  JobLog log(out / "trials.jsonl", log_purpose(program, spec));
  const Found found = find(spec, log, run_tasks, show);
  show(1, "hold-out");
  const StartAndBest holdout = compare(Runs(spec, spec.holdout, run_tasks, log), found.start, found.best);
  Judgment judgment = judge(holdout, spec.objective);
  if (found.best == found.start) {
    judgment.verdict = Verdict::unchanged;
    judgment.text = fmt::format("nothing better found: none of {} has a lower loss than the start",
                                files::counted(found.tried, "setting"));
  }
  const bool accepted = judgment.verdict == Verdict::better;
  log.sort();
  files::write_atomically(out / "history.csv", found.history);
  files::write_atomically(out / "tune.json", tune_json(spec, found, holdout, judgment));
  if (accepted)
    files::write_atomically(out / "best.yaml", overlay(spec, found.best, judgment));
  else
    fs::remove(out / "best.yaml");
  return {accepted, result_text(spec, found, holdout, judgment), judgment.text};
}

}  // namespace sim::trials
