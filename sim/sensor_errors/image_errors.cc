#include <algorithm>
#include <utility>

#include "sim/sensor_errors/random.h"
#include "sim/sensor_errors/sensor_errors.h"

namespace sim::sensor_errors {
namespace {

constexpr int kUnitWeight = 4096;  // a weight of 1

// The medians of 4096 equally likely intervals of the normal distribution, in units of 1/4096, scaled to a
// variance of 1 (by 2e-4). The largest is 3.67 standard deviations.
std::array<int, 4096> normal_table() {
  std::array<double, 4096> z;
  double sum = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    z[i] = normal_quantile((double(i) + 0.5) / 4096);
    sum += z[i] * z[i];
  }
  std::array<int, 4096> table;
  for (std::size_t i = 0; i < z.size(); ++i) table[i] = int(std::lround(z[i] / std::sqrt(sum / 4096) * 4096));
  return table;
}

// Random gray squares with corner features, fixed in the image.
cv::Mat occlusion_texture(cv::Size size, int square, std::uint64_t seed) {
  Random random(seed, "poster");
  cv::Mat texture(size, CV_8UC1);
  for (int v = 0; v < size.height; v += square)
    for (int u = 0; u < size.width; u += square)
      texture(cv::Rect(u, v, square, square) & cv::Rect({}, size)).setTo(40 + 175 * random.uniform());
  return texture;
}

}  // namespace

ImageErrors::ImageErrors(const ImageOptions& sizes, std::uint64_t seed, const std::vector<Fault>& faults,
                         std::string stream)
    : sizes_(sizes),
      seed_(seed),
      stream_(std::move(stream)),
      dimmed_(faults_of<FramesDimmed>(faults)),
      covers_(faults_of<FramesCovered>(faults)) {
  const double read = sizes.read_sigma_gray, shot = sizes.shot_sigma_gray;
  constexpr double kWhite = 600, kLoud = 300;  // Larger values would not change any pixel and would overflow.
  for (std::size_t i = 0; i < responses_.size(); ++i) {
    const double gray = double(i) / 16;
    const double sigma = sizes.gain * std::sqrt(read * read + shot * shot * gray / 255);
    responses_[i] = {int(std::lround(std::min(sizes.gain * gray, kWhite) * (1 << 20))),
                     int(std::lround(256 * std::min(sigma, kLoud)))};
  }
}

// Five pixels share 64 random bits; the arithmetic is fixed point with 20 binary places.
cv::Mat ImageErrors::apply(const cv::Mat& ideal, slam::Stamp t) const {
  static const std::array<int, 4096> z = normal_table();
  cv::Mat image = ideal;
  for (const FramesCovered& cover : covers_)
    if (cover.holds(t)) image = covered(image, cover.fraction);
  double exposure = 1;
  for (const FramesDimmed& dimmed : dimmed_)
    if (dimmed.holds(t)) exposure *= dimmed.factor;
  const int weight = int(std::lround(kUnitWeight * std::min(exposure, 1000.0)));
  std::array<Response, 256> responses;  // fits into the cache
  for (int gray = 0; gray < 256; ++gray)
    responses[std::size_t(gray)] = responses_[std::min((gray * weight) >> 8, 4095)];
  Random random(seed_, stream_, std::uint64_t(t.count()));
  cv::Mat out(image.size(), CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    const unsigned char* from = image.ptr(row);
    unsigned char* to = out.ptr(row);
    for (int column = 0; column < image.cols;) {
      std::uint64_t bits = random.bits();
      for (const int end = std::min(column + 5, image.cols); column < end; ++column, bits >>= 12) {
        const Response& response = responses[from[column]];
        const int sum = response.mean + z[bits & 4095] * response.sigma + (1 << 19);
        to[column] = static_cast<unsigned char>(std::clamp(sum >> 20, 0, 255));
      }
    }
  }
  return out;
}

cv::Mat ImageErrors::covered(const cv::Mat& image, double fraction) const {
  const double side = std::sqrt(fraction);
  const cv::Size size(int(std::lround(side * image.cols)), int(std::lround(side * image.rows)));
  const cv::Rect middle(cv::Point(image.size() - size) / 2, size);
  cv::Mat out = image.clone();
  if (!middle.empty()) occlusion_texture(size, std::max(1, image.cols / 24), seed_).copyTo(out(middle));
  return out;
}

}  // namespace sim::sensor_errors
