#include "tools/cli/jobs/batch.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "sim/files/atomic_file.h"
#include "sim/files/json.h"
#include "sim/files/output_manifest.h"
#include "sim/files/text.h"
#include "tools/cli/jobs/earlier.h"
#include "tools/cli/jobs/progress.h"

namespace cli {
namespace {

namespace fs = std::filesystem;

/// Name of the file beside the scenario of the batch.
constexpr const char* kSetBy = "set_by.json";

/// The command line of one seed.
std::vector<std::string> arguments(const Batch& batch, const fs::path& scenario, std::uint64_t seed) {
  const std::string name = fmt::format("seed-{}", seed);
  std::vector<std::string> line;
  if (batch.recordings)
    line = {"replay", (*batch.recordings / name).string(), "--scenario", scenario.string(),
            "--out",  (batch.root / name).string()};
  else
    line = {"run", scenario.string(), "--out", batch.root.string(), "--models", batch.models.string()};
  if (batch.cached) line.push_back("--cached");
  line.insert(line.end(), batch.more.begin(), batch.more.end());
  line.insert(line.end(), {fmt::format("seed={}", seed), "--force", "--set-by",
                           (scenario.parent_path() / kSetBy).string()});
  return line;
}

fs::path result_folder(const Batch& batch, std::uint64_t seed) {
  return batch.root / fmt::format("seed-{}", seed);
}

/// Tells a folder from the one that replaces it: device and inode. Nothing where there is none.
using Identity = std::optional<std::pair<dev_t, ino_t>>;

Identity identity_of(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0) return std::nullopt;
  return std::pair(status.st_dev, status.st_ino);
}

/// Whether the result may be of this batch though it was there when this process began: on Slurm, where the
/// process that began the batch may have been another.
bool is_of(const fs::path& result, sim::scenario::Scenario scenario, const Backend& backend,
           std::uint64_t seed) {
  if (!backend.slurm() || !fs::exists(result / "scenario.yaml")) return false;
  scenario.seed = seed;
  return sim::files::read_text(result / "scenario.yaml") == sim::scenario::to_yaml(scenario);
}

}  // namespace

void take_origin(sim::scenario::ReadScenario& read, const fs::path& set_by) {
  read.origin.clear();
  for (const auto& [key, by] : sim::files::read_json(set_by).entries()) read.origin[key] = by.text();
}

std::vector<SeedOutcome> run_batch(const sim::scenario::Scenario& scenario, const Batch& batch) {
  for (const std::uint64_t seed : batch.seeds) sim::files::require_replaceable(result_folder(batch, seed));
  SharedFolder shared(batch.backend);
  const fs::path frozen =
      shared / (scenario.name + ".yaml");  // so that later edits of the file change no queued seed
  sim::files::write_text(frozen, sim::scenario::to_yaml(scenario));
  sim::files::write_text(shared / kSetBy, sim::files::json_text(batch.origin));
  CommandLines lines;
  std::vector<Identity> before;
  for (const std::uint64_t seed : batch.seeds) {
    before.push_back(identity_of(result_folder(batch, seed)));
    lines.push_back(arguments(batch, frozen, seed));
  }
  std::optional<ProgressLine> line;
  if (!batch.progress) line.emplace(fmt::format("{} seeds of {}", batch.seeds.size(), scenario.name));
  const ShowPart show = [&](double part) { line ? line->show(part) : batch.progress(part); };
  const OnEnded on_ended = [&](std::size_t i) {
    const Identity now = identity_of(result_folder(batch, batch.seeds[i]));
    if (batch.on_made && now && now != before[i]) batch.on_made(batch.seeds[i]);
  };
  const std::vector<Ended> ended = run_all(lines, batch.backend, show, on_ended);
  std::vector<SeedOutcome> outcomes;
  std::vector<std::string> not_replaced;
  for (std::size_t i = 0; i < ended.size(); ++i) {
    outcomes.push_back({ended[i], batch.seeds[i]});
    const fs::path result = result_folder(batch, batch.seeds[i]);
    if (before[i] && identity_of(result) == before[i] &&
        !is_of(result, scenario, batch.backend, batch.seeds[i]))
      not_replaced.push_back(result.filename());
  }
  set_aside(batch.root, not_replaced);
  sim::files::remove_leftovers(batch.root);  // of processes that crashed
  return outcomes;
}

}  // namespace cli
