// Test fixture that walks short scenarios in a temporary folder.
#pragma once

#include "sim/live/run.h"
#include "sim/replay/replay.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/result/result_folder.h"

namespace tests {

class RunFolder : public testing::Test {
 protected:
  static sim::scenario::ReadScenario read(const char* text, const std::vector<std::string>& overrides = {},
                                          const std::vector<std::string>& without = {}) {
    return sim::scenario::read_scenario_text(text, "walk.yaml", {overrides, without});
  }
  sim::result::ResultPlace place(const std::string& name, const std::string& models = kModels) const {
    return {folder_ / name, models, "1", "test", {}};
  }
  sim::result::Outcome run(const std::string& name, const sim::scenario::ReadScenario& scenario,
                           int threads = 1) const {
    return sim::live::run(
        scenario, place(name), [](double) {}, threads);
  }
  sim::result::Outcome replay(const std::string& of, const std::string& name,
                              const sim::scenario::ReadScenario& scenario) const {
    return sim::replay::replay(scenario, folder_ / of / "recording", {{sim::scenario::Ending::completed}},
                               place(name), [](double) {});
  }
  /// Names of files that differ between a run's result and its replay's.
  std::vector<std::string> changed_by_replay(const std::string& live, const std::string& replayed) const {
    return differences(files(folder_ / live, "recording/"), files(folder_ / replayed));
  }
  std::string file(const std::string& result, const std::string& name) const {
    return sim::files::read_text(folder_ / result / name);
  }
  nlohmann::json json(const std::string& result, const std::string& name) const {
    return json_of(folder_ / result / name);
  }
  double score(const std::string& result, const std::string& name) const {
    return metric(folder_ / result, name);
  }

  static inline const std::filesystem::path kModels = std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models";

 private:
  const sim::files::TemporaryFolder temporary_;

 protected:
  const std::filesystem::path folder_ = temporary_.path();
};

}  // namespace tests
