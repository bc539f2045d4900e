// The plan's own model of the whole robot: momentum by multibody dynamics, of the model file as it is.
#pragma once

#include <filesystem>
#include <string>

#include "walking/whole_body.h"

namespace sim::world {

/// models/<robot>.xml, loaded for the plan alone: it is free of the variations and disturbances of a run, and
/// the ankles' bushes are at rest. Copies share one state: not for use from several threads. Throws
/// std::runtime_error when the model does not load.
walking::WholeBody nominal_body(const std::string& robot, const std::filesystem::path& models);

}  // namespace sim::world
