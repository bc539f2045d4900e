// Converts frames and readings to the form that the page receives.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "sim/pages/frame.h"
#include "sim/rig/rig.h"
#include "slam/observation.h"

namespace sim::view {

using pages::FootPlace, pages::Frame;

/// Returns a frame as JSON for sim/view/web/run.js, which documents the keys. m, rad; null if not finite.
nlohmann::ordered_json to_json(const Frame& frame);

/// Returns the length of a JSON text (little-endian, four bytes) and the text, padded with blanks to a
/// multiple of four bytes.
std::string with_length(std::string json);
/// Returns a WebSocket message: with_length() of the JSON, then the gray image row by row.
std::string to_message(const Frame& frame);

/// Returns a rig reading for sim/view/web/sensors.js. Depth: width and height (uint32), then mm row by row
/// (uint16; 0: none). Other cameras: a PNG. Lidar: points in the head camera's frame, x, y, z (m) and
/// intensity as float32. IMU: nothing.
std::string sent(const slam::RigReading& reading, const rig::RigSensor& sensor);
/// Returns 256 colors from blue through green to red (turbo).
const cv::Mat3b& palette();

}  // namespace sim::view
