// Images of recordings: a fast codec for gray, color and depth PNG images (encoding takes a tenth of a run,
// decoding most of a replay from disk), and a decoder for external images of the camera's size.
#pragma once

#include <opencv2/core.hpp>

#include "sim/files/text.h"

namespace sim::recording {

/// The header of an image: its size, and the number and bits of a pixel's samples.
struct ImageHeader {
  cv::Size size;
  int channels = 1, bits = 8;
  std::size_t bytes = 0;  ///< from the file's start to the end of the header
};

/// Returns the header of a PNG or JPEG, or nothing for other bytes and damaged headers.
std::optional<ImageHeader> image_header(std::string_view bytes);

/// Throws files::FileError unless these bytes are a PNG or JPEG with this size in its header; decodes
/// nothing.
void require_image_size(const fs::path& file, std::string_view bytes, const cv::Size& size);

/// Returns the header of a file after require_image_size(). A file that does not end the way an image does is
/// decoded, because it may be cut off. Throws FileError.
ImageHeader check_image(const fs::path& file, const cv::Size& size);

/// Returns the gray pixels of an image of this size as stored: an orientation in its metadata (EXIF) is
/// ignored. Checks the size first. Throws FileError.
cv::Mat decode_image(const fs::path& file, std::string_view bytes, const cv::Size& size);

/// Returns an image as PNG: 8-bit gray (CV_8UC1), RGB in this order (CV_8UC3), or 16-bit gray (CV_16UC1). All
/// rows use the filter "up", the fastest to reverse.
std::string encode_png(const cv::Mat& image);

/// Returns an image of this type from the output of encode_png(): gray with the pixels of cv::imdecode, color
/// as RGB; nothing for other or damaged bytes. Checks only the checksum of the pixels, not the chunks'
/// checksums.
std::optional<cv::Mat> decode_png(std::string_view png, int type);

}  // namespace sim::recording
