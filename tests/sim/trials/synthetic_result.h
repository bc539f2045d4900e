// A result folder with the recording of a walk in the synthetic room: what trials need, without a simulator.
#pragma once

#include <filesystem>
#include <string>

#include "tests/slam/synthetic_room.h"

namespace tests {

/// A walk along part of the circle, of that many frames.
slam::synthetic::Walk short_walk(int frames);

/// Writes folder/{scenario.yaml,about.json,recording/} of the walk with ideal sensors; `text` goes into the
/// scenario.
void write_result(const std::filesystem::path& folder, const slam::synthetic::Walk& walk,
                  const std::string& text = "");
/// Likewise with these images instead of those that the room shows.
void write_result(const std::filesystem::path& folder, const slam::synthetic::Walk& walk,
                  std::vector<cv::Mat> images, const std::string& text);

}  // namespace tests
