#include "tools/cli/finished.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/files/text.h"
#include "sim/result/about_file.h"
#include "sim/tune/trial_log.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace fs = std::filesystem;

/// Whether this program made the result: by its revision, and where the sources differ from their revision
/// also by the times of the files.
bool is_by_this_program(const fs::path& result) try {
  if (sim::result::read_about(result / "about.json").revision != kRevision) return false;
  const bool exact = !std::string(kRevision).ends_with("+") && kRevision != std::string("unknown");
  return exact || fs::last_write_time(result / "about.json") > fs::last_write_time("/proc/self/exe");
} catch (const sim::files::FileError&) {
  return false;  // a damaged result is made again
}

}  // namespace

bool is_finished(const fs::path& result, sim::scenario::Scenario scenario, std::uint64_t seed) {
  for (const char* file : {"score.json", "about.json", "scenario.yaml"})
    if (!fs::is_regular_file(result / file)) return false;
  scenario.seed = seed;
  return is_by_this_program(result) &&
         sim::files::read_text(result / "scenario.yaml") == sim::scenario::to_yaml(scenario);
}

std::vector<std::uint64_t> unfinished(const OutFolder& out, const std::string& within,
                                      const sim::scenario::Scenario& scenario,
                                      const std::vector<std::uint64_t>& seeds) {
  std::vector<std::uint64_t> left;
  for (const std::uint64_t seed : seeds)
    if (const std::string name = fmt::format("{}seed-{}", within, seed);
        !out.has_made(name) || !is_finished(out.path() / name, scenario, seed))
      left.push_back(seed);
  return left;
}

std::string inputs_of(const sim::scenario::Scenario& scenario) {
  return sim::scenario::to_yaml(scenario) + sim::estimators::estimator_files_identity(scenario.estimator);
}

std::string identity_of_runs(const std::vector<std::string>& scenarios,
                             const std::vector<std::uint64_t>& seeds, const std::string& options) {
  return sim::tune::trial_key({program_identity(), fmt::format("{}", fmt::join(scenarios, "\n---\n")),
                               fmt::format("{}", fmt::join(seeds, ",")), options});
}

}  // namespace cli
