#include "sim/room/paint.h"

#include <cstdlib>
#include <functional>
#include <map>
#include <string>

#include "sim/room/painters.h"

namespace sim::room {
namespace {

using Painter = Canvas (*)(PaintRequest&);

const std::map<std::string, Painter, std::less<>> kPainters{
    {"carpet", paint_carpet},         {"ceiling", paint_ceiling},
    {"long_wall", paint_long_wall},   {"short_wall", paint_short_wall},
    {"window", paint_window},         {"door", paint_door},
    {"radiator", paint_radiator},     {"rug", paint_rug},
    {"books", paint_books},           {"desk", paint_desk},
    {"screen", paint_screen},         {"drawers", paint_drawers},
    {"cabinet", paint_cabinet},       {"fabric", paint_fabric},
    {"carton", paint_carton},         {"poster", paint_poster},
    {"whiteboard", paint_whiteboard}, {"notices", paint_notices},
    {"hall_wall", paint_hall_wall},   {"hall_ceiling", paint_hall_ceiling},
    {"vinyl", paint_vinyl},           {"lockers", paint_lockers},
    {"shutter", paint_shutter}};

}  // namespace

cv::Mat3b paint_texture(std::string_view name, std::uint64_t seed) {
  const std::size_t end = name.find_last_not_of("_0123456789") + 1;
  const auto painter = kPainters.find(name.substr(0, end));
  if (painter == kPainters.end()) return {};
  const int number = end < name.size() ? std::atoi(std::string(name.substr(end + 1)).c_str()) : 0;
  PaintRequest request{paint_stream(seed, name), number};
  return painter->second(request).image();
}

}  // namespace sim::room
