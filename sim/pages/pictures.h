// The pictures of a recording.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/pages/frame.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"

namespace sim::pages {

namespace fs = std::filesystem;

/// The pictures of a recording, which may be untrusted: a browser gets only files with the hashes in the
/// manifest.
class Pictures {
 public:
  /// Throws FileError if the recording is unfinished or its setup was edited.
  explicit Pictures(const fs::path& recording);
  /// Returns the image file of each frame, or "" if it has none; for a rig camera or lidar, the file of the
  /// newest reading. Throws FileError.
  std::vector<std::string> files(const std::vector<Frame>& frames, const std::string& sensor = "cam0") const;
  /// Returns the reading of a rig sensor or the head camera from a file. Throws FileError unless the file has
  /// the hash in the manifest and an image has the camera's size.
  slam::RigReading read(const rig::RigSensor& sensor, const std::string& file) const;
  const recording::RecordingSetup& setup() const { return setup_; }
  const recording::Manifest& manifest() const { return manifest_; }

 private:
  fs::path folder_;
  recording::Manifest manifest_;
  recording::RecordingSetup setup_;
};

}  // namespace sim::pages
