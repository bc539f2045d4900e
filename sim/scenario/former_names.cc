#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "sim/scenario/keys.h"

namespace sim::scenario {
namespace {

/// A key or metric of an earlier version: its name now, or empty and the reason why it is gone.
struct Former {
  std::string_view name, now, reason = {};
};
constexpr Former kFormer[]{
    {"slam.vision.sigma_lasting_px", "slam.vision.match_bias_sigma_px"},
    {"slam.vision.sigma_view_px", "slam.vision.viewpoint_sigma_px"},
};

}  // namespace

std::string former_name(std::string_view name) {
  const auto* const found = std::find_if(std::begin(kFormer), std::end(kFormer),
                                         [&](const Former& former) { return former.name == name; });
  if (found == std::end(kFormer)) return "";
  return found->now.empty() ? fmt::format("is gone: {}", found->reason)
                            : fmt::format("was renamed to {}", found->now);
}

}  // namespace sim::scenario
