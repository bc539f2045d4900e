// Which key of a walk makes a plan that the legs cannot follow.
#pragma once

#include <functional>
#include <string>

#include "walking/plan.h"

namespace walking {

/// Returns whether the legs can follow the plan of these options.
using IsFeasible = std::function<bool(const WalkOptions&)>;

/// Describes the first single key that makes the walk infeasible: with its default (for a step: the value of
/// a step on the spot) the legs can follow the plan up to the end of that command. Keys of the walk are tried
/// before those of the command. command: index of the failing command. If no single key is the cause, the
/// text states it.
std::string cause_of_infeasible(const WalkOptions& options, int command, const IsFeasible& is_feasible);

}  // namespace walking
