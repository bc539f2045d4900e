// What the page is told of a run besides its frames.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/view/model.h"
#include "slam/options.h"

namespace sim::view {

/// A moment worth a look. kind: "closure", "fault", "lost", "suspect" or "end".
struct Moment {
  double t_s = 0;
  std::string kind, text;
};

struct ShownRun {
  std::string label;  ///< "tangent_circle, seed 1"
  std::optional<slam::CameraIntrinsics> camera = std::nullopt;
  double duration_s = 0;  ///< 0: not known yet
  std::vector<Moment> moments = {};
  std::vector<std::string> missing = {};  ///< what is not shown and why, in sentences
  std::optional<Model> model = std::nullopt;
  bool next_follows = false;  ///< another walk is shown at the same address after this one
};

/// The faults that a scenario injects.
std::vector<Moment> faults_of(const scenario::Scenario& scenario);

nlohmann::ordered_json to_json(const ShownRun& run);

}  // namespace sim::view
