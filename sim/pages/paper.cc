#include "sim/pages/paper.h"

namespace sim::pages {

const std::vector<PaperExperiment>& paper_experiments() {
  static const std::vector<PaperExperiment> kAll{
      {"tangent_quadrant", "", 2},
      {"perpendicular_circle_trial1", "", 8},
      {"tangent_circle", "", 17},
      {"tangent_circle_paper", "tangent_circle", 4},
      {"vision_only", "tangent_circle", 4},
      {"vision_gyro_known_landmarks", "tangent_circle", 4},
      {"perpendicular_circle", "", 30},
      {"perpendicular_circle_paper", "perpendicular_circle", 7},
      {"hall", "", 18},
      {"hall_paper", "hall", 4},
  };
  return kAll;
}

const std::vector<RunData>& runs_of(const PaperRuns& all, const std::string& experiment) {
  static const std::vector<RunData> none;
  const auto found = all.find(experiment);
  return found == all.end() ? none : found->second;
}

std::string agreement_text(Agreement agreement) {
  constexpr const char* kTexts[] = {"", "agrees", "better", "differs"};
  return kTexts[static_cast<int>(agreement)];
}

}  // namespace sim::pages
