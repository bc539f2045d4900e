// The commands that judge results: regress and baseline for a suite, compare for two sets of results.
#include <fmt/ranges.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <set>

#include "sim/regression/verdict.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

using regression::Baseline, regression::Comparison, regression::Gate, regression::ResultSet;
using regression::ScenarioResults, regression::ScenarioVerdict;

/// The files of --junit, --markdown and --json, and --allow-undecided. `--json` without a file prints to
/// standard output.
struct VerdictRequest {
  std::array<std::optional<fs::path>, 3> files;
  bool allow_undecided = false;
};

/// An output format for verdicts, and the first bytes of its files.
struct VerdictFormat {
  const char* option;
  std::string_view start;
  std::string (*text)(const Comparison&);
};
constexpr std::array kFormats{
    VerdictFormat{"--junit", "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"gaitslam ",
                  regression::junit},
    VerdictFormat{"--markdown", "### gaitslam ", regression::markdown},
    VerdictFormat{"--json", "{\n  \"title\": \"gaitslam ", regression::verdicts_json}};

/// Compares results with the results of the same name in a baseline; they are NEW if it has none.
ScenarioVerdict verdict_of(const std::vector<ScenarioResults>& baseline, const ScenarioResults& now,
                           const std::vector<Gate>& gates) {
  const auto before = std::ranges::find(baseline, now.name, &ScenarioResults::name);
  return regression::compare(before == baseline.end() ? ScenarioResults() : *before, now, gates);
}

/// Adds the baseline's scenarios that have no verdict yet as MISSING.
void add_missing(Comparison& comparison, const std::vector<ScenarioResults>& baseline,
                 const std::vector<Gate>& gates) {
  for (const ScenarioResults& before : baseline)
    if (std::ranges::count(comparison.scenarios, before.name, &ScenarioVerdict::name) == 0)
      comparison.scenarios.push_back(regression::compare(before, {before.name, {}, {}}, gates));
}

/// Also adds --quiet.
void add_verdict_options(CLI::App& command, VerdictRequest& request) {
  auto& files = request.files;
  command.add_flag("--allow-undecided", request.allow_undecided,
                   "pass even if a change beyond its tolerance may be due to chance (UNDECIDED)");
  command.add_option("--junit", files[0], "write JUnit XML to a file");
  command.add_option("--markdown", files[1], "write Markdown tables to a file");
  add_quiet(command);
  const auto take_json = [&files](const std::string& file) {
    if (file.empty())  // CLI11 passes this for an option without a value
      choose_output(Output::json);
    else
      files[2] = file;
  };
  command
      .add_option_function<std::string>(
          "--json", take_json, "print only JSON (schemas/verdicts.schema.json), or write it to a file")
      ->expected(0, 1)
      ->option_text("[FILE]")
      ->excludes("--quiet");
}

/// Throws UsageError for an existing file that gaitslam did not write, recognized by its first bytes. Call
/// this before the comparison.
void require_replaceable(const VerdictRequest& request) {
  const auto& files = request.files;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!files[i]) continue;
    require_folder_of(*files[i], kFormats[i].option);
    if (!fs::exists(fs::symlink_status(*files[i]))) continue;
    files::require_regular(*files[i]);
    files::InputFile in(*files[i], files::kMostOfText);
    const std::string_view found = in.next();
    if (!found.empty() && !found.starts_with(kFormats[i].start))
      throw UsageError("{}: exists and was not written by gaitslam; choose another file, or remove it",
                       files[i]->string());
  }
}

/// Prints the verdicts as a table or as JSON, and writes the files. Throws FileError.
void report_verdicts(const Comparison& comparison, const VerdictRequest& request) {
  const auto& files = request.files;
  text_out() << regression::verdict_table(comparison, colors());
  if (output() == Output::json) std::cout << regression::verdicts_json(comparison);
  for (std::size_t i = 0; i < files.size(); ++i)
    if (files[i]) files::write_atomically(*files[i], kFormats[i].text(comparison));
}

constexpr const char* kRegressExamples = R"(Examples:
  gaitslam regress scenarios/suites/ci.yaml --baseline main.json --seeds 1..10 --junit junit.xml
  gaitslam regress scenarios/suites/ci.yaml --against ../base/tools/gaitslam --seeds 1..32 --jobs 2
  gaitslam regress scenarios/suites/mine.yaml --audit
Verdicts: IDENTICAL: the same bits on every seed. SAME: the change is within the tolerance. BETTER or FAIL: it is
beyond the tolerance and significant. UNDECIDED: it is beyond the tolerance, but may be due to chance; more seeds decide. NEW
or MISSING (a failure): only one of the sides has it. The change is the Hodges-Lehmann estimate over the paired seeds, as a
percentage of the baseline's median; its interval covers the true change with the printed probability. Significance is
determined by the signed rank test with Holm's correction over the gates of a scenario, at 5 %. With fewer than 8 seeds there
is no test: the verdict is BETTER or FAIL if no seed is beyond the tolerance in the other direction. NEES and NIS are judged by
their means over the seeds.
Three seeds run first; if all their gated metrics are IDENTICAL, the suite passes. Otherwise all seeds run, as with --seeds.
With --against, another build runs the same walks instead of a stored baseline, in alternation, on shared recordings if both
builds would record the same. The estimator's CPU time per frame is then gated too (10 %). With --audit, three seeds are
repeated with a reversed gyro, with noise x4, and without images; a gate that none of these moves is named (exit code 1).
Exit codes: 0 as good as the baseline; 1 worse, undecided (unless --allow-undecided), or a limit is missed; 2 wrong
usage, configuration or baseline; 3 a run ended in a way that its scenario does not allow.)";

constexpr const char* kBaselineExamples = R"(Examples:
  gaitslam baseline update scenarios/suites/ci.yaml --reason "the stabilizer damps the ankles" --jobs 2
  gaitslam baseline update scenarios/suites/ci.yaml --results results/regress-ci --reason "as in the last regress"
Shows what changes, then writes the file. If a result misses a limit of its scenario, nothing is written.
Exit codes: 0 written; 1 a limit is missed; 2 wrong usage or configuration; 3 a run failed.)";

struct SuiteRequest : OutRequest {
  fs::path suite = "scenarios/suites/ci.yaml";
  std::vector<std::string> overrides;
  std::optional<std::string> seeds, baseline;
  std::optional<fs::path> results;  ///< existing <scenario>/seed-<n> to judge instead of running
  std::optional<fs::path> against;  ///< another build, whose runs are the baseline
  Backend backend;
  bool cached = false;
};

/// One scenario of a suite and the results of its runs. entry: also has the overrides of the command.
struct SuiteScenario {
  regression::SuiteEntry entry;
  scenario::ReadScenario read;
  fs::path folder;                                    ///< of its results
  std::map<std::string, std::string> suite_config{};  ///< without the command's overrides
  ScenarioResults results{}, before{};                ///< before: those of the other build
};

struct SuiteRun {
  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<SuiteScenario> scenarios;
  std::optional<double> consistent{};  ///< as in Suite
  std::string other{}, other_key{};    ///< version of the other build, and a hash of its program
};

void add_suite_options(CLI::App& command, SuiteRequest& request) {
  command.add_option("--baseline", request.baseline, "baseline file (default: ../baselines/<suite>.json)");
  add_seeds(command, request.seeds, "seeds to use instead of the suite's");
  add_backend_options(command, request.backend);
  command.add_option("--results", request.results, "judge DIR/<scenario>/seed-<n> without running anything");
  add_cached(command, request.cached);
  add_out(command, request);
}

/// Returns the baseline file: --baseline, otherwise <suite>.json in baselines/ next to the suite's folder.
fs::path baseline_file(const SuiteRequest& request) {
  if (request.baseline) return *request.baseline;
  return (request.suite.parent_path() / ".." / "baselines" / request.suite.stem())
             .lexically_normal()
             .string() +
         ".json";
}

/// Returns the command that compares with another build, on enough seeds to decide.
std::string remedy(const SuiteRequest& request, std::size_t seeds) {
  std::string command =
      fmt::format("{} regress {}", typed_program(), files::shell_word(request.suite.string()));
  for (const std::string& change : request.overrides) command += " " + files::shell_word(change);
  return fmt::format("{} --against {} --seeds 1..{}", command,
                     files::shell_word(request.against.value_or("../base/tools/gaitslam").string()),
                     seeds < 32 ? 32 : 2 * seeds);
}

/// Returns the first line that the other build prints as its version. Throws UsageError.
std::string version_of(const fs::path& program) {
  if (!fs::is_regular_file(program) || ::access(program.c_str(), X_OK) != 0)
    throw UsageError("--against {}: {}, expected the gaitslam program of another build", program.string(),
                     fs::exists(program) ? "cannot be executed" : "does not exist");
  const ShellOutput said = run_shell(files::shell_word(fs::absolute(program).string()) + " --version");
  if (said.status != 0 || !said.text.starts_with("gaitslam "))
    throw UsageError("--against {}: --version fails, expected the gaitslam program of another build{}{}",
                     program.string(), said.errors.empty() ? "" : ": ",
                     said.errors.substr(0, said.errors.find('\n')));
  return said.text.substr(0, said.text.find('\n'));
}

SuiteScenario planned(regression::SuiteEntry entry, const std::vector<std::string>& overrides,
                      const fs::path& folder = {}) {
  const auto suite_config = regression::config_of(scenario::read_scenario(entry.file, entry.changes));
  auto& all = entry.changes.overrides;
  all.insert(all.end(), overrides.begin(), overrides.end());
  const scenario::ReadScenario read = scenario::read_scenario(entry.file, entry.changes);
  const std::string& name = read.scenario.name;
  const ScenarioResults none{name, regression::config_of(read), {}};
  return {entry, read, folder / name, suite_config, none, none};
}

SuiteRun plan_suite(const SuiteRequest& request) {
  const regression::Suite suite = regression::read_suite(request.suite);
  for (const std::string& change : request.overrides)
    if (change.starts_with("seed=") || change.starts_with("name="))
      throw UsageError(change + ": the suite sets names and seeds, expected --seeds");
  SuiteRun run{suite.name, parse_seeds(request.seeds.value_or(suite.seeds)), {}, suite.consistent};
  for (const regression::SuiteEntry& entry : suite.entries)
    run.scenarios.push_back(planned(entry, request.overrides));
  if (request.against) {
    run.other = version_of(*request.against);
    run.other_key = result::job_key({run.other, files::read_text(*request.against)});
  }
  return run;
}

/// Returns the words of the command that runs one seed of a scenario as the suite does.
std::vector<std::string> run_command(const SuiteScenario& scenario, std::uint64_t seed) {
  std::vector<std::string> words{"run", scenario.entry.file.string(), fmt::format("seed={}", seed)};
  for (const std::string& change : scenario.entry.changes.overrides) words.push_back(change);
  for (const std::string& section : scenario.entry.changes.without)
    words.insert(words.end(), {"--without", section});
  return words;
}

/// Returns the same job for the other build. Its folder depends on everything that its result depends on.
ResultJob by_other(ResultJob job, const SuiteScenario& scenario, const SuiteRun& run, const fs::path& other) {
  job.program = fs::absolute(other);
  job.command = run_command(scenario, job.seed());
  const std::string key = result::job_key({run.other_key, inputs_of(scenario.read.scenario)});
  job.folder = fs::path("against-" + key.substr(0, 8)) / scenario.folder;
  return job;
}

constexpr const char* kCpuTime = "frame_cpu_ms_mean";
const Gate kCpuGate{kCpuTime, 10, 0};

/// Adds the CPU time that the estimator took, as a metric.
void add_cpu_time(result::SeedScore& score, const fs::path& folder) {
  if (!fs::exists(folder / "timing.json")) return;
  if (const auto ms = files::read_json(folder / "timing.json").find(kCpuTime))
    score.metrics.push_back({kCpuTime, "ms", ms->number()});
}

void run_jobs(const SuiteRequest& request, SuiteRun& run) {
  std::vector<ResultJob> jobs;
  std::vector<ScenarioResults*> results;
  for (SuiteScenario& s : run.scenarios) {
    const double walk_s =
        slam::seconds(result::plan_end(s.read.scenario.walk));  // every second of a walk costs the same
    for (const ResultJob& job : jobs_of_seeds({s.read, s.folder, {}, walk_s}, run.seeds)) {
      jobs.push_back(job), results.push_back(&s.results);
      if (!request.against) continue;
      jobs.push_back(by_other(job, s, run, *request.against)), results.push_back(&s.before);
      if (results.size() % 4 == 0)  // so that neither build always runs first
        std::swap(jobs.back(), jobs[jobs.size() - 2]), std::swap(results.back(), results[jobs.size() - 2]);
    }
  }
  const OutFolder out(request, fs::path("results") / ("regress-" + run.name), OutUse::adds_results);
  Backend backend = request.backend;
  const bool cached = request.cached || request.against;
  backend.seconds_each = cached ? 3 : 15;  // CPU time
  const auto ends = make_results(
      jobs, out,
      {.models = standard_models(),
       .title = fmt::format("suite {}, {} of {}", run.name, files::counted(run.scenarios.size(), "scenario"),
                            files::counted(run.seeds.size(), "seed")),
       .backend = backend,
       .cached = cached,
       .force = request.force,
       .must_start = true});
  std::vector<result::SeedScore> scores = read_scores(jobs, ends, out.path());
  bool by_other_build = false;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (request.against && ends[i].finished) add_cpu_time(scores[i], out.path() / jobs[i].result());
    by_other_build |= ends[i].finished && !jobs[i].program.empty();
    results[i]->seeds.push_back(std::move(scores[i]));
  }
  if (request.against && !by_other_build)
    throw UsageError("--against {}: left no result", request.against->string());
}

void run_suite(const SuiteRequest& request, SuiteRun& run) {
  if (!request.results) {
    require_simulator();
    return run_jobs(request, run);
  }
  for (SuiteScenario& s : run.scenarios)
    for (const std::uint64_t seed : run.seeds) {
      scenario::Scenario scenario = s.read.scenario;
      scenario.seed = seed;
      const fs::path folder = *request.results / scenario.name / fmt::format("seed-{}", seed);
      if (!result::is_result(folder))
        throw UsageError("{}: the result of seed {} is missing", folder.string(), seed);
      if (files::read_text(folder / "scenario.yaml") != scenario::to_yaml(scenario))
        throw UsageError("{}: was made with a different configuration of {}; run it again", folder.string(),
                         scenario.name);
      s.results.seeds.push_back(result::read_result(folder));
    }
}

std::string repro(const SuiteScenario& scenario, std::uint64_t seed) {
  std::string command = typed_program();
  for (const std::string& word : run_command(scenario, seed)) command += " " + files::shell_word(word);
  return command;
}

/// Throws ConfigError at a gate of the suite's file for which no run has a value, unless no run has any.
void require_values(const SuiteScenario& s, const ScenarioVerdict& verdict) {
  const auto is_scored = [](const result::SeedScore& seed) { return !seed.metrics.empty(); };
  const auto scored = std::ranges::find_if(s.results.seeds, is_scored);
  if (scored == s.results.seeds.end()) return;
  for (const scenario::Yaml& name : s.entry.at.keys) {
    const auto of = [&](const auto& item) { return item.name == name.text; };
    const bool is_gate = std::ranges::count(s.entry.gates, name.text, &Gate::metric) > 0,
               judged = std::ranges::any_of(verdict.metrics,
                                            [&](const auto&m) { return m.gate.metric == name.text; });
    if (!is_gate || judged) continue;
    const auto metric = std::ranges::find_if(scored->metrics, of);
    scenario::fail(name, "gate." + name.text,
                   "no run of {} has a value{}, expected a metric that its runs have", s.read.scenario.name,
                   metric == scored->metrics.end() || metric->reason.empty()
                       ? ""
                       : fmt::format(" ({})", metric->reason));
  }
  if (verdict.metrics.empty())
    scenario::fail(s.entry.at, "gate", "missing, and no run of {} has a value of a default gate",
                   s.read.scenario.name);
}

Comparison compare_with(const std::vector<ScenarioResults>& baseline, const SuiteRun& run,
                        const SuiteRequest& request, const std::string& title) {
  Comparison comparison{title, {}, false};
  for (const SuiteScenario& s : run.scenarios) {
    auto& verdict = comparison.scenarios.emplace_back(
        request.against ? regression::compare(s.before, s.results, s.entry.gates)
                        : verdict_of(baseline, s.results, s.entry.gates));
    require_values(s, verdict);
    if (request.against)  // apart from the other gates, which Holm's correction counts
      for (const auto& cpu : regression::compare(s.before, s.results, {kCpuGate}).metrics)
        verdict.metrics.push_back(cpu);
    verdict.limits = regression::judge_limits(s.read.scenario, s.results.seeds, s.entry.expects_missed);
    if (run.consistent && !s.entry.expects_missed)
      for (auto& row : regression::judge_consistency(s.results.seeds, *run.consistent))
        verdict.limits.push_back(std::move(row));
    verdict.repro = [&](std::uint64_t seed) { return repro(s, seed); };
    verdict.remedy = remedy(request, run.seeds.size());
    verdict.file = s.entry.file.string();
  }
  add_missing(comparison, baseline, regression::default_gates());
  for (ScenarioVerdict& verdict : comparison.scenarios)
    if (verdict.file.empty()) verdict.file = request.suite.string();
  return comparison;
}

struct RegressRequest : SuiteRequest {
  VerdictRequest verdicts;
  bool github = false, audit = false;
};

/// Throws UsageError unless the baseline contains the same configurations and all seeds of the run.
void require_comparable(const Baseline& baseline, const SuiteRun& run, const SuiteRequest& request,
                        const std::string& file) {
  const std::string other = remedy(request, run.seeds.size());
  for (const SuiteScenario& scenario : run.scenarios) {
    const std::string& name = scenario.read.scenario.name;
    const ScenarioResults* before = baseline.find(name);
    if (!before) continue;
    const auto differences = regression::config_differences(before->config, scenario.suite_config);
    if (!differences.empty())
      throw UsageError(
          "{}: the configuration of {} differs from the baseline {}: {}; '{}' compares with another build",
          scenario.entry.file.string(), name, file, fmt::join(differences, "; "), other);
    for (const std::uint64_t seed : run.seeds)
      if (!before->find(seed))
        throw UsageError("{}: has no seed {} of {}; '{}' compares with another build", file, seed, name,
                         other);
  }
}

/// Number of seeds of a suite that run first. The others follow only if a gated metric differs from the
/// baseline in any bit, or a row does not pass.
constexpr std::size_t kFirstSeeds = 3;

bool is_identical(const Comparison& comparison) {
  return regression::exit_code(comparison) == 0 &&
         std::ranges::all_of(comparison.scenarios, [](const ScenarioVerdict& scenario) {
           return std::ranges::all_of(scenario.metrics, [](const regression::MetricVerdict& metric) {
             return metric.verdict == regression::Verdict::identical || metric.gate == kCpuGate;
           });
         });
}

constexpr std::array kDisturbances{"gyro_reversed", "noise_x4", "no_images"};

/// Returns the overrides of a disturbance, an error of the sensors that a suite should notice.
std::vector<std::string> overrides_of(std::string_view disturbance, const scenario::Scenario& scenario) {
  if (disturbance == "gyro_reversed")
    return {"errors.faults=[{gyro_scaled: {duration_s: 1000000, factor: -1}}]"};
  if (disturbance == "no_images") return {"errors.image.loss_fraction=1"};
  std::vector<std::string> all;
  for (const char* key :
       {"errors.gyro.sigma_rad_s", "errors.accelerometer.sigma_m_s2", "errors.image.read_sigma_gray",
        "errors.image.shot_sigma_gray", "errors.leg_odometry.sigma_m"})
    all.push_back(
        fmt::format("{}={}", key, 4 * files::parse_finite(scenario::find_key(key)->print(scenario)).value()));
  return all;
}

/// Runs the suite with each disturbance and prints which gates it moves. Returns 1 if a gate is never moved.
int audit(const SuiteRequest& request, SuiteRun run) {
  const std::size_t n = run.scenarios.size();
  for (const char* disturbance : kDisturbances)
    for (std::size_t i = 0; i < n; ++i) {
      const SuiteScenario& plain = run.scenarios[i];
      run.scenarios.push_back(planned(plain.entry, overrides_of(disturbance, plain.read.scenario),
                                      fs::path("audit") / disturbance));
    }
  run_suite(request, run);
  std::string text = fmt::format("gaitslam regress: audit of suite {}, {}\n", run.name,
                                 files::counted(run.seeds.size(), "seed")),
              unmoved;
  for (std::size_t i = 0; i < n; ++i) {
    const SuiteScenario& plain = run.scenarios[i];
    text += fmt::format("\n{:<34}", plain.results.name);
    for (const char* disturbance : kDisturbances) text += fmt::format(" {:>14}", disturbance);
    for (const Gate& gate : plain.entry.gates) {
      bool moved = false;
      text += fmt::format("\n  {:<32}", gate.metric);
      for (std::size_t k = 1; k <= kDisturbances.size(); ++k) {
        const auto found =
            regression::compare(plain.results, run.scenarios[k * n + i].results, {gate}).metrics;
        using enum regression::Verdict;
        const auto verdict = found.empty() ? identical : found[0].verdict;
        moved |= verdict != identical && verdict != same;
        text += fmt::format(" {:>14}", regression::word(verdict));
      }
      if (!moved)
        unmoved += fmt::format("{}: {}: no disturbance moves this gate\n", plain.results.name, gate.metric);
    }
    text += '\n';
  }
  text_out() << text << (unmoved.empty() ? "\neach gate is moved\n" : "\n" + unmoved);
  return unmoved.empty() ? 0 : 1;
}

int regress(RegressRequest& request) {
  require_replaceable(request.verdicts);
  SuiteRun run = plan_suite(request), first = run;
  first.seeds.resize(std::min(run.seeds.size(), kFirstSeeds));
  if (request.audit) {
    request.cached = true;
    return audit(request, request.seeds ? run : first);
  }
  Baseline baseline;
  std::string title = fmt::format("gaitslam regress: suite {} against ", run.name);
  if (request.against) {
    title += fmt::format("{} ({})", request.against->string(), run.other);
  } else {
    const std::string file = baseline_file(request).string();
    if (!fs::exists(file))
      throw UsageError("{}: does not exist; '{}' compares with another build", file,
                       remedy(request, run.seeds.size()));
    baseline = regression::read_baseline(file);
    require_comparable(baseline, run, request, file);
    title += fmt::format("{} (revision {})", file,
                         baseline.history.empty() ? "?" : baseline.history.back().revision);
  }
  std::optional<Comparison> found;
  if (!request.seeds && !request.results && first.seeds != run.seeds) {
    run_suite(request, first);
    found =
        compare_with(baseline.scenarios, first, request,
                     fmt::format("{}: {} of {} seeds, which decide", title, kFirstSeeds, run.seeds.size()));
    if (!is_identical(*found)) found.reset();
  }
  if (!found) {
    run_suite(request, run);
    found = compare_with(baseline.scenarios, run, request, title);
  }
  Comparison& comparison = *found;
  comparison.allow_undecided = request.verdicts.allow_undecided;
  report_verdicts(comparison, request.verdicts);
  if (request.github) {
    text_out() << regression::github_annotations(comparison);
    if (const char* const summary = std::getenv("GITHUB_STEP_SUMMARY"))
      if (!(std::ofstream(summary, std::ios::app) << regression::markdown(comparison) << std::flush))
        throw files::FileError(summary, "cannot be written");
  }
  return regression::exit_code(comparison);
}

struct BaselineRequest : SuiteRequest {
  std::string reason;
  bool dry_run = false;
};

/// Prints verdicts against the old baseline, even if its configurations differ, and changes in the number of
/// seeds. Returns an exit code that depends only on the limits, because an update is meant to change metrics.
int show(const Baseline& before, const SuiteRun& run, const BaselineRequest& request,
         const std::string& file) {
  Comparison comparison =
      compare_with(before.scenarios, run, request, "gaitslam baseline update: " + file + " before and after");
  std::cout << regression::verdict_table(comparison, colors());
  for (const SuiteScenario& s : run.scenarios) {
    const ScenarioResults* old = before.find(s.results.name);
    if (old && old->seeds.size() != run.seeds.size())
      std::cout << fmt::format("{}: {} seeds -> {}\n", s.results.name, old->seeds.size(), run.seeds.size());
  }
  for (ScenarioVerdict& verdict : comparison.scenarios) verdict.metrics.clear();
  return regression::exit_code(comparison);
}

int update(BaselineRequest& request) {
  if (request.reason.find_first_not_of(" \t") == request.reason.npos)
    throw UsageError("--reason: is empty, expected the reason for the change");
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  Baseline baseline;
  if (fs::exists(file)) baseline = regression::read_baseline(file);
  run_suite(request, run);
  if (const int code = show(baseline, run, request, file); code != 0) {
    std::cerr << fmt::format("gaitslam: {}: not changed, because a result misses a limit\n", file);
    return code;
  }
  if (request.dry_run) return 0;
  baseline.history.push_back({kRevision, request.reason, processor()});
  baseline.scenarios.clear();
  for (const SuiteScenario& s : run.scenarios) baseline.scenarios.push_back(s.results);
  regression::write_baseline(file, baseline);
  std::cout << "written to " << file << '\n';
  return 0;
}

constexpr const char* kCompareExamples = R"(Examples:
  gaitslam compare results/before results/after
Each argument is a result folder, a folder of seed-<n>, or a folder of scenarios with seed-<n>. Common seeds are
paired and compared with the signed rank test. Scenarios with different names or walks need --across, because one may
be harder than the other.
Verdicts and exit codes are the same as for gaitslam regress with a suite without gates.)";

struct CompareRequest {
  fs::path before, after;
  VerdictRequest verdicts;
  bool across = false;
};

using Sets = std::vector<ResultSet>;

const ResultSet* find(const Sets& sets, const std::string& name) {
  const auto found = std::ranges::find(sets, name, [](const auto& set) { return set.results.name; });
  return found == sets.end() ? nullptr : &*found;
}

/// Throws UsageError if two folders contain the same scenario.
Sets read_sets(const fs::path& folder) {
  Sets sets = regression::read_result_sets(folder);
  for (const ResultSet& set : sets)
    if (const ResultSet* first = find(sets, set.results.name); first != &set)
      throw UsageError("{} and {} contain the same scenario, {}; compare one of them", first->folder.string(),
                       set.folder.string(), set.results.name);
  return sets;
}

/// Returns the folder to show in a message: for a single result its own folder, not the one that contains it.
std::string place(const fs::path& argument, const ResultSet& set) {
  return (result::is_result(argument) ? argument : set.folder).string();
}

constexpr const char* kInsist = "--across compares different scenarios";

/// Throws UsageError if the names or the walks differ.
void require_same_scenario(const ResultSet& before, const ResultSet& now, const CompareRequest& request) {
  const std::string one = place(request.before, before), two = place(request.after, now);
  if (before.results.name != now.results.name)
    throw UsageError("{} contains the scenario {}, but {} contains {}; {}", one, before.results.name, two,
                     now.results.name, kInsist);
  auto other = scenario::first_difference(before.scenario, now.scenario);
  if (!other) other = scenario::first_difference(now.scenario, before.scenario);
  if (other)
    throw UsageError("{} and {}: {} differs, so the walks are not the same; {}", one, two, other->key,
                     kInsist);
}

/// Throws UsageError unless the sets share at least one scenario and all shared ones are the same.
void require_comparable(const Sets& before, const Sets& now, const CompareRequest& request) {
  if (before.size() == 1 && now.size() == 1)
    return require_same_scenario(before.front(), now.front(), request);
  bool any = false;
  for (const ResultSet& set : now)
    if (const ResultSet* other = find(before, set.results.name)) {
      require_same_scenario(*other, set, request);
      any = true;
    }
  if (!any)
    throw UsageError("{} and {} have no scenario in common; --across compares them anyway",
                     request.before.string(), request.after.string());
}

/// Returns ", my_slam" if an estimator other than the filter made the results, or "".
std::string estimators_of(const Sets& sets) {
  std::set<std::string> names;
  for (const ResultSet& set : sets) names.insert(set.scenario.estimator.name);
  return names == std::set<std::string>{"filter"} ? "" : fmt::format(", {}", fmt::join(names, ", "));
}

int compare(CompareRequest& request) {
  require_replaceable(request.verdicts);
  const std::vector<Gate>& gates = regression::default_gates();
  const auto before = read_sets(request.before), now = read_sets(request.after);
  if (!request.across) require_comparable(before, now, request);
  std::vector<ScenarioResults> baseline;
  for (const ResultSet& set : before) baseline.push_back(set.results);
  if (before.size() == 1 && now.size() == 1) baseline.front().name = now.front().results.name;
  Comparison comparison{
      fmt::format("gaitslam compare: {} (baseline{}) and {} (now{})", request.before.string(),
                  estimators_of(before), request.after.string(), estimators_of(now)),
      {},
      request.verdicts.allow_undecided};
  for (const ResultSet& set : now) {
    auto& verdict = comparison.scenarios.emplace_back(verdict_of(baseline, set.results, gates));
    if (verdict.n_baseline == 0 && std::ranges::count(baseline, set.results.name, &ScenarioResults::name) > 0)
      throw UsageError("{} and {} have no seed in common; run the same seeds for both",
                       request.before.string(), set.folder.string());
    verdict.limits = regression::judge_limits(set.scenario, set.results.seeds);
    verdict.repro = [&](std::uint64_t seed) {
      const fs::path one = set.folder / fmt::format("seed-{}", seed),
                     result = fs::exists(one) ? one : request.after;
      return typed_program() + " run " + files::shell_word((result / "scenario.yaml").string());
    };
  }
  add_missing(comparison, baseline, gates);
  report_verdicts(comparison, request.verdicts);
  return regression::exit_code(comparison);
}

}  // namespace

void add_regress(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "regress", "Run a suite and compare it with its baseline", kRegressExamples, regress);
  command.add_option("suite", request.suite, "the suite's YAML file")->required();
  add_overrides(command, request.overrides, "in all scenarios");
  add_suite_options(command, request);
  add_verdict_options(command, request.verdicts);
  command.add_flag("--github", request.github, "annotate the log and the summary of a GitHub Actions job");
  command.add_option("--against", request.against, "compare with the runs of another build's program")
      ->option_text("PROGRAM")
      ->excludes("--baseline", "--results");
  command.add_flag("--audit", request.audit, "name gates that no built-in disturbance moves")
      ->excludes("--against", "--results", "--junit", "--markdown", "--json", "--github");
}

void add_baseline(CLI::App& app, int& exit_code) {
  CLI::App& baseline = *app.add_subcommand("baseline", "Manage the results that a suite is compared with");
  baseline.require_subcommand(1);
  baseline.footer(kBaselineExamples);
  auto [command, request] =
      add_command(baseline, exit_code, "update", "Run a suite and store its scores as the baseline",
                  kBaselineExamples, update);
  command.add_option("suite", request.suite, "the suite's YAML file")->capture_default_str();
  command.add_option("--reason", request.reason, "reason for the change, stored in the baseline")->required();
  add_suite_options(command, request);
  command.add_flag("--dry-run", request.dry_run, "show what would change without writing anything");
}

void add_compare(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "compare", "Compare two sets of results", kCompareExamples, compare);
  command.add_option("before", request.before, "folder of results to compare with")->required();
  command.add_option("after", request.after, "folder of results to judge")->required();
  command.add_flag("--across", request.across, "also compare different scenarios");
  add_verdict_options(command, request.verdicts);
}

}  // namespace cli
