// Floors and ceilings.
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

// The grid between a ceiling's tiles, of which (x, y) is a corner.
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

}  // namespace

const Painters kFloorPainters{{"carpet", paint_carpet},
                              {"rug", paint_rug},
                              {"vinyl", paint_vinyl},
                              {"ceiling", paint_ceiling},
                              {"hall_ceiling", paint_hall_ceiling}};

}  // namespace sim::room
