#include "sim/score/evaluate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/score/metric_table.h"

namespace sim::score {
namespace {

using std::string_view_literals::operator""sv;

/// What compares lengths of the estimate with true ones, unless it fits the scale itself.
constexpr std::array kScaled{"ate_se3_rmse_m"sv,
                             "rmse_m"sv,
                             "ate_yaw_rmse_m"sv,
                             "ate_origin_rmse_m"sv,
                             "rmse_x_m"sv,
                             "rmse_y_m"sv,
                             "rmse_z_m"sv,
                             "scale_error_percent"sv,
                             "rpe_25cm_m"sv,
                             "rpe_50cm_m"sv,
                             "rpe_1m_m"sv,
                             "rpe_2m_m"sv,
                             "rpe_4m_m"sv,
                             "rpe_1s_m"sv,
                             "rpe_step_m"sv,
                             "drift_percent"sv,
                             "height_range_m"sv,
                             "end_error_x_m"sv,
                             "end_error_y_m"sv,
                             "end_error_z_m"sv,
                             "end_position_error_m"sv,
                             "loop_error_before_m"sv,
                             "loop_error_after_m"sv,
                             "loop_correction_m"sv,
                             "loop_sigma_before_m"sv,
                             "loop_sigma_after_m"sv,
                             "nees_position_mean"sv,
                             "nees_position_variance"sv,
                             "nees_position_within_95"sv,
                             "landmark_rmse_m"sv,
                             "landmark_median_m"sv,
                             "landmark_nees_mean"sv};

Metric metric(const MetricRow& row, const Scored& scored) {
  const bool scaled = std::find(kScaled.begin(), kScaled.end(), row.definition.name) != kScaled.end();
  const std::string& no_scale = scored.run.no_scale;
  Value value = scaled && !no_scale.empty() ? Value::none(no_scale) : row.value(scored);
  if (value.value && !std::isfinite(*value.value)) value = Value::none("the value is not finite");
  return {value.value, row.definition.unit, value.reason};
}

}  // namespace

const std::vector<MetricDefinition>& metric_definitions() {
  static const std::vector<MetricDefinition> definitions = [] {
    std::vector<MetricDefinition> all;
    for (const MetricRow& row : metric_rows()) all.push_back(row.definition);
    return all;
  }();
  return definitions;
}

const MetricDefinition* find_metric(std::string_view name) {
  const auto& all = metric_definitions();
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == name; });
  return found == all.end() ? nullptr : &*found;
}

Metrics evaluate(const Run& run) { return evaluate(Scored(run)); }

Metrics evaluate(const Scored& scored) {
  Metrics metrics;
  for (const MetricRow& row : metric_rows()) metrics.emplace(row.definition.name, metric(row, scored));
  return metrics;
}

}  // namespace sim::score
