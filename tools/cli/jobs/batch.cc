#include "tools/cli/jobs/batch.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/files/text.h"
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
  line.insert(line.end(), {fmt::format("seed={}", seed), "--force", "--set-by",
                           (scenario.parent_path() / kSetBy).string()});
  return line;
}

}  // namespace

void take_origin(sim::scenario::ReadScenario& read, const fs::path& set_by) {
  read.origin.clear();
  for (const auto& [key, by] : sim::files::read_json(set_by).entries()) read.origin[key] = by.text();
}

std::vector<SeedOutcome> run_batch(const sim::scenario::Scenario& scenario, const Batch& batch) {
  SharedFolder shared(batch.backend);
  const fs::path frozen =
      shared / (scenario.name + ".yaml");  // so that later edits of the file change no queued seed
  sim::files::write_text(frozen, sim::scenario::to_yaml(scenario));
  sim::files::write_text(shared / kSetBy, sim::files::json_text(batch.origin));
  CommandLines lines;
  for (const std::uint64_t seed : batch.seeds) {
    fs::remove_all(batch.root /
                   fmt::format("seed-{}", seed));  // an old result must not be taken for a new one
    lines.push_back(arguments(batch, frozen, seed));
  }
  std::optional<ProgressLine> line;
  if (!batch.progress) line.emplace(fmt::format("{} seeds of {}", batch.seeds.size(), scenario.name));
  const ShowPart show = [&](double part) { line ? line->show(part) : batch.progress(part); };
  const std::vector<Ended> ended = run_all(lines, batch.backend, show);
  std::vector<SeedOutcome> outcomes;
  for (std::size_t i = 0; i < ended.size(); ++i) outcomes.push_back({ended[i], batch.seeds[i]});
  return outcomes;
}

}  // namespace cli
