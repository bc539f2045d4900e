// Which observations and images the filter refuses.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "slam/observation.h"
#include "slam/options.h"
#include "slam/plan.h"

namespace slam {

/// Why the observation is malformed: an image of the wrong type or size, or a reading or plan that is not
/// finite. Empty if it is well-formed.
std::string malformation(const Observation& observation, const CameraIntrinsics& camera);

/// True if the camera is known to have stood still in a frame interval: the plan stands and the gyro reads
/// nothing but noise. Sensors that the options do not enable are not asked. planned: the planned motion of
/// the interval, if there is one.
bool stands_still(const Observation& observation, const std::optional<PlannedVelocity>& planned,
                  const Options& options);

/// Why an image cannot be used.
struct ImageDefect {
  std::string reason;  ///< empty if it can
  /// Nothing is seen. False for an image identical with the previous one that may yet be a true one, because
  /// the camera is known to stand still, and not known to have noise.
  bool blinds = false;
};

/// Recognises images that contain no information.
class ImageCheck {
 public:
  /// The defect of an image that is not empty: it is flat, or identical with the previous one.
  ImageDefect defect(const cv::Mat& image, bool stands_still);

 private:
  void look_for_noise(const cv::Mat& image);

  cv::Mat previous_;
  int noisy_ = 0;  // images that differed all over from the previous one while the camera stood still
};

}  // namespace slam
