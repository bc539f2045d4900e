#include <algorithm>
#include <cmath>

#include "sim/room/painters.h"

namespace sim::room {
namespace {

constexpr double kLong = 11, kShort = 7, kHigh = 3, kHallLong = 25, kHallAcross = 18;

Color brightness(const Color& color, cv::RNG& random, double spread) {
  return shade(color, 1 + random.uniform(-spread, spread));
}

// Skirting, sockets, scuffs and the darkening towards ceiling and floor that every wall has.
void finish_wall(Canvas& wall, cv::RNG& random) {
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
}

void paint_building(Canvas& view, const Box& body, cv::RNG& random) {
  static const Color kFacades[] = {
      {196, 178, 150}, {170, 112, 88}, {150, 152, 156}, {206, 196, 176}, {122, 136, 150}};
  const Color wall = brightness(kFacades[random.uniform(0, 5)], random, 0.2);
  view.fill(body, wall);
  const double storey = random.uniform(0.07, 0.11), bay = random.uniform(0.06, 0.1);
  for (double y = body.y + 0.03; y < body.y + body.height; y += storey)
    for (double x = body.x + 0.02; x + bay * 0.6 < body.x + body.width - 0.01; x += bay)
      view.fill({x, y, bay * 0.6, storey * 0.55}, shade({60, 75, 95}, random.uniform(0.6, 1.6)));
  view.fill({body.x, body.y, body.width, 0.012}, shade(wall, 0.6));
}

void paint_trees(Canvas& view, cv::RNG& random) {
  for (int leaf = 0; leaf < 700; ++leaf) {
    const double x = random.uniform(-0.05, 2.25), y = view.height() - std::abs(random.gaussian(0.13));
    const double radius = random.uniform(0.012, 0.04);
    view.disc({x, y}, radius, shade({70, 105, 50}, random.uniform(0.5, 1.4)));
  }
}

}  // namespace

Canvas paint_carpet(PaintRequest& request) {
  const bool far = request.number == 2;
  const double floor = far ? kHallLong : kLong;
  Canvas carpet(floor, kShort, far ? 0.006 : 0.002, {104, 108, 116});
  constexpr double tile = 0.5;
  for (double y = 0; y < kShort; y += tile)
    for (double x = 0; x <= floor; x += tile) {  // the last tile is outside, but its numbers are drawn
      const bool accent = request.random.uniform(0.0, 1.0) < 0.12;
      const Color color = accent ? Color(150, 132, 96) : Color(104, 108, 116);
      const Box box{x, y, tile, tile};
      carpet.fill(box, brightness(color, request.random, 0.24));
      const int stripes = request.random.uniform(3, 7);
      for (int stripe = 0; stripe < stripes; ++stripe) {
        const double at = request.random.uniform(0.02, 0.44), wide = request.random.uniform(0.01, 0.05);
        const double from = request.random.uniform(0.0, 0.3),
                     length = request.random.uniform(0.15, 0.5 - from);
        const Color tone = brightness(color, request.random, 0.6);
        if (request.random.uniform(0, 2))
          carpet.fill({x + at, y + from, wide, length}, tone);
        else
          carpet.fill({x + from, y + at, length, wide}, tone);
      }
      carpet.frame(box, 0.004, {74, 77, 84});
    }
  carpet.grain(request.random, 0.05, 0.3);
  carpet.grain(request.random, 0.12, 0.009);
  return carpet;
}

Canvas paint_ceiling(PaintRequest& request) {
  Canvas ceiling(kLong, kShort, 0.005, {206, 206, 202});
  for (int hole = 0; hole < 9000; ++hole) {
    const Box dot{request.random.uniform(0.0, kLong), request.random.uniform(0.0, kShort), 0.012, 0.012};
    ceiling.fill(dot, brightness({160, 160, 156}, request.random, 0.15));
  }
  constexpr double tile = 0.6, edge_x = 0.1, edge_y = 0.2;
  for (double x = edge_x; x < kLong; x += tile) ceiling.fill({x - 0.012, 0, 0.024, kShort}, {150, 150, 150});
  for (double y = edge_y; y < kShort; y += tile) ceiling.fill({0, y - 0.012, kLong, 0.024}, {150, 150, 150});
  for (int column = 0; column < 6; ++column)
    for (int row = 0; row < 4; ++row) {
      const Box lamp{edge_x + tile * (1 + 3 * column), edge_y + tile * (1 + 3 * row), 2 * tile, tile};
      ceiling.light(lamp, 0.5, 1.14);
      ceiling.fill(lamp.inset(0.012), {120, 122, 126});
      ceiling.fill(lamp.inset(0.035), {255, 255, 250});
      for (int blade = 1; blade < 8; ++blade)
        ceiling.fill({lamp.x + blade * 2 * tile / 8 - 0.008, lamp.y + 0.035, 0.016, tile - 0.07},
                     {196, 198, 200});
      ceiling.fill({lamp.x + 0.035, lamp.y + tile / 2 - 0.02, 2 * tile - 0.07, 0.04}, {176, 178, 180});
    }
  return ceiling;
}

Canvas paint_long_wall(PaintRequest& request) {
  Canvas wall(kLong, kHigh, 0.005, request.number == 1 ? Color(214, 212, 204) : Color(206, 204, 190));
  finish_wall(wall, request.random);
  return wall;
}

Canvas paint_short_wall(PaintRequest& request) {
  Canvas wall(kShort, kHigh, 0.005, request.number == 1 ? Color(196, 200, 206) : Color(212, 206, 194));
  finish_wall(wall, request.random);
  return wall;
}

Canvas paint_hall_wall(PaintRequest& request) {
  static const Color kColors[] = {{208, 206, 200}, {214, 212, 204}, {190, 196, 198}, {206, 202, 192}};
  Canvas wall(request.number <= 2 ? kHallLong : kHallAcross, kHigh, 0.005, kColors[(request.number + 3) % 4]);
  finish_wall(wall, request.random);
  return wall;
}

Canvas paint_window(PaintRequest& request) {
  Canvas view(2.2, 1.6, 0.004, {180, 205, 235});
  view.gradient(view.all(), {150, 190, 238}, {226, 234, 240});
  for (int cloud = 0; cloud < 40; ++cloud) {
    const Box wisp{request.random.uniform(-0.3, 2.2), request.random.uniform(-0.1, 0.6),
                   request.random.uniform(0.1, 0.4), 0.04};
    view.light(wisp, 0.06, request.random.uniform(1.0, 1.14));
  }
  for (double x = -0.1; x < 2.2;) {
    const double width = request.random.uniform(0.25, 0.6), top = request.random.uniform(0.35, 1.0);
    paint_building(view, {x, top, width, 1.6 - top}, request.random);
    x += width + request.random.uniform(-0.02, 0.15);
  }
  paint_trees(view, request.random);
  view.frame(view.all(), 0.06, {236, 236, 232});
  view.frame(view.all().inset(0.055), 0.012, {120, 122, 124});
  view.fill({1.065, 0, 0.07, 1.6}, {236, 236, 232});
  view.fill({1.062, 0.06, 0.008, 1.48}, {120, 122, 124});
  view.fill({1.13, 0.06, 0.008, 1.48}, {120, 122, 124});
  view.fill({1.145, 0.78, 0.02, 0.12}, {90, 90, 92});
  return view;
}

Canvas paint_door(PaintRequest& request) {
  Canvas door(0.95, 2.1, 0.0035, request.number == 1 ? Color(150, 112, 74) : Color(120, 132, 142));
  door.grain(request.random, 0.05, 0.02);
  for (int vein = 0; request.number == 1 && vein < 60; ++vein) {
    const double x = request.random.uniform(0.0, 0.95), end = x + request.random.uniform(-0.03, 0.03);
    door.line({x, 0}, {end, 2.1}, 0.004, brightness({140, 102, 66}, request.random, 0.15));
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
  door.text(request.number == 1 ? "2.17" : "EXIT", {0.26, 0.59}, 0.06, 0.009, {30, 60, 120});
  door.fill({0.26, 0.615, 0.2, 0.012}, {120, 120, 120});
  return door;
}

Canvas paint_rug(PaintRequest& request) {
  Canvas rug(2.4, 1.7, 0.005, {128, 52, 44});
  for (int ring = 0; ring < 6; ++ring)
    rug.frame(rug.all().inset(0.05 + 0.07 * ring), 0.03,
              brightness(ring % 2 ? Color(196, 170, 120) : Color(46, 50, 78), request.random, 0.2));
  for (int column = 0; column < 5; ++column)
    for (int row = 0; row < 2; ++row) {
      const cv::Point2d at{0.62 + 0.29 * column, 0.68 + 0.34 * row};
      rug.polygon({at - cv::Point2d(0.11, 0), at - cv::Point2d(0, 0.13), at + cv::Point2d(0.11, 0),
                   at + cv::Point2d(0, 0.13)},
                  brightness({210, 184, 132}, request.random, 0.25));
      rug.disc(at, 0.045, {52, 40, 60});
    }
  rug.grain(request.random, 0.10, 0.01);
  return rug;
}

Canvas paint_radiator(PaintRequest&) {
  Canvas radiator(1.8, 0.6, 0.004, {228, 228, 224});
  for (double x = 0.03; x < 1.77; x += 0.06) {
    radiator.fill({x, 0.04, 0.018, 0.52}, {150, 150, 148});
    radiator.fill({x + 0.018, 0.04, 0.008, 0.52}, {196, 196, 194});
  }
  radiator.fill({0, 0, 1.8, 0.03}, {205, 205, 202});
  radiator.frame(radiator.all(), 0.008, {130, 130, 128});
  return radiator;
}

}  // namespace sim::room
