// Runs command lines as elements of a Slurm job array.
#pragma once

#include <vector>

#include "tools/cli/jobs/backend.h"
#include "tools/cli/jobs/processes.h"

namespace cli {

/// Runs the command lines on Slurm, see run_all().
std::vector<Ended> run_on_slurm(const CommandLines& command_lines, const Backend& backend,
                                const ShowPart& show);

/// Removes the job arrays that an earlier call left in the spool, and the folder if nothing else is in it.
void remove_arrays(const std::filesystem::path& spool);

}  // namespace cli
