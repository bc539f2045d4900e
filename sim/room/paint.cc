#include "sim/room/paint.h"

#include <cstdlib>
#include <string>

namespace sim::room {

cv::Mat3b paint_texture(std::string_view name, std::uint64_t seed) {
  const std::size_t end = name.find_last_not_of("_0123456789") + 1;
  const int number = end < name.size() ? std::atoi(std::string(name.substr(end + 1)).c_str()) : 0;
  cv::RNG random = paint_stream(seed, name);
  for (const Painters* painters : {&kFloorPainters, &kWallPainters, &kFurnishingPainters, &kPaperPainters})
    if (const auto painter = painters->find(name.substr(0, end)); painter != painters->end())
      return painter->second(random, number).image();
  return {};
}

}  // namespace sim::room
