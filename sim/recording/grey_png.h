// A fast coder of grey PNG images: encoding takes a tenth of a run, decoding most of a replay from the disk.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace sim::recording {

/// Decodes an 8-bit grey PNG image that is not interlaced, to the same pixels as cv::imdecode. Returns
/// nothing for other or damaged bytes; checks only the checksum of the pixels, not those of the chunks.
std::optional<cv::Mat> decode_grey_png(std::string_view png);

/// Encodes an 8-bit grey image as PNG. All rows have the filter "up", the fastest to reverse.
std::string encode_grey_png(const cv::Mat& image);

}  // namespace sim::recording
