// A fast decoder of grey PNG images: decoding them takes most of the time of a replay from the disk.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace sim::recording {

/// Decodes an 8-bit grey PNG image that is not interlaced, with the same pixels as cv::imdecode. Nothing
/// where the bytes are anything else or damaged. Only the checksum of the pixels is compared, not those of
/// the chunks.
std::optional<cv::Mat> decode_grey_png(std::string_view png);

}  // namespace sim::recording
