#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ostream>
#include <set>

#include "sim/files/text.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

std::vector<std::string> results_of_other_seeds(const fs::path& root,
                                                const std::vector<std::uint64_t>& seeds) {
  std::set<std::uint64_t> others;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root, none)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with("seed-") || !fs::exists(entry.path() / "score.json", none)) continue;
    const auto seed = sim::files::parse_number<std::uint64_t>(std::string_view(name).substr(5));
    if (!seed || name != fmt::format("seed-{}", *seed)) continue;  // the program writes no seed-07
    if (std::find(seeds.begin(), seeds.end(), *seed) == seeds.end()) others.insert(*seed);
  }
  std::vector<std::string> names;
  for (const std::uint64_t seed : others) names.push_back(fmt::format("seed-{}", seed));
  return names;
}

void set_aside(const fs::path& root, const std::vector<std::string>& names) {
  if (names.empty()) return;
  int n = 1;
  while (fs::exists(fs::symlink_status(root / fmt::format("earlier-{}", n)))) ++n;
  const fs::path aside = root / fmt::format("earlier-{}", n);
  fs::create_directory(aside);
  for (const std::string& name : names) fs::rename(root / name, aside / name);
  text_out() << fmt::format("results of an earlier command are now in {}: {}\n", aside.string(),
                            fmt::join(names, ", "));
}

}  // namespace cli
