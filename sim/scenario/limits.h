// Limits on metrics: `ate_se3_rmse_m: {at_most: 0.1}`, `ate_se3_rmse_m.median: {at_most: 0.05}`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/options.h"
#include "sim/scenario/yaml.h"

namespace sim::scenario {

/// Returns the error for a name that is not a metric: its present name if it is a former one, else the
/// nearest metric.
std::string unknown_metric(std::string_view name);

/// Reads limits.<metric>[.<aggregate>].<bound>, replacing an earlier limit of the same name. key: that whole
/// name; named_at: its place. Throws ConfigError.
void read_limit(const Yaml& named_at, const std::string& key, const Yaml& value,
                std::vector<MetricLimit>& limits);

/// True if the value satisfies the limit.
bool keeps(const MetricLimit& limit, double value);

/// "ate_se3_rmse_m.median"
std::string subject(const MetricLimit& limit);
/// "at_most" or "at_least"
std::string_view word(Bound bound);

}  // namespace sim::scenario
