#include "sim/result/limits.h"

#include <algorithm>

#include "sim/result/json.h"
#include "sim/result/table_style.h"
#include "sim/scenario/limits.h"

namespace sim::result {

JudgedLimit judge(const scenario::Scenario& scenario, const scenario::MetricLimit& limit,
                  std::optional<double> value) {
  if (!value && !scenario.slam) return {limit, {}, {}};
  return {limit, value, value && keeps(limit, *value)};
}

std::vector<JudgedLimit> judge_run(const scenario::Scenario& scenario,
                                   const std::function<std::optional<double>(const std::string&)>& value_of) {
  std::vector<JudgedLimit> all;
  for (const scenario::MetricLimit& limit : scenario.limits.metrics)
    if (limit.aggregate.empty()) all.push_back(judge(scenario, limit, value_of(limit.metric)));
  return all;
}

bool is_allowed(const scenario::Scenario& scenario, scenario::Ending ending) {
  const auto& allowed = scenario.limits.ending;
  return std::find(allowed.begin(), allowed.end(), scenario::name_of(ending)) != allowed.end();
}

int exit_code(const scenario::Scenario& scenario, scenario::Ending ending,
              const std::vector<JudgedLimit>& limits) {
  if (!is_allowed(scenario, ending)) return scenario::exit_code_of(ending);
  const auto missed = [](const JudgedLimit& judged) { return judged.missed(); };
  return std::any_of(limits.begin(), limits.end(), missed) ? 1 : 0;
}

score::Worst worst_side(const scenario::MetricLimit& limit) {
  return limit.bound == scenario::Bound::at_most ? score::Worst::largest : score::Worst::smallest;
}

std::string_view verdict_word(std::optional<bool> passed) {
  return !passed ? "not judged" : *passed ? "ok" : "MISSED";
}

std::string verdict_text(std::optional<bool> passed, bool colours) {
  const Paint paint = !passed ? Paint::none : *passed ? Paint::good : Paint::bad;
  return painted(std::string(verdict_word(passed)), paint, colours);
}

nlohmann::ordered_json to_json(const JudgedLimit& judged) {
  nlohmann::ordered_json json{{"metric", subject(judged.limit)},
                              {std::string(word(judged.limit.bound)), judged.limit.value},
                              {"value", or_null(judged.value)},
                              {"passed", or_null(judged.passed)}};
  if (!judged.reason.empty()) json["reason"] = judged.reason;
  return json;
}

}  // namespace sim::result
