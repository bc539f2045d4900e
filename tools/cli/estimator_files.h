// The files of an estimator of others: what the walks that it steers depend on.
#pragma once

#include <string>

#include "sim/estimators/estimator_choice.h"

namespace cli {

/// Identifies the contents of an estimator's files: of its library, or of each word of its command that names
/// a file that can be read, the program itself found as a shell finds it. Empty for a built-in estimator. It
/// cannot know of files that no word names, such as what a script calls.
std::string estimator_files_identity(const sim::estimators::EstimatorChoice& choice);

}  // namespace cli
