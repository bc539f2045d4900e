// about.json as read: which program made a result, of which walk, and who set which key.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "sim/scenario/ending.h"

namespace sim::result {

/// What about.json says. What the file leaves out is empty.
struct About {
  std::string program, version, revision;
  std::string scenario, estimator;
  std::uint64_t seed = 0;
  std::string cause;  ///< of the run's ending
  std::optional<scenario::Ended> walk;
  std::string counterfactual;  ///< of a replay: why its filter would have steered another walk
  std::string alignment;       ///< by which the truth placed a trajectory of another program in W; else empty
  std::string recording;       ///< the hash of its manifest
  std::string models;          ///< the hash of the models that the walk was simulated with
  std::map<std::string, std::string, std::less<>> set_by;
};

/// Reads an about.json. Throws FileError "file: key: ..." where it cannot be read or a value has another
/// type.
About read_about(const std::filesystem::path& file);

/// The same, for a result that is to be replayed: throws FileError also where the walk's ending is missing.
About read_about_of_walk(const std::filesystem::path& file);

}  // namespace sim::result
