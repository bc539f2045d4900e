#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>

#include "sim/files/text.h"
#include "sim/recording/cache.h"
#include "tools/cli/commands.h"

namespace cli {
namespace {

using sim::recording::Cache;

constexpr const char* kCacheExamples = R"(
Examples:
  gaitslam cache list
  gaitslam cache clean            # removes all recordings that are not in use
  gaitslam cache clean --to 5     # removes the least recently used until 5 GB are left)";

constexpr double kGigabyte = 1e9, kMegabyte = 1e6;

int list() {
  const Cache cache(sim::recording::cache_place());
  std::uintmax_t total = 0;
  for (const Cache::Entry& entry : cache.list()) {
    total += entry.bytes;
    std::cout << fmt::format("{}  {:>6.1f} MB  {:%Y-%m-%d %H:%M}  {} seed {}{}\n", entry.key,
                             static_cast<double>(entry.bytes) / kMegabyte,
                             fmt::localtime(entry.last_used_ns / 1'000'000'000), entry.scenario, entry.seed,
                             entry.in_use ? "  (in use)" : "");
  }
  std::cout << fmt::format("{:.2f} of {:.2f} GB in {}\n", static_cast<double>(total) / kGigabyte,
                           static_cast<double>(cache.place().most_bytes) / kGigabyte,
                           cache.place().folder.string());
  return 0;
}

int clean(double gigabytes) {
  const Cache cache(sim::recording::cache_place());
  const Cache::Cleaned cleaned = cache.clean(static_cast<std::uintmax_t>(gigabytes * kGigabyte));
  std::cout << fmt::format("{} removed, {:.2f} GB; {} kept because they are in use\n",
                           sim::files::counted(cleaned.removed, "recording"),
                           static_cast<double>(cleaned.bytes) / kGigabyte, cleaned.in_use);
  if (cleaned.foreign > 0)
    std::cout << fmt::format("{} kept because of files that gaitslam did not make\n",
                             sim::files::counted(cleaned.foreign, "recording"));
  return 0;
}

}  // namespace

void add_cache(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("cache", "List or remove the recordings that are kept for replays");
  command->require_subcommand(1);
  command->footer(kCacheExamples);
  CLI::App* lister = command->add_subcommand("list", "List the recordings, the least recently used first");
  lister->callback([&exit_code] { exit_code = list(); });
  auto gigabytes = std::make_shared<double>(0);
  CLI::App* cleaner = command->add_subcommand("clean", "Remove recordings that are not in use");
  cleaner->add_option("--to", *gigabytes, "remove until at most this many GB are left")
      ->check(CLI::Range(0.0, 1e9));
  cleaner->callback([gigabytes, &exit_code] { exit_code = clean(*gigabytes); });
}

}  // namespace cli
