#include "sim/result/run_record.h"

namespace sim::result {

Ending ending_of(const RunRecord& record) {
  // A robot that was to be steered by the estimator that failed stops for that reason.
  if ((record.ending == "completed" || record.ending == "stopped") && record.tracked &&
      record.tracked->failed)
    return {"estimator_failed", *record.tracked->failed};
  if (record.ending == "completed" && record.tracked && record.tracked->diverged())
    return {"diverged", record.tracked->cause()};
  return {record.ending, record.cause};
}

}  // namespace sim::result
