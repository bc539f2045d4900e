// The scenario keys of the simulated head camera. The only header of sim/camera that sim/scenario includes.
#pragma once

#include "sim/rig/options.h"

namespace sim::camera {

/// The scenario's keys camera.*. The mount is relative to the place that the model gives the camera.
struct CameraOptions : rig::Mount {
  int width_px = 320, height_px = 240;
  double rate_hz = 30, distortion = 1, fov_rad = 0;
  double exposure_s = 0, readout_s = 0;
  int subframes = 8;

  static void keys(auto&& key) {
    rig::Mount::keys(key);
    number<&CameraOptions::width_px>(key, 32, 4096, "width of the image");
    number<&CameraOptions::height_px>(key, 32, 4096, "height of the image");
    number<&CameraOptions::rate_hz>(key, 0.1, 1000, "frames per second of simulated time");
    number<&CameraOptions::distortion>(
        key, 0, 1.3, "radial parameter relative to that of the paper's camera; 0: an ideal pinhole");
    degrees<&CameraOptions::fov_rad>(
        key, 0, 120, "horizontal field of view without distortion; 0: that of the paper's camera");
    number<&CameraOptions::exposure_s>(key, 0, 0.1, "exposure time of each row, which causes motion blur");
    number<&CameraOptions::readout_s>(
        key, 0, 0.1, "time from the first row's exposure to the last row's (rolling shutter)");
    number<&CameraOptions::subframes>(
        key, 2, 64, "pictures rendered for each frame when exposure_s or readout_s is not 0");
  }
};

}  // namespace sim::camera
