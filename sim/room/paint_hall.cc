#include <cmath>

#include "sim/room/painters.h"

namespace sim::room {
namespace {

constexpr double kTile = 0.6;

Color tone(const Color& color, cv::RNG& random, double spread) {
  return shade(color, 1 + random.uniform(-spread, spread));
}

// Floor tiles with joints at (x, y) and every 0.6 m from there.
void lay_tiles(Canvas& floor, double x, double y, cv::RNG& random) {
  const Color color(168, 170, 164);
  for (double top = y - kTile; top < floor.height(); top += kTile)
    for (double left = x - kTile; left < floor.width(); left += kTile) {
      const Box tile{left, top, kTile, kTile};
      floor.fill(tile, tone(color, random, 0.035));
      floor.fill({left - 0.003, top, 0.006, kTile}, {132, 134, 130});
      floor.fill({left, top - 0.003, kTile, 0.006}, {132, 134, 130});
    }
}

void scuff(Canvas& floor, cv::RNG& random) {
  const cv::Point2d from{random.uniform(0.0, floor.width()), random.uniform(0.0, floor.height())};
  const double angle = random.uniform(0.0, 2 * CV_PI), length = random.uniform(0.05, 0.5);
  floor.line(from, from + length * cv::Point2d(std::cos(angle), std::sin(angle)), 0.006,
             tone({148, 149, 144}, random, 0.06));
}

// Tape marks at the robot's start (0, 0 of the world) and the corners of its ground.
void mark_start(Canvas& floor, cv::Point2d start) {
  const Color tape(206, 196, 120);
  floor.fill({start.x - 0.2, start.y - 0.02, 0.4, 0.04}, tape);
  floor.fill({start.x - 0.02, start.y - 0.2, 0.04, 0.4}, tape);
  for (const double x : {0.3, floor.width() - 0.3})
    for (const double y : {0.3, floor.height() - 0.3}) {
      const double dx = x < 1 ? 0 : -0.5, dy = y < 1 ? 0 : -0.5;
      floor.fill({x + dx, y - 0.02, 0.5, 0.04}, tape);
      floor.fill({x - 0.02, y + dy, 0.04, 0.5}, tape);
    }
}

void paint_locker(Canvas& row, const Box& door, int number, cv::RNG& random) {
  row.frame(door, 0.006, {70, 78, 88});
  for (int slot = 0; slot < 5; ++slot)
    row.fill({door.x + 0.08, door.y + 0.1 + 0.03 * slot, 0.14, 0.01}, {64, 72, 82});
  row.fill({door.x + 0.25, door.y + 0.85, 0.02, 0.1}, {60, 62, 66});
  row.disc({door.x + 0.26, door.y + 1.02}, 0.009, {40, 40, 42});
  row.fill({door.x + 0.1, door.y + 0.32, 0.1, 0.05}, {236, 234, 226});
  row.text(std::to_string(number), {door.x + 0.115, door.y + 0.36}, 0.03, 0.005, {40, 40, 44});
  if (random.uniform(0, 3)) return;
  row.fill({door.x + 0.06, door.y + 0.5, 0.18, 0.24}, tone({200, 170, 110}, random, 0.3));
}

}  // namespace

Canvas paint_vinyl(PaintRequest& request) {
  const bool near = request.number == 2;  // under the walk: sharper
  Canvas floor = near ? Canvas(6.0, 4.8, 0.002, {}) : Canvas(25, 11, 0.007, {});
  near ? lay_tiles(floor, 0, 0, request.random) : lay_tiles(floor, 0.5, 0.1, request.random);
  for (int scuffs = near ? 60 : 400; scuffs > 0; --scuffs) scuff(floor, request.random);
  if (near) mark_start(floor, {2.1, 2.55});
  floor.grain(request.random, 0.02, 0.5);
  floor.grain(request.random, 0.03, 0.012);
  return floor;
}

Canvas paint_hall_ceiling(PaintRequest& request) {
  Canvas module(2.4, 3.6, 0.003, {206, 206, 202});
  for (int hole = 0; hole < 1100; ++hole)
    module.fill({request.random.uniform(0.0, 2.4), request.random.uniform(0.0, 3.6), 0.012, 0.012},
                tone({160, 160, 156}, request.random, 0.15));
  for (double x = 0; x <= 2.4; x += kTile) module.fill({x - 0.012, 0, 0.024, 3.6}, {150, 150, 150});
  for (double y = 0; y <= 3.6; y += kTile) module.fill({0, y - 0.012, 2.4, 0.024}, {150, 150, 150});
  const Box lamp{kTile, 2 * kTile, 2 * kTile, kTile};
  module.light(lamp, 0.5, 1.14);
  module.fill(lamp.inset(0.012), {120, 122, 126});
  module.fill(lamp.inset(0.035), {255, 255, 250});
  for (int blade = 1; blade < 8; ++blade)
    module.fill({lamp.x + blade * lamp.width / 8 - 0.008, lamp.y + 0.035, 0.016, kTile - 0.07},
                {196, 198, 200});
  module.fill({lamp.x + 0.035, lamp.y + kTile / 2 - 0.02, lamp.width - 0.07, 0.04}, {176, 178, 180});
  return module;
}

Canvas paint_lockers(PaintRequest& request) {
  Canvas row(1.2, 1.8, 0.003, request.number % 2 ? Color(120, 138, 158) : Color(142, 148, 152));
  for (int door = 0; door < 4; ++door)
    paint_locker(row, {0.3 * door, 0.0, 0.3, 1.8}, 10 * request.number + door + 1, request.random);
  row.grain(request.random, 0.015, 0.2);
  return row;
}

Canvas paint_shutter(PaintRequest& request) {
  Canvas shutter(3.0, 2.6, 0.004, {168, 172, 174});
  for (double y = 0; y < 2.6; y += 0.1) {
    const double bright = 1 + request.random.uniform(-0.03, 0.03);
    shutter.gradient({0, y, 3.0, 0.1}, shade({188, 192, 194}, bright), shade({140, 144, 148}, bright));
    shutter.fill({0, y, 3.0, 0.008}, {96, 98, 102});
  }
  shutter.fill({0, 2.45, 3.0, 0.15}, {214, 180, 40});
  for (double x = 0; x < 3.0; x += 0.3)
    shutter.polygon({{x, 2.6}, {x + 0.15, 2.6}, {x + 0.3, 2.45}, {x + 0.15, 2.45}}, {34, 34, 36});
  shutter.fill({1.2, 1.1, 0.6, 0.3}, {238, 238, 232});
  shutter.text("KEEP CLEAR", {1.25, 1.28}, 0.055, 0.01, {170, 30, 30});
  return shutter;
}

}  // namespace sim::room
