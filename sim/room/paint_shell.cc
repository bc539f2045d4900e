// Floors, ceilings and walls, with everything that is part of them.
#include <cmath>

#include "sim/room/paint.h"

namespace sim::room {
namespace {

constexpr double kTile = 0.6;

// Floor tiles with joints at (x, y) and every 0.6 m from there.
void lay_tiles(Canvas& floor, double x, double y, cv::RNG& random) {
  const Color color(168, 170, 164);
  for (double top = y - kTile; top < floor.height(); top += kTile)
    for (double left = x - kTile; left < floor.width(); left += kTile) {
      const Box tile{left, top, kTile, kTile};
      floor.fill(tile, random_shade(color, random, 0.035));
      floor.fill({left - 0.003, top, 0.006, kTile}, {132, 134, 130});
      floor.fill({left, top - 0.003, kTile, 0.006}, {132, 134, 130});
    }
}

void scuff(Canvas& floor, cv::RNG& random) {
  const cv::Point2d from{random.uniform(0.0, floor.width()), random.uniform(0.0, floor.height())};
  const double angle = random.uniform(0.0, 2 * CV_PI), length = random.uniform(0.05, 0.5);
  floor.line(from, from + length * cv::Point2d(std::cos(angle), std::sin(angle)), 0.006,
             random_shade({148, 149, 144}, random, 0.06));
}

// Paints tape marks at the robot's start (0, 0 in the world) and at the corners of its ground.
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

// The grid between a ceiling's tiles; (x, y) is a corner of a tile.
void paint_grid(Canvas& ceiling, double x, double y) {
  const double w = ceiling.width(), h = ceiling.height();
  for (; x < w + 0.001; x += kTile) ceiling.fill({x - 0.012, 0, 0.024, h}, {150, 150, 150});
  for (; y < h + 0.001; y += kTile) ceiling.fill({0, y - 0.012, w, 0.024}, {150, 150, 150});
}

void paint_lamp(Canvas& ceiling, double x, double y) {
  const Box lamp{x, y, 2 * kTile, kTile};
  ceiling.light(lamp, 0.5, 1.14);
  ceiling.fill(lamp.inset(0.012), {120, 122, 126});
  ceiling.fill(lamp.inset(0.035), {255, 255, 250});
  for (int blade = 1; blade < 8; ++blade)
    ceiling.fill({lamp.x + blade * lamp.width / 8 - 0.008, lamp.y + 0.035, 0.016, kTile - 0.07},
                 {196, 198, 200});
  ceiling.fill({lamp.x + 0.035, lamp.y + kTile / 2 - 0.02, lamp.width - 0.07, 0.04}, {176, 178, 180});
}

Canvas paint_carpet(cv::RNG& random, int number) {
  const bool far = number == 2;
  const double floor = far ? kHallLong : kLong;
  Canvas carpet(floor, kShort, far ? 0.006 : 0.002, {104, 108, 116});
  constexpr double tile = 0.5;
  for (double y = 0; y < kShort; y += tile)
    for (double x = 0; x <= floor; x += tile) {  // the last tile is outside, but its numbers are drawn
      const bool accent = random.uniform(0.0, 1.0) < 0.12;
      const Color color = accent ? Color(150, 132, 96) : Color(104, 108, 116);
      const Box box{x, y, tile, tile};
      carpet.fill(box, random_shade(color, random, 0.24));
      const int stripes = random.uniform(3, 7);
      for (int stripe = 0; stripe < stripes; ++stripe) {
        const double at = random.uniform(0.02, 0.44), wide = random.uniform(0.01, 0.05);
        const double from = random.uniform(0.0, 0.3), length = random.uniform(0.15, 0.5 - from);
        const Color tone = random_shade(color, random, 0.6);
        if (random.uniform(0, 2))
          carpet.fill({x + at, y + from, wide, length}, tone);
        else
          carpet.fill({x + from, y + at, length, wide}, tone);
      }
      carpet.frame(box, 0.004, {74, 77, 84});
    }
  carpet.grain(random, 0.05, 0.3);
  carpet.grain(random, 0.12, 0.009);
  return carpet;
}

Canvas paint_rug(cv::RNG& random, int) {
  Canvas rug(2.4, 1.7, 0.005, {128, 52, 44});
  for (int ring = 0; ring < 6; ++ring)
    rug.frame(rug.all().inset(0.05 + 0.07 * ring), 0.03,
              random_shade(ring % 2 ? Color(196, 170, 120) : Color(46, 50, 78), random, 0.2));
  for (int column = 0; column < 5; ++column)
    for (int row = 0; row < 2; ++row) {
      const cv::Point2d at{0.62 + 0.29 * column, 0.68 + 0.34 * row};
      rug.polygon({at - cv::Point2d(0.11, 0), at - cv::Point2d(0, 0.13), at + cv::Point2d(0.11, 0),
                   at + cv::Point2d(0, 0.13)},
                  random_shade({210, 184, 132}, random, 0.25));
      rug.disc(at, 0.045, {52, 40, 60});
    }
  rug.grain(random, 0.10, 0.01);
  return rug;
}

Canvas paint_vinyl(cv::RNG& random, int number) {
  const bool near = number == 2;  // under the walk: sharper
  Canvas floor = near ? Canvas(6.0, 4.8, 0.002, {}) : Canvas(25, 11, 0.007, {});
  near ? lay_tiles(floor, 0, 0, random) : lay_tiles(floor, 0.5, 0.1, random);
  for (int scuffs = near ? 60 : 400; scuffs > 0; --scuffs) scuff(floor, random);
  if (near) mark_start(floor, {2.1, 2.55});
  floor.grain(random, 0.02, 0.5);
  floor.grain(random, 0.03, 0.012);
  return floor;
}

Canvas paint_ceiling(cv::RNG& random, int) {
  Canvas ceiling(kLong, kShort, 0.005, {206, 206, 202});
  for (int hole = 0; hole < 9000; ++hole) {
    const Box dot{random.uniform(0.0, kLong), random.uniform(0.0, kShort), 0.012, 0.012};
    ceiling.fill(dot, random_shade({160, 160, 156}, random, 0.15));
  }
  constexpr double edge_x = 0.1, edge_y = 0.2;
  paint_grid(ceiling, edge_x, edge_y);
  for (int column = 0; column < 6; ++column)
    for (int row = 0; row < 4; ++row)
      paint_lamp(ceiling, edge_x + kTile * (1 + 3 * column), edge_y + kTile * (1 + 3 * row));
  return ceiling;
}

// A module with one lamp, to be repeated.
Canvas paint_hall_ceiling(cv::RNG& random, int) {
  Canvas module(2.4, 3.6, 0.003, {206, 206, 202});
  for (int hole = 0; hole < 1100; ++hole)
    module.fill({random.uniform(0.0, 2.4), random.uniform(0.0, 3.6), 0.012, 0.012},
                random_shade({160, 160, 156}, random, 0.15));
  paint_grid(module, 0, 0);
  paint_lamp(module, kTile, 2 * kTile);
  return module;
}

// Paints the baseboard, outlets and scuffs of every wall, and its darkening toward ceiling and floor.
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
  const double story = random.uniform(0.07, 0.11), bay = random.uniform(0.06, 0.1);
  for (double y = body.y + 0.03; y < body.y + body.height; y += story)
    for (double x = body.x + 0.02; x + bay * 0.6 < body.x + body.width - 0.01; x += bay)
      view.fill({x, y, bay * 0.6, story * 0.55}, shade({60, 75, 95}, random.uniform(0.6, 1.6)));
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

const Painters kShellPainters{{"carpet", paint_carpet},
                              {"rug", paint_rug},
                              {"vinyl", paint_vinyl},
                              {"ceiling", paint_ceiling},
                              {"hall_ceiling", paint_hall_ceiling},
                              {"long_wall", paint_long_wall},
                              {"short_wall", paint_short_wall},
                              {"hall_wall", paint_hall_wall},
                              {"window", paint_window},
                              {"door", paint_door},
                              {"radiator", paint_radiator},
                              {"lockers", paint_lockers},
                              {"shutter", paint_shutter}};

}  // namespace sim::room
