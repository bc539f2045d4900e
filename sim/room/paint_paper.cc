#include <algorithm>
#include <cmath>

#include "sim/room/paint.h"

namespace sim::room {
namespace {

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

const Painters kPaperPainters{
    {"poster", paint_poster}, {"whiteboard", paint_whiteboard}, {"notices", paint_notices}};

}  // namespace sim::room
