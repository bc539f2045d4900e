#include "sim/tune/recording_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <vector>

#include "sim/bench/recording_keys.h"
#include "sim/bench/scenario_keys.h"
#include "sim/stream/file_error.h"
#include "sim/stream/manifest.h"

namespace sim::tune {
namespace {

namespace fs = std::filesystem;

void add_part(stream::Hash& hash, std::string_view part) {
  hash.add(fmt::format("{}:", part.size()));
  hash.add(part);
}

std::vector<fs::path> files_below(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fault))
    if (entry.is_regular_file() && entry.path().extension() != ".md") files.push_back(entry.path());
  if (fault || files.empty()) throw stream::FileError(folder, "has no models");
  std::sort(files.begin(), files.end());
  return files;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw stream::FileError(file, "cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::string models_hash(const fs::path& models) {
  stream::Hash hash;
  for (const fs::path& file : files_below(models)) {
    add_part(hash, file.lexically_relative(models).generic_string());
    add_part(hash, text_of(file));
  }
  return hash.hex();
}

std::string recording_key(const bench::Scenario& scenario, const std::string& models_hash,
                          const std::string& program) {
  stream::Hash hash;
  add_part(hash, "recording 1");
  add_part(hash, program);
  add_part(hash, models_hash);
  add_part(hash, fmt::format("seed {}", scenario.seed));
  for (const auto& key : bench::scenario_keys()) {
    if (!bench::shapes_recording(key.name) || !bench::has_section(scenario, key.name)) continue;
    add_part(hash, key.name);
    add_part(hash, key.print(scenario));
  }
  return hash.hex();
}

}  // namespace sim::tune
