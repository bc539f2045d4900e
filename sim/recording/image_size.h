// Width and height of an image from its header, before anything of it is decoded.
#pragma once

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

}  // namespace sim::recording
