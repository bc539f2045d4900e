// Differences between the plant and its nominal model, by seed.
#pragma once

#include <cstdint>

#include "sim/physics/options.h"

namespace sim::live {

/// Each is drawn from its named stream, so that setting one spread to 0 does not change the others.
physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world);

}  // namespace sim::live
