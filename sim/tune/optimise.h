// The search for the best setting: CMA-ES or one of pagmo's optimisers, then Nelder and Mead's.
#pragma once

#include <vector>

#include "sim/tune/study.h"

namespace sim::tune {

/// Tries the start, then spec.trials settings in all, as the spec's optimiser and its seed have it. What is
/// tried depends on nothing but the spec and the values found.
void search(Study& study);

/// Nelder and Mead's search from the best setting so far: so many settings at most.
void polish(Study& study, int trials);

/// Of two objectives: the complete candidates that no other is better than in both, by the first objective.
std::vector<const Candidate*> pareto_front(const std::vector<Candidate>& candidates);
/// The one of a front that is nearest to its ideal corner, both objectives scaled by the front's extent.
const Candidate& compromise(const std::vector<const Candidate*>& front);

}  // namespace sim::tune
