// Command lines as elements of a Slurm job array.
#pragma once

#include "tools/cli/backend.h"

namespace cli {

/// run_all() on Slurm.
std::vector<Ended> run_on_slurm(const CommandLines& command_lines, const Backend& backend,
                                const ShowPart& show);

}  // namespace cli
