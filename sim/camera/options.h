// The scenario keys of the simulated head camera. The only header of sim/camera that sim/scenario includes.
#pragma once

#include "sim/rig/rig.h"

namespace sim::camera {

/// The scenario's keys camera.*. The mount is relative to the place that the model gives the camera.
struct CameraOptions : rig::Mount, rig::Imager {
  double distortion = 1, fov_rad = 0;

  static void keys(auto&& key) {
    rig::Mount::keys(key);
    rig::Imager::size_keys(key);
    number<&CameraOptions::distortion>(
        key, 0, 1.3, "radial parameter relative to that of the paper's camera; 0: an ideal pinhole");
    degrees<&CameraOptions::fov_rad>(
        key, 0, 120, "horizontal field of view without distortion; 0: that of the paper's camera");
    rig::Imager::shutter_keys(key);
  }
};

}  // namespace sim::camera
