// Whether tracking still holds, told by how much of what was looked for is found and by the innovations.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "slam/options.h"

namespace slam {

/// What one frame's images and measurements say of tracking. NIS per degree of freedom, absent without a
/// measurement.
struct Glance {
  double dt_s = 0;
  std::size_t searched = 0, accepted = 0;  ///< landmarks
  std::optional<double> vision_nis, height_nis;
  double spread = 1;  ///< part of the image that those searched for span
};

/// Almost nothing found of what is looked for, all over the image: less is something in front of the rest.
bool blind(const Glance& glance);

class TrackingWatch {
 public:
  explicit TrackingWatch(const Options::Tracking& options) : options_(options) {}

  /// Takes a frame in. Why tracking is lost; empty while it holds.
  std::string judge(const Glance& glance);
  /// The last frames were blind.
  bool in_doubt() const { return blind_s_ > 0; }
  /// Forgets all frames.
  void begin_anew() { *this = TrackingWatch(options_); }

 private:
  static constexpr std::size_t kWindow = 15;  // measurements
  struct Mean {                               // of the last kWindow
    std::array<double, kWindow> values{};
    std::size_t count = 0;
    bool beyond(const std::optional<double>& value, double bound);
  };

  Options::Tracking options_;
  double blind_s_ = 0;
  Mean vision_, height_;
};

}  // namespace slam
