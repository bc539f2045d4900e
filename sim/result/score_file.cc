#include "sim/result/score_file.h"

#include <fmt/ranges.h>

#include <tuple>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/scenario/keys.h"

namespace sim::result {
namespace {

scenario::Ending read_ending(const files::Json& json) {
  if (const auto ending = scenario::ending_named(json.text())) return *ending;
  json.fail(
      fmt::format("is '{}', expected one of {}", json.text(), fmt::join(scenario::kResultEndings, ", ")));
}

std::optional<std::string> text_or_none(const files::Json& json, const char* key) {
  const auto found = json.find(key);
  return found ? std::optional(found->text()) : std::nullopt;
}

About about_of(const files::Json& json) {
  About about;
  for (const auto& [key, text] : {std::pair{"program", &About::program},
                                  {"version", &About::version},
                                  {"revision", &About::revision},
                                  {"scenario", &About::scenario},
                                  {"estimator", &About::estimator},
                                  {"cause", &About::cause},
                                  {"alignment", &About::alignment},
                                  {"recording_xxh3_128", &About::recording},
                                  {"models_xxh3_128", &About::models},
                                  {"estimator_xxh3_128", &About::estimator_files}})
    about.*text = text_or_none(json, key).value_or("");
  about.counterfactual = text_or_none(json, "counterfactual");
  if (const auto seed = json.find("seed")) about.seed = seed->whole();
  if (const auto ending = json.find("walk_ending"))
    about.walk = {read_ending(*ending), text_or_none(json, "walk_cause").value_or("")};
  if (const auto set_by = json.find("set_by"))
    for (const auto& [key, origin] : set_by->entries()) about.set_by[key] = origin.text();
  return about;
}

// The last lines of a log, sanitized.
std::string last_lines(std::string log) {
  constexpr std::size_t kMostLines = 5, kMostBytes = 4096;
  log.erase(0, log.size() - std::min(log.size(), kMostBytes));
  std::ranges::replace(log, '\r', '\n');  // from progress lines
  std::size_t begin = log.find_last_not_of('\n');
  for (std::size_t lines = 0; lines < kMostLines && begin != log.npos && begin > 0; ++lines)
    begin = log.rfind('\n', begin - 1);
  return files::sanitize(log.substr(begin == log.npos ? 0 : log[begin] == '\n' ? begin + 1 : begin));
}

bool may_contain_results(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename();
  return entry.is_directory() && !entry.is_symlink() && !name.starts_with(".") && name != "export" &&
         name != "recording";
}

void add_results(const fs::path& folder, std::vector<fs::path>& found) {
  if (is_result(folder)) return found.push_back(folder);
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder))
    if (may_contain_results(entry)) below.push_back(entry.path());
  std::ranges::sort(below, {}, [](const fs::path& path) {
    const auto seed = seed_of(path);
    return std::tuple(!seed, seed.value_or(0), path);
  });
  for (const fs::path& next : below) add_results(next, found);
}

}  // namespace

std::optional<double> SeedScore::value(const std::string& metric) const {
  const auto found = std::ranges::find(metrics, metric, &SeedMetric::name);
  return found == metrics.end() ? std::nullopt : found->value;
}

std::optional<double> SeedScore::coverage() const {
  const auto matched = value("poses_matched"), all = value("true_poses"), tracked = value("tracked_fraction");
  if (!matched || !all || *all == 0) return tracked;
  return std::min(*matched / *all, tracked.value_or(1));
}

SeedScore read_score(const fs::path& file) {
  using scenario::Bound;
  const files::Json json = files::read_json(file);
  SeedScore score;
  score.seed = json.at("seed").whole(), score.ending = read_ending(json.at("ending"));
  if (const auto code = json.find("exit_code")) score.exit_code = int(code->whole());
  score.scenario = json.at("scenario").text();
  if (const auto estimator = json.find("estimator")) score.estimator = estimator->text();
  for (const auto& [name, metric] : json.at("metrics").entries())
    score.metrics.push_back({name, metric.at("unit").text(), metric.at("value").number_or_null(),
                             text_or_none(metric, "reason").value_or(""), text_or_none(metric, "note")});
  for (const files::Json& limit : json.at("limits").items()) {
    const auto at_most = limit.find("at_most"), passed = limit.find("passed");
    score.limits.push_back(
        {{limit.at("metric").text(), std::nullopt, at_most ? Bound::at_most : Bound::at_least,
          at_most ? at_most->number() : limit.at("at_least").number()},
         limit.at("value").number_or_null(),
         passed ? std::optional(passed->flag()) : std::nullopt});
  }
  if (const auto time = json.find("estimator_time")) score.repeatable = time->at("repeatable").flag();
  const auto tracking = json.find("tracking");
  for (const char* const kind : {"lost", "suspect"})
    if (const auto faults = tracking ? tracking->find(kind) : std::nullopt)
      for (const files::Json& fault : faults->items()) {
        const auto to = fault.find("to_s");
        score.faults.push_back({kind, fault.at("cause").text(), fault.at("from_s").number(),
                                to ? std::optional(to->number()) : std::nullopt});
      }
  return score;
}

SeedScore read_result(const fs::path& folder) {
  SeedScore score = read_score(folder / "score.json");
  const About about = read_about(folder / "about.json");
  score.cause = about.cause, score.recording = about.recording;
  if (fs::exists(folder / "timing.json"))
    if (const auto wall = files::read_json(folder / "timing.json").find("wall_s"))
      score.wall_s = wall->number();
  if (fs::exists(folder / "estimator.log"))
    score.last_lines = last_lines(files::read_text(folder / "estimator.log"));
  return score;
}

SeedScore without_score(std::uint64_t seed, int exit_code) {
  return {seed, exit_code == 2 ? scenario::Ending::not_started : scenario::Ending::crashed, exit_code, {}};
}

About read_about(const fs::path& file) { return about_of(files::read_json(file)); }

About read_about_of_walk(const fs::path& file) {
  const files::Json json = files::read_json(file);
  json.at("walk_ending").text();
  return about_of(json);
}

bool is_result(const fs::path& folder) {
  std::error_code none;
  return fs::exists(folder / "score.json", none);
}

std::optional<std::uint64_t> seed_of(const fs::path& result) {
  const std::string name = result.filename();
  if (!name.starts_with("seed-")) return std::nullopt;
  const auto seed = files::parse_number<std::uint64_t>(std::string_view(name).substr(5));
  return seed && name == "seed-" + std::to_string(*seed) ? seed : std::nullopt;
}

std::vector<fs::path> find_results(const fs::path& folder) {
  std::vector<fs::path> found;
  add_results(folder, found);
  return found;
}

std::vector<std::uint64_t> seeds_in(const fs::path& folder) {
  std::vector<std::uint64_t> seeds;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (const auto seed = seed_of(entry.path()); seed && is_result(entry.path())) seeds.push_back(*seed);
  std::ranges::sort(seeds);
  return seeds;
}

Provenance provenance_of(scenario::Scenario scenario, const std::string& revision,
                         const std::string& models) {
  scenario.seed = 0;
  const std::string files =
      programs::files_identity(scenario.estimator) + programs::files_identity(scenario.controller);
  files::Hash hash;
  hash.add(files);
  return {scenario::to_yaml(scenario), revision, models, files.empty() ? "" : hash.hex()};
}

Provenance provenance_of(const fs::path& result) {
  const About about = read_about(result / "about.json");
  Provenance all =
      provenance_of(scenario::read_scenario(result / "scenario.yaml").scenario, about.revision, about.models);
  all.estimator_files = about.estimator_files;
  return all;
}

}  // namespace sim::result
