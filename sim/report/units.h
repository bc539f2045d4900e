// Factors from SI to the units in which the pages show lengths and angles.
#pragma once

#include <numbers>

namespace sim::report {

constexpr double kMm = 1e3;
constexpr double kDeg = 180 / std::numbers::pi;

}  // namespace sim::report
