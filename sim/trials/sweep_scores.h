// The results of a sweep: one line for each trial, in the order of the plan, and a table of medians.
#pragma once

#include <functional>
#include <string>

#include "sim/trials/log.h"
#include "sim/trials/sweep.h"

namespace sim::trials {

/// Returns the record of the i-th trial of the plan, or nullptr if it has none.
using RecordOf = std::function<const TrialRecord*(std::size_t)>;

/// One line for each trial that has a record, after a line of titles (RFC 4180).
std::string scores_csv(const SweepPlan& plan, const RecordOf& record);

/// One line of JSON for each trial that has a record.
std::string scores_jsonl(const SweepPlan& plan, const RecordOf& record);

/// Medians over the seeds of each configuration, of the first forty.
std::string sweep_table(const SweepPlan& plan, const RecordOf& record);

}  // namespace sim::trials
