#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/pages/figure.h"

namespace sim::pages {
namespace {

constexpr double kMargin = 0.05;  // of the range, on both sides

// The 1, 2 or 5 times a power of ten that is nearest above `rough`.
double round_step(double rough) {
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough) return factor * power;
  return 10 * power;
}

// Powers of ten; over fewer than two decades 2 and 5 times them too.
std::vector<double> decades(double low, double high) {
  std::vector<double> ticks;
  for (double exponent = std::floor(std::log10(low)); exponent <= std::floor(std::log10(high)); ++exponent)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double tick = factor * std::pow(10, exponent);
      if (tick >= low && tick <= high && (factor == 1 || high < 100 * low)) ticks.push_back(tick);
    }
  return ticks;
}

// Multiples of a round step.
std::vector<double> multiples(double low, double high, double step) {
  std::vector<double> ticks;
  for (double k = std::ceil(low / step); k * step <= high; ++k) ticks.push_back(k * step);
  return ticks;
}

Axis widened(double low, double high, bool logarithmic) {
  if (logarithmic) return {low / 1.5, high * 1.5, 0, 1, true};
  const double margin = high > low ? kMargin * (high - low) : std::max(1e-3, 0.1 * std::abs(high));
  return {low - margin, high + margin, 0, 1, false};
}

std::string superscript(int number) {
  constexpr const char* kDigits[]{"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                  "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text;
  for (const char c : fmt::format("{}", number)) text += c == '-' ? "\u207b" : kDigits[c - '0'];
  return text;
}

}  // namespace

double Axis::at(double value) const {
  const auto scale = [&](double v) { return logarithmic ? std::log(std::max(v, low * 1e-3)) : v; };
  return begin + (end - begin) * (scale(value) - scale(low)) / (scale(high) - scale(low));
}

std::vector<double> Axis::ticks(int about) const {
  if (logarithmic)
    if (std::vector<double> ticks = decades(low, high); ticks.size() > 1) return ticks;
  const double step = round_step((high - low) / about);
  return multiples(low, high, whole ? std::max(1.0, step) : step);
}

Axis axis_of(const std::vector<const std::vector<double>*>& values, bool logarithmic) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto* column : values) {
    for (const double value : *column) {
      if (!std::isfinite(value) || (logarithmic && value <= 0)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return low <= high ? widened(low, high, logarithmic) : Axis{};
}

std::string tick_text(double value) {
  const double size = std::abs(value);
  if (size < 1e-12) return "0";
  if (size >= 0.99e-3 && size < 1e5) return fmt::format("{:.6g}", value);
  int exponent = static_cast<int>(std::floor(std::log10(size) + 1e-9));
  const std::string digits = fmt::format("{:.3g}", value / std::pow(10, exponent));
  const std::string power = "10" + superscript(exponent);
  return digits == "1" ? power : digits == "-1" ? "-" + power : digits + "\u00b7" + power;
}

}  // namespace sim::pages
