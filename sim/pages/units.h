// Factors from SI to the units in which the pages show lengths and angles.
#pragma once

#include <numbers>

namespace sim::pages {

constexpr double kMm = 1e3;
constexpr double kDeg = 180 / std::numbers::pi;

}  // namespace sim::pages
