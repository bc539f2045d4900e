// What differs between the plant and its nominal model on a seed.
#pragma once

#include <cstdint>

#include "sim/world/options.h"

namespace sim::live {

/// Drawn from streams named after what they vary, so that one spread set to 0 leaves the others' draws alone.
world::Draw draw(std::uint64_t seed, const world::WorldOptions& world);

}  // namespace sim::live
