// Which keys of a scenario shape what ideal sensors record.
#pragma once

#include <string_view>

namespace sim::bench {

/// True for a key of the table below walk, stabilizer, world or camera. Sensor errors, filter, limits and the
/// name shape no recording; the seed does.
bool shapes_recording(std::string_view key);

}  // namespace sim::bench
