// The pictures on the surfaces of the rooms, drawn in meters from a seed.
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>

namespace sim::room {

using Color = cv::Scalar;  ///< red, green, blue, 0-255

/// Returns the random stream of one named texture for one seed. Painting other textures never shifts it.
cv::RNG paint_stream(std::uint64_t seed, std::string_view name);

/// Returns the color with its brightness multiplied by a factor.
inline Color shade(const Color& color, double factor) { return color * factor; }
/// Returns the color with its brightness multiplied by a random factor that differs from 1 by at most
/// `spread`.
inline Color random_shade(const Color& color, cv::RNG& random, double spread) {
  return shade(color, 1 + random.uniform(-spread, spread));
}

/// Multiplies a picture's brightness by a field of any size, interpolated over the picture.
void multiply(cv::Mat3b image, const cv::Mat1f& factor);

/// Axis-aligned box in meters, from the picture's upper left corner, y down.
struct Box {
  double x, y, width, height;
  Box inset(double by) const { return {x + by, y + by, width - 2 * by, height - 2 * by}; }
};

/// An RGB picture of known size in meters. Points are meters from the upper left corner, y down.
class Canvas {
 public:
  Canvas(double width_m, double height_m, double texel_m, const Color& ground);

  double width() const { return image_.cols * texel_m_; }
  double height() const { return image_.rows * texel_m_; }
  Box all() const { return {0, 0, width(), height()}; }
  const cv::Mat3b& image() const { return image_; }

  void fill(const Box& box, const Color& color);
  void frame(const Box& box, double thickness, const Color& color);
  void line(cv::Point2d a, cv::Point2d b, double thickness, const Color& color);
  void disc(cv::Point2d center, double radius, const Color& color);
  void polygon(const std::vector<cv::Point2d>& corners, const Color& color);
  /// Draws text with capital letters of height `height`; `at` is the left end of its baseline.
  void text(const std::string& words, cv::Point2d at, double height, double thickness, const Color& color);
  /// Fills the box with a color gradient from `top` down to `bottom`.
  void gradient(const Box& box, const Color& top, const Color& bottom);
  /// Multiplies the brightness by a smooth random field of deviation `sigma`, in patches of `size` meters.
  void grain(cv::RNG& random, double sigma, double size);
  /// Multiplies the brightness inside a soft-edged box, as a shadow (factor < 1) or a pool of light (> 1).
  void light(const Box& box, double softness, double factor);

 private:
  cv::Point pixel(cv::Point2d point) const;
  cv::Rect pixels(const Box& box) const;
  int thick(double meters) const;

  double texel_m_;
  cv::Mat3b image_;
};

/// Returns the RGB picture of a texture, first row on top, which depends only on name and seed; empty for an
/// unknown name. Names are a kind and a number ("books_3"): each kind has one painter, and each number gives
/// a different picture.
cv::Mat3b paint_texture(std::string_view name, std::uint64_t seed);

/// Side lengths of the office and the hall, m.
inline constexpr double kLong = 11, kShort = 7, kHigh = 3, kHallLong = 25, kHallAcross = 18;

/// Paints from its own random stream. number: from the texture's name ("books_3": 3).
using Painter = Canvas (*)(cv::RNG& random, int number);
using Painters = std::map<std::string_view, Painter>;

extern const Painters kShellPainters, kFurnishingPainters;

}  // namespace sim::room
