#include "sim/result/run_record.h"

namespace sim::result {

Ending ending_of(const RunRecord& record) {
  if (record.ending == "completed" && record.tracked && record.tracked->diverged())
    return {"diverged", record.tracked->cause()};
  return {record.ending, record.cause};
}

}  // namespace sim::result
