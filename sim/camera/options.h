// The scenario keys of the simulated head camera. The only header of sim/camera that sim/scenario includes.
#pragma once

#include <chrono>
#include <cmath>

#include "sim/rig/rig.h"

namespace sim::camera {

/// The scenario's keys camera.*. The mount is relative to the camera's place in the model.
struct CameraOptions : rig::Mount, rig::Imager {
  double distortion = 1, fov_rad = 0;

  /// Returns the time from a frame's stamp until its image is complete.
  std::chrono::milliseconds lead() const {
    return std::chrono::milliseconds(std::llround(std::ceil(1e3 * (exposure_s + readout_s) / 2 - 1e-9)));
  }

  static void keys(auto&& key) {
    rig::Mount::keys(key);
    rig::Imager::size_keys(key);
    number<&CameraOptions::distortion>(
        key, 0, 1.3, "radial parameter relative to the paper's camera; 0: an ideal pinhole");
    degrees<&CameraOptions::fov_rad>(
        key, 0, 120, "horizontal field of view without distortion; 0: same as the paper's camera");
    rig::Imager::shutter_keys(key);
  }
};

}  // namespace sim::camera
