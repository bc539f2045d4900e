// The built-in controller as a program: `gaitslam walker`.
#pragma once

namespace sim::live {

/// Answers the messages of gaitslam_walker.h on standard input and output by pattern generator and
/// stabilizer. Returns the exit code.
int run_plan_program();

}  // namespace sim::live
