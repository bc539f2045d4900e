// Furniture, and the sheets of paper on walls.
#include <algorithm>
#include <cmath>

#include "sim/room/paint.h"

namespace sim::room {
namespace {

Color any_color(cv::RNG& random) {
  static const Color kSpines[] = {{150, 40, 36},   {32, 66, 120}, {36, 92, 62},  {196, 160, 60},
                                  {226, 222, 210}, {60, 60, 66},  {104, 62, 96}, {190, 98, 42},
                                  {70, 120, 140},  {120, 92, 60}};
  const Color& color = kSpines[random.uniform(0, 10)];
  return shade(color, random.uniform(0.75, 1.15));
}

Color contrast(const Color& ground) {
  const bool dark = 0.3 * ground[0] + 0.6 * ground[1] + 0.1 * ground[2] < 120;
  return dark ? Color(228, 222, 200) : Color(38, 36, 40);
}

void wood(Canvas& canvas, const Color& color, cv::RNG& random) {
  canvas.fill(canvas.all(), color);
  const int veins = int(canvas.height() * 70);
  for (int vein = 0; vein < veins; ++vein) {
    const double y = random.uniform(0.0, canvas.height());
    canvas.line({0, y}, {canvas.width(), y + random.uniform(-0.03, 0.03)}, 0.003,
                shade(color, random.uniform(0.86, 1.08)));
  }
}

void paint_spine(Canvas& shelf, const Box& spine, cv::RNG& random) {
  const Color color = any_color(random), ink = contrast(color);
  shelf.fill(spine, color);
  shelf.fill({spine.x, spine.y, 0.004, spine.height}, shade(color, 0.6));
  const double title = random.uniform(0.15, 0.35) * spine.height;
  shelf.fill({spine.x + spine.width * 0.3, spine.y + spine.height * 0.2, spine.width * 0.4, title}, ink);
  if (random.uniform(0, 2)) shelf.fill({spine.x, spine.y + spine.height * 0.12, spine.width, 0.008}, ink);
  if (random.uniform(0, 3) == 0) shelf.fill({spine.x, spine.y + spine.height * 0.8, spine.width, 0.03}, ink);
}

void paint_binder(Canvas& shelf, const Box& spine, cv::RNG& random) {
  const Color color = any_color(random);
  shelf.fill(spine, color);
  const Box label{spine.x + 0.012, spine.y + 0.05, spine.width - 0.024, 0.14};
  shelf.fill(label, {238, 236, 228});
  for (int row = 0; row < 3; ++row)
    shelf.fill({label.x + 0.008, label.y + 0.02 + 0.04 * row, label.width * 0.6, 0.012}, {60, 60, 60});
  shelf.disc({spine.x + spine.width / 2, spine.y + spine.height - 0.05}, 0.014, {30, 30, 30});
}

// Paints books and binders from one end to the other, with an occasional gap with a leaning or lying one.
void paint_row(Canvas& shelf, double floor, double room, cv::RNG& random) {
  for (double x = 0.03; x < shelf.width() - 0.09;) {
    const int kind = random.uniform(0, 12);
    if (kind == 0) {
      x += random.uniform(0.05, 0.16);
      continue;
    }
    const bool binder = kind < 4;
    const double width = binder ? 0.075 : random.uniform(0.018, 0.052);
    const double height = binder ? 0.30 : std::min(room - 0.03, random.uniform(0.19, 0.31));
    const Box spine{x, floor - height, width, height};
    binder ? paint_binder(shelf, spine, random) : paint_spine(shelf, spine, random);
    x += width + 0.002;
  }
}

// Paints a page of text, turned by at most `askew` (rad) either way.
void paint_sheet(Canvas& canvas, cv::Point2d at, double askew, cv::RNG& random) {
  const double angle = random.uniform(-askew, askew);
  const cv::Point2d across(std::cos(angle), std::sin(angle)), down(-across.y, across.x);
  const double w = 0.21, h = 0.297;
  canvas.polygon({at, at + across * w, at + across * w + down * h, at + down * h}, {244, 243, 238});
  for (double row = 0.03; row < h - 0.03; row += 0.016) {
    const cv::Point2d from = at + across * 0.022 + down * row;
    canvas.line(from, from + across * random.uniform(0.06, 0.165), 0.004, {110, 110, 112});
  }
}

Canvas paint_books(cv::RNG& random, int) {
  Canvas shelf(1.0, 2.0, 0.0025, {46, 40, 36});
  constexpr int rows = 5;
  for (int row = 0; row < rows; ++row) {
    const double floor = 2.0 * (row + 1) / rows - 0.02, room = 2.0 / rows - 0.04;
    shelf.gradient({0, floor - room - 0.02, 1.0, room}, {28, 25, 23}, {62, 54, 48});
    paint_row(shelf, floor, room, random);
  }
  shelf.grain(random, 0.04, 0.006);
  return shelf;
}

Canvas paint_desk(cv::RNG& random, int) {
  Canvas desk(1.6, 0.8, 0.0025, {186, 150, 108});
  wood(desk, shade({190, 156, 114}, random.uniform(0.85, 1.1)), random);
  const double x = random.uniform(0.4, 0.7), y = 0.55;  // keyboard and mouse
  desk.fill({x, y, 0.44, 0.14}, {44, 44, 48});
  for (int row = 0; row < 5; ++row)
    for (int key = 0; key < 15; ++key)
      desk.fill({x + 0.012 + key * 0.028, y + 0.012 + row * 0.024, 0.023, 0.019}, {96, 96, 100});
  desk.fill({x + 0.5, y + 0.03, 0.06, 0.1}, {40, 40, 44});
  for (int sheet = random.uniform(3, 7); sheet > 0; --sheet)
    paint_sheet(desk, {random.uniform(0.05, 1.3), random.uniform(0.05, 0.45)}, 0.5, random);
  const Color folder = any_color(random);
  desk.fill({random.uniform(0.05, 1.3), 0.12, 0.24, 0.32}, folder);
  desk.frame(desk.all(), 0.008, {96, 74, 52});
  desk.grain(random, 0.03, 0.008);
  return desk;
}

Canvas paint_screen(cv::RNG& random, int number) {
  Canvas screen(0.54, 0.32, 0.0015, {22, 22, 24});
  const bool dark = number % 2;
  const Box shown = screen.all().inset(0.012);
  const Color paper = dark ? Color(38, 42, 54) : Color(236, 238, 240), ink = contrast(paper);
  screen.fill(shown, paper);
  screen.fill({shown.x, shown.y, shown.width, 0.014}, {70, 110, 170});
  screen.fill({shown.x, shown.y + 0.014, 0.09, shown.height - 0.014}, shade(paper, 0.85));
  for (double y = 0.045; y < 0.29; y += 0.0085) {
    const double indent = 0.12 + 0.014 * random.uniform(0, 4);
    screen.fill({0.02, y, random.uniform(0.02, 0.07), 0.004}, shade(ink, 0.8));
    if (random.uniform(0, 6) == 0) continue;
    const double length = random.uniform(0.03, 0.22);
    screen.fill({indent, y, length, 0.0045}, any_color(random));
  }
  const Box plot{0.38, 0.06, 0.13, 0.1};
  screen.fill(plot, {250, 250, 250});
  for (int bar = 0; bar < 8; ++bar) {
    const double h = random.uniform(0.02, 0.09);
    screen.fill({plot.x + 0.008 + bar * 0.015, plot.y + 0.095 - h, 0.01, h}, any_color(random));
  }
  return screen;
}

Canvas paint_drawers(cv::RNG&, int) {
  Canvas front(0.42, 0.58, 0.003, {182, 184, 188});
  for (int drawer = 0; drawer < 3; ++drawer) {
    const Box box{0.01, 0.015 + 0.188 * drawer, 0.40, 0.178};
    front.frame(box, 0.006, {96, 98, 102});
    front.fill({box.x + 0.13, box.y + 0.03, 0.14, 0.022}, {66, 68, 72});
  }
  front.disc({0.37, 0.04}, 0.01, {50, 50, 50});
  return front;
}

Canvas paint_cabinet(cv::RNG& random, int number) {
  Canvas front(1.2, 0.8, 0.003, {170, 150, 124});
  wood(front, number % 2 ? Color(176, 146, 108) : Color(150, 154, 160), random);
  for (double x : {0.0, 0.6}) {
    front.frame({x + 0.008, 0.008, 0.584, 0.784}, 0.008, {84, 72, 58});
    front.fill({x == 0.0 ? 0.53 : 0.65, 0.28, 0.02, 0.16}, {60, 60, 62});
  }
  front.fill({0.12, 0.1, 0.12, 0.07}, {240, 238, 232});
  front.fill({0.135, 0.12, 0.08, 0.012}, {50, 50, 52});
  return front;
}

Canvas paint_fabric(cv::RNG& random, int) {
  Canvas panel(1.6, 1.4, 0.004, any_color(random) * 0.4 + Color(80, 84, 92));
  panel.grain(random, 0.08, 0.008);
  for (int note = random.uniform(5, 9); note > 0; --note) {
    const cv::Point2d at{random.uniform(0.08, 1.3), random.uniform(0.08, 0.75)};
    if (note % 2)
      paint_sheet(panel, at, 0.12, random);
    else
      panel.fill({at.x, at.y, 0.09, 0.09}, {236, 214, 96});
  }
  panel.frame(panel.all(), 0.02, {62, 64, 68});
  return panel;
}

Canvas paint_carton(cv::RNG& random, int number) {
  Canvas side(0.5, 0.4, 0.003, {176, 138, 92});
  side.grain(random, 0.05, 0.02);
  side.fill({0, 0.17, 0.5, 0.05}, {200, 176, 128});
  side.fill({0.3, 0.04, 0.15, 0.1}, {238, 238, 232});
  for (int bar = 0; bar < 14; ++bar)
    side.fill({0.31 + bar * 0.009, 0.09, random.uniform(0.003, 0.007), 0.04}, {30, 30, 30});
  side.text(number % 2 ? "FRAGILE" : "PAPER A4", {0.04, 0.33}, 0.05, 0.008, {120, 30, 26});
  side.frame(side.all(), 0.006, {120, 92, 60});
  return side;
}

const Color kInk(36, 36, 42);

Color vivid(cv::RNG& random) {
  return {double(random.uniform(20, 240)), double(random.uniform(20, 220)), double(random.uniform(20, 230))};
}

void lines_of_text(Canvas& page, const Box& column, cv::RNG& random) {
  for (double y = column.y; y < column.y + column.height; y += 0.02)
    for (double x = column.x; x < column.x + column.width - 0.02;) {
      const double word = std::min(random.uniform(0.015, 0.05), column.x + column.width - x);
      page.fill({x, y, word, 0.009}, {70, 70, 76});
      x += word + 0.009;
    }
}

void plot(Canvas& page, const Box& box, cv::RNG& random) {
  page.fill(box, {252, 252, 252});
  page.frame(box, 0.004, kInk);
  for (int curve = 0; curve < 2; ++curve) {
    const Color color = vivid(random);
    const double phase = random.uniform(0.0, 6.0), rate = random.uniform(4.0, 12.0);
    cv::Point2d last;
    for (int step = 0; step <= 24; ++step) {
      const double at = step / 24.0, value = 0.5 - 0.4 * at * std::sin(rate * at + phase);
      const cv::Point2d point(box.x + at * box.width, box.y + value * box.height);
      if (step > 0) page.line(last, point, 0.006, color);
      last = point;
    }
  }
}

void scientific_poster(Canvas& page, cv::RNG& random) {
  const Color band = vivid(random) * 0.6;
  page.fill({0, 0, 0.7, 0.15}, band);
  static const char* const kTitles[] = {"WALKING", "ROBOTICS", "VISION", "CONTROL", "MAPPING"};
  page.text(kTitles[random.uniform(0, 5)], {0.05, 0.09}, 0.055, 0.009, {250, 250, 246});
  page.fill({0.05, 0.115, 0.4, 0.012}, {230, 230, 226});
  for (int column = 0; column < 2; ++column) {
    const double x = 0.04 + 0.33 * column;
    lines_of_text(page, {x, 0.19, 0.29, 0.2}, random);
    plot(page, {x, 0.42, 0.29, 0.2}, random);
    lines_of_text(page, {x, 0.66, 0.29, 0.12}, random);
    page.fill({x, 0.81, 0.29, 0.15}, vivid(random) * 0.5 + Color(90, 90, 90));
    const double ball = x + random.uniform(0.06, 0.22);
    page.disc({ball, 0.885}, 0.05, vivid(random));
  }
}

void landscape(Canvas& page, cv::RNG& random) {
  page.gradient(page.all(), {90, 140, 210}, {250, 214, 160});
  page.disc({random.uniform(0.15, 0.55), 0.3}, 0.06, {255, 244, 210});
  for (int range = 0; range < 4; ++range) {
    std::vector<cv::Point2d> outline{{0, 1}};
    const double base = 0.42 + 0.13 * range;
    for (double x = 0; x <= 0.75; x += 0.07) outline.push_back({x, base + random.uniform(-0.09, 0.09)});
    outline.push_back({0.75, 1});
    page.polygon(outline, shade({150, 156, 176}, 1 - 0.24 * range));
  }
  static const char* const kPlaces[] = {"PYRENEES", "HOKKAIDO", "DOLOMITES", "TATRA"};
  page.text(kPlaces[random.uniform(0, 4)], {0.08, 0.94}, 0.055, 0.01, {250, 240, 220});
}

void abstract_art(Canvas& page, cv::RNG& random) {
  page.fill(page.all(), {238, 232, 218});
  for (int shape = 0; shape < 16; ++shape) {
    const cv::Point2d at{random.uniform(0.0, 0.7), random.uniform(0.0, 1.0)};
    const double size = random.uniform(0.04, 0.2);
    const double stretch = random.uniform(-1.0, 1.0);
    const Color color = vivid(random);
    if (shape % 3 == 0) page.disc(at, size * 0.6, color);
    if (shape % 3 == 1) page.fill({at.x, at.y, size, size * (1.2 + 0.8 * stretch)}, color);
    if (shape % 3 == 2)
      page.polygon({at, at + cv::Point2d(size, size * stretch), at + cv::Point2d(0, size)}, color);
  }
}

void calendar(Canvas& page, cv::RNG& random) {
  const Color top = vivid(random), bottom = vivid(random);
  page.gradient({0, 0, 0.7, 0.4}, top, bottom);
  page.text("NOVEMBER", {0.06, 0.5}, 0.05, 0.008, kInk);
  for (int row = 0; row < 5; ++row)
    for (int day = 0; day < 7; ++day) {
      const Box cell{0.04 + 0.09 * day, 0.55 + 0.085 * row, 0.085, 0.08};
      page.frame(cell, 0.003, {150, 150, 150});
      page.text(std::to_string(row * 7 + day + 1), {cell.x + 0.01, cell.y + 0.045}, 0.022, 0.004,
                day > 4 ? Color(190, 40, 40) : kInk);
    }
}

void map(Canvas& page, cv::RNG& random) {
  page.fill(page.all(), {176, 206, 226});
  for (int land = 0; land < 9; ++land) {
    const cv::Point2d center{random.uniform(0.05, 0.65), random.uniform(0.05, 0.95)};
    const double size = random.uniform(0.06, 0.17);
    std::vector<cv::Point2d> coast;
    for (int corner = 0; corner < 11; ++corner) {
      const double angle = corner * 2 * CV_PI / 11, r = size * random.uniform(0.6, 1.3);
      coast.push_back(center + cv::Point2d(r * std::cos(angle), r * std::sin(angle)));
    }
    page.polygon(coast, shade({206, 190, 130}, random.uniform(0.7, 1.15)));
    page.disc(center, 0.008, {170, 30, 30});
  }
  for (double x = 0.1; x < 0.7; x += 0.1) page.line({x, 0}, {x, 1}, 0.003, {130, 150, 165});
  for (double y = 0.1; y < 1.0; y += 0.1) page.line({0, y}, {0.7, y}, 0.003, {130, 150, 165});
}

Canvas paint_poster(cv::RNG& random, int number) {
  Canvas page(0.7, 1.0, 0.0025, {244, 243, 238});
  void (*const kinds[])(Canvas&, cv::RNG&) = {scientific_poster, landscape, abstract_art, calendar, map};
  kinds[number % 5](page, random);
  page.frame(page.all(), 0.012, number % 2 ? Color(40, 38, 36) : Color(226, 222, 214));
  return page;
}

Canvas paint_whiteboard(cv::RNG& random, int) {
  Canvas board(2.4, 1.2, 0.003, {242, 243, 244});
  board.grain(random, 0.012, 0.1);
  const Color pens[] = {{30, 50, 150}, {170, 30, 36}, {24, 110, 60}, {30, 30, 34}};
  board.text("x' = A x + B u", {0.12, 0.24}, 0.07, 0.009, pens[0]);
  board.text("p = C x", {0.12, 0.40}, 0.07, 0.009, pens[0]);
  board.text("ZMP?", {0.7, 0.42}, 0.06, 0.009, pens[1]);
  for (int row = 0; row < 6; ++row) {
    const double y = 0.6 + 0.09 * row;
    board.line({0.12, y}, {0.12 + random.uniform(0.3, 0.9), y + random.uniform(-0.01, 0.01)}, 0.01,
               pens[row % 4]);
  }
  const Box axes{1.3, 0.14, 0.9, 0.5};
  board.line({axes.x, axes.y}, {axes.x, axes.y + axes.height}, 0.01, pens[3]);
  board.line({axes.x, axes.y + axes.height}, {axes.x + axes.width, axes.y + axes.height}, 0.01, pens[3]);
  cv::Point2d last(axes.x, axes.y + axes.height);
  for (int step = 1; step <= 30; ++step) {
    const double at = step / 30.0, value = 1 - std::exp(-5 * at) * std::cos(9 * at);
    const cv::Point2d point(axes.x + at * axes.width, axes.y + axes.height * (1 - 0.7 * value));
    board.line(last, point, 0.009, pens[1]);
    last = point;
  }
  for (int box = 0; box < 3; ++box) {
    const Box block{1.3 + 0.34 * box, 0.82, 0.24, 0.16};
    board.frame(block, 0.008, pens[2]);
    board.text(std::string(1, "KHG"[box]), {block.x + 0.09, block.y + 0.11}, 0.06, 0.009, pens[3]);
    if (box < 2) board.line({block.x + 0.24, 0.9}, {block.x + 0.34, 0.9}, 0.008, pens[3]);
  }
  board.frame(board.all(), 0.03, {150, 152, 156});
  board.frame(board.all(), 0.006, {80, 82, 84});
  return board;
}

Canvas paint_notices(cv::RNG& random, int) {
  Canvas board(1.5, 1.0, 0.003, {176, 132, 86});
  board.grain(random, 0.12, 0.008);
  for (int sheet = 0; sheet < 13; ++sheet) {
    const Box paper{random.uniform(0.05, 1.2), random.uniform(0.05, 0.65), random.uniform(0.12, 0.22),
                    random.uniform(0.15, 0.3)};
    board.fill(paper, sheet % 4 ? Color(244, 243, 238) : vivid(random) * 0.4 + Color(140, 140, 140));
    lines_of_text(board, paper.inset(0.02), random);
    board.disc({paper.x + paper.width / 2, paper.y + 0.015}, 0.009, vivid(random));
  }
  board.frame(board.all(), 0.03, {120, 84, 50});
  return board;
}

}  // namespace

const Painters kFurnishingPainters{{"books", paint_books},           {"desk", paint_desk},
                                   {"screen", paint_screen},         {"drawers", paint_drawers},
                                   {"cabinet", paint_cabinet},       {"fabric", paint_fabric},
                                   {"carton", paint_carton},         {"poster", paint_poster},
                                   {"whiteboard", paint_whiteboard}, {"notices", paint_notices}};

}  // namespace sim::room
