// Images of recordings: a fast codec for gray, color and depth PNG images (encoding takes a tenth of a run,
// decoding most of a replay from disk), and a decoder for external images of the camera's size.
#pragma once

#include <opencv2/core.hpp>

#include "sim/files/text.h"

namespace sim::recording {

/// Throws files::FileError if the image has another size than its camera.
void require_size(const fs::path& file, const cv::Mat& image, const cv::Size& size);

/// Returns the gray pixels of an image of this size as stored: an orientation in its metadata (EXIF) does not
/// turn them. Throws FileError.
cv::Mat decode_image(const fs::path& file, std::string_view bytes, const cv::Size& size);

/// Returns an image as PNG: 8-bit gray (CV_8UC1), RGB in this order (CV_8UC3), or 16-bit gray (CV_16UC1). All
/// rows use the filter "up", the fastest to reverse.
std::string encode_png(const cv::Mat& image);

/// Returns an image of this type from the output of encode_png(): gray with the pixels of cv::imdecode, color
/// as RGB; nothing for other or damaged bytes. Checks only the checksum of the pixels, not the chunks'
/// checksums.
std::optional<cv::Mat> decode_png(std::string_view png, int type);

}  // namespace sim::recording
