// Pictures of a recording for a page: frames along the walk, as data that a page holds in itself.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "sim/report/run_data.h"

namespace sim::report {

/// [{t (s), uri}] of frames evenly over the walk; empty if the result holds no recording with pictures.
nlohmann::ordered_json pictures(const RunData& run);

/// RFC 4648.
std::string base64(std::string_view bytes);

}  // namespace sim::report
