// Finds a robot's gait by walking: short walks with many gaits, searched by CMA-ES.
#pragma once

#include <functional>

#include "sim/physics/adapted.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

struct GaitSearch {
  int generations = 6, population = 6;
  std::uint64_t seed = 1;  ///< of the search
};

/// Searches from the guessed gait and a few that often work, on one plant and with rigid arms, until a
/// gait arrives everywhere without much slip. The best three are then walked on
/// two other plants, until one arrives everywhere. A gait is better if it completes more of the short walks
/// within 15 degrees and 10 % of their paths; then if torques are at their limits for less time, if walks end
/// closer to their commands, and if soles slip less. The same seed gives the same file on the same machine.
/// better is called with the text of robot.yaml at first and whenever a better gait is found; show with the
/// fraction that is done and what the best gait does. model_written: the model's path in that text.
void search_gait(const fs::path& model, const std::string& model_written, const GaitSearch& search,
                 const std::function<void(const std::string& yaml)>& better,
                 const std::function<void(double part, const std::string& at)>& show);

}  // namespace cli
