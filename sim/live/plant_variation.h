// What differs between the plant and its nominal model on a seed.
#pragma once

#include <cstdint>

#include "sim/physics/options.h"

namespace sim::live {

/// Drawn from streams named after what they vary, so that one spread set to 0 leaves the others' draws alone.
physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world);

}  // namespace sim::live
