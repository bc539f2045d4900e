// Decodes the images of recordings, which others may have made: none that is larger than its camera says.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string_view>

#include "sim/recording/image_size.h"

namespace sim::recording {

/// Throws files::FileError unless the header of a PNG, JPEG, PGM or PPM gives this size; decodes nothing.
void require_image_size(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size);

/// The image in these bytes, of the size that was asked for; flags: as of cv::imdecode. Throws
/// files::FileError, before anything is decoded where the header gives another size.
cv::Mat decode_image(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size,
                     int flags);

}  // namespace sim::recording
