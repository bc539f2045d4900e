// The search for the best setting: CMA-ES over the whole range, then Nelder and Mead's method from the best.
#pragma once

#include "sim/tune/study.h"

namespace sim::tune {

/// Tries the start of the spec and then further settings, spec.trials in all. Which settings are tried
/// depends on the spec and the losses found alone.
void search(Study& study);

/// Nelder and Mead's search from the best setting so far; tries at most that many settings.
void polish(Study& study, int trials);

}  // namespace sim::tune
