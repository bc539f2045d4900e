// The pictures on the surfaces of the rooms, drawn from a seed.
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string_view>

#include "sim/room/canvas.h"

namespace sim::room {

/// The RGB picture of a texture, seen from its front, first row on top; empty for a name it does not know.
/// Names are a kind and a number ("books_3"): kinds share a painter, numbers differ in every random choice.
/// The same name and seed give the same bytes.
cv::Mat3b paint_texture(std::string_view name, std::uint64_t seed);

/// Sides of the office and the hall, m.
inline constexpr double kLong = 11, kShort = 7, kHigh = 3, kHallLong = 25, kHallAcross = 18;

/// Paints from a random stream of its own. number: of the texture ("books_3": 3).
using Painter = Canvas (*)(cv::RNG& random, int number);
using Painters = std::map<std::string_view, Painter>;

extern const Painters kFloorPainters, kWallPainters, kFurnishingPainters, kPaperPainters;

}  // namespace sim::room
