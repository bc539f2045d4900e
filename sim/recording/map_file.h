// A filter's map in a file, for later sessions.
#pragma once

#include "sim/files/text.h"
#include "slam/saved_map.h"

namespace sim::recording {

/// Returns the file of a map: one line of JSON (version, frame, sessions, camera, sizes), little-endian
/// numbers for each landmark, the lower triangle of the covariance, and a hash of all this (32 hexadecimal
/// digits).
std::string map_bytes(const slam::SavedMap& map);

/// Reads the same bits. Throws FileError if the file was changed or truncated, if its numbers are not those
/// of a map, or if its camera is not the given one.
slam::SavedMap read_map(const fs::path& file, const slam::CameraIntrinsics& camera);

}  // namespace sim::recording
