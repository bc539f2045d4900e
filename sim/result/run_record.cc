#include "sim/result/run_record.h"

namespace sim::result {

scenario::Ended ending_of(const RunRecord& record) {
  using enum scenario::Ending;
  const auto failure = record.tracked ? record.tracked->failure() : std::nullopt;
  // A robot stops if the estimator that steers it fails.
  const bool explains_stop = record.walk.ending == stopped && failure && failure->ending == estimator_failed;
  return failure && (record.walk.ending == completed || explains_stop) ? *failure : record.walk;
}

}  // namespace sim::result
