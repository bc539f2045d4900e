// Metrics of the filter's consistency: NEES of the camera pose, NIS of each sensor.
#pragma once

#include "sim/score/metric.h"

namespace sim::score {

MetricDefinitions consistency_metrics();

}  // namespace sim::score
