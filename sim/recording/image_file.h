// Decodes the images of recordings, which may be external: only those of the camera's size.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace sim::recording {

struct ImageSize {
  int width = 0, height = 0;  ///< px
  bool operator==(const ImageSize&) const = default;
};

/// Returns width and height from the header of a PNG, a JPEG or a binary PGM or PPM; nothing for other bytes,
/// damaged headers, and more than 2^30 pixels a side.
std::optional<ImageSize> image_size(std::string_view bytes);

/// Throws files::FileError unless the header of a PNG, JPEG, PGM or PPM has this size; decodes nothing.
void require_image_size(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size);

/// Decodes an image of this size; flags: as of cv::imdecode. Throws files::FileError, before decoding if the
/// header has another size.
cv::Mat decode_image(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size,
                     int flags);

}  // namespace sim::recording
