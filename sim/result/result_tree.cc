#include "sim/result/result_tree.h"

#include <algorithm>
#include <string>
#include <tuple>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"

namespace sim::result {
namespace {

namespace fs = std::filesystem;

bool may_contain_results(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename();
  return entry.is_directory() && !entry.is_symlink() && !name.starts_with(".") &&
         !name.starts_with("earlier-") && name != "export" && name != "recording";
}

void add_results(const fs::path& folder, Nested nested, std::vector<fs::path>& found) {
  if (is_result(folder)) {
    found.push_back(folder);
    if (nested == Nested::skip) return;
  }
  std::vector<fs::path> below;
  for (const auto& entry : fs::directory_iterator(folder))
    if (may_contain_results(entry)) below.push_back(entry.path());
  std::ranges::sort(below, {}, [](const fs::path& path) {
    const auto seed = seed_of(path);
    return std::tuple(!seed, seed.value_or(0), path);
  });
  for (const fs::path& next : below) add_results(next, nested, found);
}

}  // namespace

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

std::vector<fs::path> find_results(const fs::path& folder, Nested nested) {
  std::vector<fs::path> found;
  add_results(folder, nested, found);
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
  const std::string files = estimators::estimator_files_identity(scenario.estimator);
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

std::optional<fs::path> renew_summary(const fs::path& result) {
  const fs::path root = fs::absolute(result).lexically_normal().parent_path(), file = root / "summary.json";
  if (!seed_of(result) || !fs::is_regular_file(file) || !files::has_marker(root)) return std::nullopt;
  if (!files::FileLock::acquire_folder(root)) return std::nullopt;
  const Provenance own = provenance_of(result);
  std::vector<SeedScore> scores;
  for (const std::uint64_t seed : seeds_in(root)) try {
      const fs::path folder = root / ("seed-" + std::to_string(seed));
      if (provenance_of(folder) != own) return files::set_aside(root, {"summary.json"});
      scores.push_back(read_result(folder));
    } catch (const std::exception&) {  // incomplete
      return files::set_aside(root, {"summary.json"});
    }
  write_summary(file, summarize(scenario::read_scenario(result / "scenario.yaml").scenario, scores));
  return std::nullopt;
}

}  // namespace sim::result
