// Grey PNG pictures decoded fast: what most of a replay from the disk is spent on.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace sim::stream {

/// An 8-bit grey PNG picture, not interlaced, pixels as cv::imdecode has them. Nothing where the bytes are
/// anything else, or damaged; of each chunk's checksum that of the pixels alone is looked at.
std::optional<cv::Mat> decode_grey_png(std::string_view png);

}  // namespace sim::stream
