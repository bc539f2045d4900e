// Which observations and images the filter refuses.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

/// Why the observation is malformed: an image of the wrong type or size, or a reading or plan that is not
/// finite. Empty if it is well-formed.
std::string malformation(const Observation& observation, const CameraIntrinsics& camera);

/// Recognises images that contain no information.
class ImageCheck {
 public:
  /// Why the image, which is not empty, cannot be used: it is flat, or identical with the previous one.
  /// Empty if it can.
  std::string defect(const cv::Mat& image);

 private:
  cv::Mat previous_;
};

}  // namespace slam
