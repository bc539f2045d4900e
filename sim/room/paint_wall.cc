// Walls and what is part of them.
#include <cmath>

#include "sim/room/paint.h"

namespace sim::room {
namespace {

// Skirting, sockets, scuffs and the darkening towards ceiling and floor that every wall has.
Canvas plain_wall(double width, const Color& color, cv::RNG& random) {
  Canvas wall(width, kHigh, 0.005, color);
  const double w = wall.width(), h = wall.height();
  for (double x = 0.7 + random.uniform(0.0, 0.6); x < w - 0.3; x += random.uniform(1.4, 2.4)) {
    const Box socket{x, h - 0.36, 0.16, 0.085};
    wall.fill(socket, {225, 225, 222});
    wall.frame(socket, 0.006, {120, 120, 120});
    wall.disc({x + 0.042, h - 0.318}, 0.022, {70, 70, 70});
    wall.disc({x + 0.118, h - 0.318}, 0.022, {70, 70, 70});
  }
  wall.grain(random, 0.012, 0.25);
  wall.grain(random, 0.014, 0.012);
  wall.light({-1, -1, w + 2, 1.05}, 0.35, 0.90);
  wall.light({-1, h - 0.25, w + 2, 1}, 0.30, 0.86);
  wall.light({-1, -1, 1.1, h + 2}, 0.35, 0.92);
  wall.light({w - 0.1, -1, 1.1, h + 2}, 0.35, 0.92);
  wall.fill({0, h - 0.10, w, 0.10}, {92, 84, 76});
  wall.fill({0, h - 0.105, w, 0.01}, {150, 142, 132});
  return wall;
}

void paint_building(Canvas& view, const Box& body, cv::RNG& random) {
  static const Color kFacades[] = {
      {196, 178, 150}, {170, 112, 88}, {150, 152, 156}, {206, 196, 176}, {122, 136, 150}};
  const Color wall = random_shade(kFacades[random.uniform(0, 5)], random, 0.2);
  view.fill(body, wall);
  const double storey = random.uniform(0.07, 0.11), bay = random.uniform(0.06, 0.1);
  for (double y = body.y + 0.03; y < body.y + body.height; y += storey)
    for (double x = body.x + 0.02; x + bay * 0.6 < body.x + body.width - 0.01; x += bay)
      view.fill({x, y, bay * 0.6, storey * 0.55}, shade({60, 75, 95}, random.uniform(0.6, 1.6)));
  view.fill({body.x, body.y, body.width, 0.012}, shade(wall, 0.6));
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
  row.fill({door.x + 0.06, door.y + 0.5, 0.18, 0.24}, random_shade({200, 170, 110}, random, 0.3));
}

Canvas paint_long_wall(cv::RNG& random, int number) {
  return plain_wall(kLong, number == 1 ? Color(214, 212, 204) : Color(206, 204, 190), random);
}

Canvas paint_short_wall(cv::RNG& random, int number) {
  return plain_wall(kShort, number == 1 ? Color(196, 200, 206) : Color(212, 206, 194), random);
}

Canvas paint_hall_wall(cv::RNG& random, int number) {
  static const Color kColors[] = {{208, 206, 200}, {214, 212, 204}, {190, 196, 198}, {206, 202, 192}};
  return plain_wall(number <= 2 ? kHallLong : kHallAcross, kColors[(number + 3) % 4], random);
}

Canvas paint_window(cv::RNG& random, int) {
  Canvas view(2.2, 1.6, 0.004, {180, 205, 235});
  view.gradient(view.all(), {150, 190, 238}, {226, 234, 240});
  for (int cloud = 0; cloud < 40; ++cloud) {
    const Box wisp{random.uniform(-0.3, 2.2), random.uniform(-0.1, 0.6), random.uniform(0.1, 0.4), 0.04};
    view.light(wisp, 0.06, random.uniform(1.0, 1.14));
  }
  for (double x = -0.1; x < 2.2;) {
    const double width = random.uniform(0.25, 0.6), top = random.uniform(0.35, 1.0);
    paint_building(view, {x, top, width, 1.6 - top}, random);
    x += width + random.uniform(-0.02, 0.15);
  }
  for (int leaf = 0; leaf < 700; ++leaf) {
    const double x = random.uniform(-0.05, 2.25), y = view.height() - std::abs(random.gaussian(0.13));
    const double radius = random.uniform(0.012, 0.04);
    view.disc({x, y}, radius, shade({70, 105, 50}, random.uniform(0.5, 1.4)));
  }
  view.frame(view.all(), 0.06, {236, 236, 232});
  view.frame(view.all().inset(0.055), 0.012, {120, 122, 124});
  view.fill({1.065, 0, 0.07, 1.6}, {236, 236, 232});
  view.fill({1.062, 0.06, 0.008, 1.48}, {120, 122, 124});
  view.fill({1.13, 0.06, 0.008, 1.48}, {120, 122, 124});
  view.fill({1.145, 0.78, 0.02, 0.12}, {90, 90, 92});
  return view;
}

Canvas paint_door(cv::RNG& random, int number) {
  Canvas door(0.95, 2.1, 0.0035, number == 1 ? Color(150, 112, 74) : Color(120, 132, 142));
  door.grain(random, 0.05, 0.02);
  for (int vein = 0; number == 1 && vein < 60; ++vein) {
    const double x = random.uniform(0.0, 0.95), end = x + random.uniform(-0.03, 0.03);
    door.line({x, 0}, {end, 2.1}, 0.004, random_shade({140, 102, 66}, random, 0.15));
  }
  door.frame(door.all(), 0.06, {205, 202, 196});
  door.frame(door.all().inset(0.058), 0.01, {70, 60, 50});
  const Box pane{0.58, 0.35, 0.2, 0.85};
  door.fill(pane, {150, 170, 180});
  door.frame(pane, 0.015, {80, 70, 60});
  door.fill({0.11, 1.02, 0.05, 0.2}, {190, 190, 192});
  door.fill({0.11, 1.06, 0.15, 0.028}, {90, 90, 94});
  const Box sign{0.24, 0.5, 0.24, 0.16};
  door.fill(sign, {240, 240, 236});
  door.text(number == 1 ? "2.17" : "EXIT", {0.26, 0.59}, 0.06, 0.009, {30, 60, 120});
  door.fill({0.26, 0.615, 0.2, 0.012}, {120, 120, 120});
  return door;
}

Canvas paint_radiator(cv::RNG&, int) {
  Canvas radiator(1.8, 0.6, 0.004, {228, 228, 224});
  for (double x = 0.03; x < 1.77; x += 0.06) {
    radiator.fill({x, 0.04, 0.018, 0.52}, {150, 150, 148});
    radiator.fill({x + 0.018, 0.04, 0.008, 0.52}, {196, 196, 194});
  }
  radiator.fill({0, 0, 1.8, 0.03}, {205, 205, 202});
  radiator.frame(radiator.all(), 0.008, {130, 130, 128});
  return radiator;
}

Canvas paint_lockers(cv::RNG& random, int number) {
  Canvas row(1.2, 1.8, 0.003, number % 2 ? Color(120, 138, 158) : Color(142, 148, 152));
  for (int door = 0; door < 4; ++door)
    paint_locker(row, {0.3 * door, 0.0, 0.3, 1.8}, 10 * number + door + 1, random);
  row.grain(random, 0.015, 0.2);
  return row;
}

Canvas paint_shutter(cv::RNG& random, int) {
  Canvas shutter(3.0, 2.6, 0.004, {168, 172, 174});
  for (double y = 0; y < 2.6; y += 0.1) {
    const double bright = 1 + random.uniform(-0.03, 0.03);
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

}  // namespace

const Painters kWallPainters{{"long_wall", paint_long_wall}, {"short_wall", paint_short_wall},
                             {"hall_wall", paint_hall_wall}, {"window", paint_window},
                             {"door", paint_door},           {"radiator", paint_radiator},
                             {"lockers", paint_lockers},     {"shutter", paint_shutter}};

}  // namespace sim::room
