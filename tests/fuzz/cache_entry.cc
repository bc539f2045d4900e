// entry.json of the cache: a damaged entry is listed and never taken for a whole one.
#include "sim/files/owned_folder.h"
#include "sim/recording/manifest.h"
#include "sim/recording/cache.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

const std::string kKey(32, 'a');

bool make_entry() {
  std::filesystem::create_directories(fuzz::folder() / kKey / "result/recording");
  sim::recording::ManifestWriter(fuzz::folder() / kKey / "result/recording").finish();
  sim::files::write_text(fuzz::folder() / kKey / sim::files::kMarker, sim::files::marker_of_all(fuzz::folder() / kKey));
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool made = make_entry();
  if (!made) return 0;
  fuzz::file(kKey + "/entry.json", fuzz::text_of(data, size));
  const sim::recording::Cache cache({fuzz::folder()});
  fuzz::require(cache.list().size() == 1);
  cache.find(kKey, [](const std::string&) {});
  return 0;
}
