#include "sim/stream/sensor_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/stream/random.h"

namespace sim::stream {
namespace {

constexpr double kNominalPeriod_ns = 5e6;  // a whole inertial reading, 200 Hz

std::uint64_t item(slam::Stamp t) { return static_cast<std::uint64_t>(t.count()); }

Eigen::Vector3d normal3(Random random) {
  Eigen::Vector3d v;
  for (double& x : v) x = random.normal();
  return v;
}

// The middles of 4096 slices of equal probability of the normal distribution, in 1/4096, stretched by the
// 2e-4 that their variance lacks of 1. Reaches 3.67 standard deviations.
std::array<int, 4096> make_normal_table() {
  std::array<double, 4096> z;
  double sum = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    z[i] = normal_quantile((static_cast<double>(i) + 0.5) / 4096);
    sum += z[i] * z[i];
  }
  std::array<int, 4096> table;
  for (std::size_t i = 0; i < z.size(); ++i)
    table[i] = static_cast<int>(std::lround(z[i] / std::sqrt(sum / 4096) * 4096));
  return table;
}

const std::array<int, 4096>& normal_table() {
  static const std::array<int, 4096> table = make_normal_table();
  return table;
}

void require(double value, double least, double most, const std::string& name) {
  if (!(value >= least && value <= most))
    throw std::invalid_argument("errors." + name + " must be from " + std::to_string(least) + " to " +
                                std::to_string(most) + ", is " + std::to_string(value));
}

void validate(const ErrorOptions& o) {
  constexpr double kAny = 1e6;
  require(o.gyro.sigma_rad_s, 0, kAny, "gyro.sigma_rad_s");
  require(o.gyro.bias_sigma_rad_s, 0, kAny, "gyro.bias_sigma_rad_s");
  require(o.accelerometer.sigma_m_s2, 0, kAny, "accelerometer.sigma_m_s2");
  require(o.accelerometer.bias_sigma_m_s2, 0, kAny, "accelerometer.bias_sigma_m_s2");
  require(o.image.read_sigma_grey, 0, 100, "image.read_sigma_grey");
  require(o.image.shot_sigma_grey, 0, 50, "image.shot_sigma_grey");
  require(o.image.loss_fraction, 0, 1, "image.loss_fraction");
  require(o.plan.loss_fraction, 0, 1, "plan.loss_fraction");
}

}  // namespace

SensorErrors::SensorErrors(const ErrorOptions& options, std::uint64_t seed)
    : options_(options),
      seed_(seed),
      gyro_bias_(options.gyro.bias_sigma_rad_s * normal3(Random(seed, "gyro bias"))),
      accelerometer_bias_(options.accelerometer.bias_sigma_m_s2 *
                          normal3(Random(seed, "accelerometer bias"))) {
  validate(options_);
  const double read = options_.image.read_sigma_grey, shot = options_.image.shot_sigma_grey;
  for (int grey = 0; grey < 256; ++grey)
    sigma_of_grey_.push_back(
        static_cast<int>(std::lround(256 * std::sqrt(read * read + shot * shot * grey / 255))));
}

slam::Observation SensorErrors::apply(slam::Observation ideal) const {
  apply_white_noise(ideal.gyro, "gyro noise", options_.gyro.sigma_rad_s, gyro_bias_);
  apply_white_noise(ideal.accelerometer, "accelerometer noise", options_.accelerometer.sigma_m_s2,
                    accelerometer_bias_);
  if (lost("image loss", ideal.t, options_.image.loss_fraction)) ideal.image = cv::Mat();
  if (!ideal.image.empty()) ideal.image = noisy(ideal.image, ideal.t);
  if (lost("plan loss", ideal.t, options_.plan.loss_fraction)) ideal.plan.reset();
  return ideal;
}

// A reading over a part of the 5 ms is a mean over less time: its noise is greater, so that the integral over
// the whole has the variance of an unsplit reading's.
void SensorErrors::apply_white_noise(std::vector<slam::InertialSample>& readings, const char* stream,
                                     double sigma, const Eigen::Vector3d& bias) const {
  for (slam::InertialSample& reading : readings) {
    const double duration_ns = static_cast<double>((reading.end - reading.begin).count());
    const double scaled = sigma * std::sqrt(kNominalPeriod_ns / duration_ns);
    reading.value += scaled * normal3(Random(seed_, stream, item(reading.end))) + bias;
  }
}

// Five pixels to each 64 random bits; fixed point with 20 binary places.
cv::Mat SensorErrors::noisy(const cv::Mat& image, slam::Stamp t) const {
  const std::array<int, 4096>& z = normal_table();
  Random random(seed_, "image noise", item(t));
  cv::Mat out(image.rows, image.cols, CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    const unsigned char* from = image.ptr(row);
    unsigned char* to = out.ptr(row);
    for (int column = 0; column < image.cols;) {
      std::uint64_t bits = random.bits();
      for (const int end = std::min(column + 5, image.cols); column < end; ++column, bits >>= 12) {
        const int grey = from[column];
        const int sum =
            (grey << 20) + z[bits & 4095] * sigma_of_grey_[static_cast<std::size_t>(grey)] + (1 << 19);
        to[column] = static_cast<unsigned char>(std::clamp(sum >> 20, 0, 255));
      }
    }
  }
  return out;
}

bool SensorErrors::lost(const char* stream, slam::Stamp t, double fraction) const {
  return fraction > 0 && Random(seed_, stream, item(t)).uniform() < fraction;
}

}  // namespace sim::stream
