// Decodes the images of recordings, which others may have made: none that is larger than its camera says.
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

/// Of a PNG, a JPEG or a binary PGM or PPM. Nothing where the bytes are no such file, or its header is
/// damaged or gives more than 2^30 pixels a side.
std::optional<ImageSize> image_size(std::string_view bytes);

/// Throws files::FileError unless the header of a PNG, JPEG, PGM or PPM gives this size; decodes nothing.
void require_image_size(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size);

/// The image in these bytes, of the size that was asked for; flags: as of cv::imdecode. Throws
/// files::FileError, before anything is decoded where the header gives another size.
cv::Mat decode_image(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size,
                     int flags);

}  // namespace sim::recording
