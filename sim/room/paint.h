// The pictures on the office's surfaces, drawn from a seed.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string_view>

namespace sim::room {

/// The RGB picture of a texture, seen from its front, first row on top; empty for a name it does not know.
/// Names are a kind and a number ("books_3"): kinds share a painter, numbers differ in every random choice.
/// The same name and seed give the same bytes.
cv::Mat3b paint_texture(std::string_view name, std::uint64_t seed);

}  // namespace sim::room
