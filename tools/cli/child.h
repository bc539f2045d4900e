// Another program, run to its end.
#pragma once

#include <string>
#include <vector>

namespace cli {

/// Runs argv[0], found by PATH, without a shell and without input. Throws std::runtime_error when it cannot
/// be started or does not end with 0; what it says goes to our standard error.
void run_child(const std::vector<std::string>& argv);

}  // namespace cli
