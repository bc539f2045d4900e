// The versions of this program's sources and libraries.
#pragma once

#include "sim/result/result.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

extern const char* const kVersion;

/// The git revision of the sources, "+" appended if files differed from it; "unknown" outside a checkout.
extern const char* const kRevision;

/// A hash of the sources that affect recordings, which tools/cli/revision.cmake lists.
extern const char* const kRecordingSources;

/// Returns the versions of Eigen, OpenCV and, if the program has the simulator, MuJoCo.
std::map<std::string, std::string> libraries();

/// Returns the place for a result made by this program, which replaces an earlier one.
result::ResultPlace result_place(const fs::path& folder, const std::string& models_hash,
                                 const fs::path& models = {});

/// Returns the processor's model name.
std::string processor();

/// Returns a text that is equal for all programs that record the same bits (unless the estimate steers the
/// walk): sources of walk, world and recording, build, libraries and the processor's vendor.
std::string recording_identity();

/// Returns a text that is equal for all programs that score a recording in the same way: the revision, or a
/// hash of the program if files differ from it.
std::string program_identity();

/// Returns the text that gaitslam --version prints.
std::string version_text();

}  // namespace cli
