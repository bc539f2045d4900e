#include "sim/room/paint.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace sim::room {

constexpr int kSubpixelBits = 4;

void multiply(cv::Mat3b image, const cv::Mat1f& factor) {
  cv::Mat1w fixed;  // 8 fractional bits
  factor.convertTo(fixed, CV_16U, 256);
  if (fixed.size() != image.size()) cv::resize(fixed, fixed, image.size(), 0, 0, cv::INTER_LINEAR);
  for (int row = 0; row < image.rows; ++row) {
    cv::Mat by;  // each factor three times
    cv::cvtColor(fixed.row(row), by, cv::COLOR_GRAY2RGB);
    unsigned char* const texels = image.ptr<unsigned char>(row);
    const unsigned short* const factors = by.ptr<unsigned short>();
    for (int i = 0; i < 3 * image.cols; ++i)
      texels[i] = static_cast<unsigned char>(std::min(255, texels[i] * factors[i] >> 8));
  }
}

cv::RNG paint_stream(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a of the name, then of the seed
  for (const char letter : name)
    hash = (hash ^ std::uint64_t(static_cast<unsigned char>(letter))) * 0x100000001b3u;
  hash = (hash ^ seed) * 0x9e3779b97f4a7c15u;
  return cv::RNG(hash ^ (hash >> 29));
}

Canvas::Canvas(double width_m, double height_m, double texel_m, const Color& ground)
    : texel_m_(texel_m), image_(int(std::lround(height_m / texel_m)), int(std::lround(width_m / texel_m))) {
  fill(all(), ground);
}

cv::Point Canvas::pixel(cv::Point2d point) const {
  const double scale = (1 << kSubpixelBits) / texel_m_, half = 0.5 * (1 << kSubpixelBits);
  return {int(std::lround(point.x * scale - half)), int(std::lround(point.y * scale - half))};
}

cv::Rect Canvas::pixels(const Box& box) const {
  const auto at = [&](double meters) { return int(std::lround(meters / texel_m_)); };
  const cv::Point corner(at(box.x), at(box.y)), end(at(box.x + box.width), at(box.y + box.height));
  return cv::Rect(corner, end) & cv::Rect({0, 0}, image_.size());
}

int Canvas::thick(double meters) const { return std::max(1, int(std::lround(meters / texel_m_))); }

void Canvas::fill(const Box& box, const Color& color) {
  const cv::Rect area = pixels(box);
  if (!area.empty()) cv::rectangle(image_, area, color, cv::FILLED);
}

void Canvas::frame(const Box& box, double thickness, const Color& color) {
  const double t = thickness;
  fill({box.x, box.y, box.width, t}, color);
  fill({box.x, box.y + box.height - t, box.width, t}, color);
  fill({box.x, box.y, t, box.height}, color);
  fill({box.x + box.width - t, box.y, t, box.height}, color);
}

void Canvas::line(cv::Point2d a, cv::Point2d b, double thickness, const Color& color) {
  cv::line(image_, pixel(a), pixel(b), color, thick(thickness), cv::LINE_AA, kSubpixelBits);
}

void Canvas::disc(cv::Point2d center, double radius, const Color& color) {
  const int r = int(std::lround(radius / texel_m_ * (1 << kSubpixelBits)));
  cv::circle(image_, pixel(center), r, color, cv::FILLED, cv::LINE_AA, kSubpixelBits);
}

void Canvas::polygon(const std::vector<cv::Point2d>& corners, const Color& color) {
  std::vector<cv::Point> points;
  for (const cv::Point2d& corner : corners) points.push_back(pixel(corner));
  cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{points}, color, cv::LINE_AA, kSubpixelBits);
}

void Canvas::text(const std::string& words, cv::Point2d at, double height, double thickness,
                  const Color& color) {
  constexpr double kCapital = 21;  // height of a capital letter of this font at scale 1
  cv::putText(image_, words, {int(at.x / texel_m_), int(at.y / texel_m_)}, cv::FONT_HERSHEY_DUPLEX,
              height / texel_m_ / kCapital, color, thick(thickness), cv::LINE_AA);
}

void Canvas::gradient(const Box& box, const Color& top, const Color& bottom) {
  const cv::Rect area = pixels(box);
  for (int row = 0; row < area.height; ++row) {
    const double part = (row + 0.5) / area.height;
    cv::rectangle(image_, cv::Rect(area.x, area.y + row, area.width, 1), top * (1 - part) + bottom * part,
                  cv::FILLED);
  }
}

void Canvas::grain(cv::RNG& random, double sigma, double size) {
  const double cell_px = std::max(1.0, size / texel_m_), half_range = sigma * std::sqrt(3.0);
  cv::Mat1f values(int(std::ceil(image_.rows / cell_px)), int(std::ceil(image_.cols / cell_px)));
  random.fill(values, cv::RNG::UNIFORM, 1 - half_range, 1 + half_range);
  multiply(image_, values);
}

void Canvas::light(const Box& box, double softness, double factor) {
  const Box wide{box.x - softness, box.y - softness, box.width + 2 * softness, box.height + 2 * softness};
  const cv::Rect area = pixels(wide);
  if (area.empty()) return;
  const auto part = [&](double at, double from, double length) {  // 0 outside, 1 inside, smooth between
    const double inside = std::min(at - from, from + length - at) / softness;
    const double t = std::clamp((inside + 1) / 2, 0.0, 1.0);
    return t * t * (3 - 2 * t);
  };
  cv::Mat1f by(area.size());
  for (int row = 0; row < area.height; ++row) {
    const double down = part((area.y + row + 0.5) * texel_m_, box.y, box.height);
    for (int column = 0; column < area.width; ++column)
      by(row, column) =
          float(1 + (factor - 1) * down * part((area.x + column + 0.5) * texel_m_, box.x, box.width));
  }
  multiply(image_(area), by);
}

namespace {

// Names are a kind and a number, such as books_3.
std::size_t kind_ends(std::string_view name) { return name.find_last_not_of("_0123456789") + 1; }

Painter painter_of(std::string_view name) {
  for (const Painters* painters : {&kShellPainters, &kFurnishingPainters})
    if (const auto painter = painters->find(name.substr(0, kind_ends(name))); painter != painters->end())
      return painter->second;
  return nullptr;
}

}  // namespace

cv::Mat3b paint_texture(std::string_view name, std::uint64_t seed) {
  const std::size_t end = kind_ends(name);
  const int number = end < name.size() ? std::atoi(std::string(name.substr(end + 1)).c_str()) : 0;
  cv::RNG random = paint_stream(seed, name);
  const Painter painter = painter_of(name);
  return painter ? painter(random, number).image() : cv::Mat3b();
}

}  // namespace sim::room
