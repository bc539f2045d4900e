// The scenario keys of the simulated head camera. The only header of sim/camera that sim/scenario includes.
#pragma once

#include <array>
#include <string_view>

namespace sim::camera {

enum class Lens { wide, pinhole };
inline constexpr std::array<std::string_view, 2> kLenses{"wide", "pinhole"};

/// The scenario's keys camera.*. The wide lens is the paper's camera.
struct CameraOptions {
  int width_px = 320, height_px = 240;
  double rate_hz = 30;
  Lens lens = Lens::wide;
  double distortion = 1;
  int samples = 0;
  double exposure_s = 0;
  double readout_s = 0;
  int subframes = 8;

  static void keys(auto&& key) {
    number<&CameraOptions::width_px>(key, 32, 4096, "width of the image");
    number<&CameraOptions::height_px>(key, 32, 4096, "height of the image");
    number<&CameraOptions::rate_hz>(key, 0.1, 1000, "frames per second of simulated time");
    choice<&CameraOptions::lens>(
        key, kLenses, "lens: wide (one-parameter radial, 91.6 deg across) or pinhole (ideal, 90 deg across)");
    number<&CameraOptions::distortion>(
        key, 0, 1.3, "radial parameter of the wide lens relative to that of the paper's camera");
    number<&CameraOptions::samples>(
        key, 0, 16,
        "multisamples of the renderer; 0: a denser picture is smoothed instead, which is twice as fast");
    number<&CameraOptions::exposure_s>(key, 0, 0.1, "exposure time of each row, which causes motion blur");
    number<&CameraOptions::readout_s>(
        key, 0, 0.1, "time from the first row's exposure to the last row's (rolling shutter)");
    number<&CameraOptions::subframes>(
        key, 2, 64, "pictures rendered for each frame when exposure_s or readout_s is not 0");
  }
};

}  // namespace sim::camera
