// Which key of a walk makes a plan that the legs cannot follow.
#pragma once

#include <functional>
#include <string>

#include "walking/plan.h"

namespace walking {

/// Whether the legs can follow the plan of these options.
using IsFeasible = std::function<bool(const WalkOptions&)>;

/// In words, the first key that alone makes the walk infeasible: with its default, or for a step with the
/// value of a step on the spot, the legs can follow the plan up to the end of that command. Keys of the walk
/// are tried before those of the command. command: the index of the command in which the legs fail. Says so
/// where no single key is the cause.
std::string cause_of_infeasible(const WalkOptions& options, int command, const IsFeasible& is_feasible);

}  // namespace walking
