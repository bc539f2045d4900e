// Images of recordings: a fast coder of gray, color and depth PNG images (encoding takes a tenth of a run,
// decoding most of a replay from the disk), and a decoder of external ones of the camera's size.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace sim::recording {

/// Returns width and height from the header of a PNG or a JPEG; nothing for other bytes and damaged headers.
std::optional<cv::Size> image_size(std::string_view bytes);

/// Throws files::FileError unless the header of a PNG or JPEG has this size; decodes nothing.
void require_image_size(const std::filesystem::path& file, std::string_view bytes, const cv::Size& size);

/// Returns a decoded image of this size; flags: of cv::imdecode. Throws FileError; checks the size first.
cv::Mat decode_image(const std::filesystem::path& file, std::string_view bytes, const cv::Size& size,
                     int flags);

/// Returns an image as PNG: 8-bit gray (CV_8UC1), RGB in this order (CV_8UC3), or 16-bit gray (CV_16UC1). All
/// rows have the filter "up", the fastest to reverse.
std::string encode_png(const cv::Mat& image);

/// Returns an image of this type from the output of encode_png(): gray with the pixels of cv::imdecode, color
/// as RGB; nothing for other or damaged bytes. Checks only the checksum of the pixels, not those of the
/// chunks.
std::optional<cv::Mat> decode_png(std::string_view png, int type);

}  // namespace sim::recording
