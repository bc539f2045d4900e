// What turns a rendered picture into that of a real camera: uneven and changing light, noise, gain, and what
// goes wrong for a while.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/stream/faults.h"
#include "slam/observation.h"

namespace sim::stream {

/// The scenario's keys errors.image.*.
struct ImageOptions {
  double read_sigma_grey = 1.0;  ///< noise of a black pixel, grey levels of 255 before the gain; at most 100
  double shot_sigma_grey =
      1.0;            ///< noise of a white pixel from counting light alone; its square goes with the grey
  double gain = 1.0;  ///< applied after the noise
  double vignetting_fraction =
      0.0;  ///< of the light lacks in the corners; grows with the squared distance from the centre
  double exposure_sigma_fraction = 0.0;  ///< how far the exposure wanders from its mean
  double exposure_time_s = 1.0;          ///< in which it wanders
  double loss_fraction = 0.0;            ///< of frames whose picture does not arrive (see SensorErrors)
  double latency_s = 0;  ///< a frame brings the newest picture that is at least this old (likewise)
};

/// Draws are keyed by seed and stamp. out = gain (light + noise), noise² = read² + shot² light / 255.
class ImageErrors {
 public:
  ImageErrors(const ImageOptions& sizes, std::uint64_t seed, const std::vector<Fault>& faults);

  /// A new picture. `ideal`: CV_8UC1.
  cv::Mat apply(const cv::Mat& ideal, slam::Stamp t);

 private:
  double exposure(slam::Stamp t) const;
  cv::Mat covered(const cv::Mat& image, double fraction) const;
  cv::Mat evenly_lit(const cv::Mat& image, int weight, slam::Stamp t) const;
  cv::Mat vignetted(const cv::Mat& image, int weight, slam::Stamp t);

  /// What a light (1/16 grey) gives: its mean in 2^-20 and its noise in 1/256 grey.
  struct Response {
    int mean = 0, sigma = 0;
  };
  ImageOptions sizes_;
  std::uint64_t seed_;
  std::vector<FramesDimmed> dimmed_;
  std::vector<FramesCovered> covers_;
  std::array<Response, 4096> responses_;
  cv::Mat vignette_;  // CV_32SC1, in 1/4096; made for the first picture
};

}  // namespace sim::stream
