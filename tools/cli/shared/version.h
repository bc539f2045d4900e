// Sources and libraries of this program.
#pragma once

#include "sim/result/result.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

/// The project's version.
extern const char* const kVersion;

/// The source's git revision, "+" appended when files differed from it; "unknown" outside of a git checkout.
extern const char* const kRevision;

/// A hash of the sources that shape recordings: tools/cli/recording_sources.cmake has the list.
extern const char* const kRecordingSources;

/// Returns the libraries in use and their versions.
std::map<std::string, std::string> libraries();

/// Returns the place of a result that this program makes, which replaces an earlier one.
result::ResultPlace result_place(const fs::path& folder, const std::string& models_hash,
                                 const fs::path& models = {});

/// Returns the model name of the processor.
std::string processor();

/// Returns the identity of programs that record the same bits from a scenario unless its estimate steers the
/// walk: sources of walk, world and recording, build, libraries and the processor's vendor.
std::string recording_identity();

/// Returns the identity of programs that score a recording alike: revision, or hash if files differ from it.
std::string program_identity();

/// Returns the text of gaitslam --version.
std::string version_text();

}  // namespace cli
