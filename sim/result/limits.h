// The limits of a scenario, judged: on the metrics of one run, on their aggregates over seeds, and on the
// ways in which a run may end.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/score/statistics.h"

namespace sim::result {

/// A limit on a metric or on an aggregate of it over seeds. A limit whose value is absent is missed, unless
/// no filter was to run: then it is not judged and `passed` is absent too. reason: why the value is
/// absent, of a limit over seeds; else empty.
struct JudgedLimit {
  scenario::MetricLimit limit;
  std::optional<double> value;
  std::optional<bool> passed;
  std::string reason = {};

  bool missed() const { return passed && !*passed; }
};

JudgedLimit judge(const scenario::Scenario& scenario, const scenario::MetricLimit& limit,
                  std::optional<double> value);

/// The limits on each run (those without an aggregate) for one run. value_of: of a metric by its name.
std::vector<JudgedLimit> judge_run(const scenario::Scenario& scenario,
                                   const std::function<std::optional<double>(const std::string&)>& value_of);

/// Whether the scenario allows a run to end like that.
bool is_allowed(const scenario::Scenario& scenario, scenario::Ending ending);

/// Of a run: 3 if it ended in a way that the scenario does not allow, 1 if it missed a limit, else 0.
int exit_code(const scenario::Scenario& scenario, scenario::Ending ending,
              const std::vector<JudgedLimit>& limits);

/// Which of several values is nearest to missing the limit.
score::Worst worst_side(const scenario::MetricLimit& limit);

/// "ok", "MISSED" or "not judged", for tables.
std::string_view verdict_word(std::optional<bool> passed);
/// The same in green or red, where colours are wanted.
std::string verdict_text(std::optional<bool> passed, bool colours);

/// {"metric": "ate_se3_rmse_m.median", "at_most": 0.1, "value": 0.2, "passed": false}
nlohmann::ordered_json to_json(const JudgedLimit& judged);

}  // namespace sim::result
