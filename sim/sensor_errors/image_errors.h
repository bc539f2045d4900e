// Errors of the camera's image: vignetting, exposure, noise, gain, and faults that dim or cover it.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "sim/sensor_errors/faults.h"

namespace sim::sensor_errors {

/// The scenario's keys errors.image.*. SensorErrors applies loss and latency; fixed-point noise sets ranges.
struct ImageOptions {
  double read_sigma_gray = 1.0, shot_sigma_gray = 1.0;
  double gain = 1.0;
  double vignetting_fraction = 0.0;
  double loss_fraction = 0.0;
  double latency_s = 0;

  static void keys(auto&& key) {
    number<&ImageOptions::read_sigma_gray>(key, 0, 100,
                                           "noise of a black pixel before the gain, in gray levels of 255");
    number<&ImageOptions::shot_sigma_gray>(
        key, 0, 50,
        "photon noise of a white pixel before the gain, in gray levels of 255; its square is proportional to "
        "the light");
    number<&ImageOptions::gain>(key, 0, 16, "gain of the camera, applied after the noise");
    number<&ImageOptions::vignetting_fraction>(
        key, 0, 1,
        "part of the light that is missing in the corners; it grows with the squared distance from "
        "the center");
    number<&ImageOptions::loss_fraction>(key, 0, 1, "fraction of the frames that lose their image");
    number<&ImageOptions::latency_s>(
        key, 0, 10, "least age of the picture that a frame brings; it brings the newest one that old");
  }
};

/// Image = gain (light + noise) with noise² = read² + shot² light / 255, drawn by seed, stream and stamp.
class ImageErrors {
 public:
  ImageErrors(const ImageOptions& sizes, std::uint64_t seed, const std::vector<Fault>& faults,
              std::string stream = "image noise");

  /// Returns a new image; `ideal` is CV_8UC1.
  cv::Mat apply(const cv::Mat& ideal, slam::Stamp t);

 private:
  cv::Mat covered(const cv::Mat& image, double fraction) const;

  /// Pixel of an amount of light (1/16 gray): its mean in 2^-20 gray and its noise in 1/256 gray.
  struct Response {
    int mean = 0, sigma = 0;
  };
  ImageOptions sizes_;
  std::uint64_t seed_;
  std::string stream_;
  std::vector<FramesDimmed> dimmed_;
  std::vector<FramesCovered> covers_;
  std::array<Response, 4096> responses_;
  cv::Mat vignette_;  // CV_32SC1, in 1/4096; made for the first image
};

}  // namespace sim::sensor_errors
