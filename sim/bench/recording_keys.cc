#include "sim/bench/recording_keys.h"

#include <algorithm>
#include <array>

#include "sim/bench/scenario_keys.h"

namespace sim::bench {

bool shapes_recording(std::string_view key) {
  static constexpr std::array<std::string_view, 4> kSections{"walk", "stabilizer", "world", "camera"};
  const std::string_view section = key.substr(0, key.find('.'));
  return find_key(key) && std::find(kSections.begin(), kSections.end(), section) != kSections.end();
}

}  // namespace sim::bench
