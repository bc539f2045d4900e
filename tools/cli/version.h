// What this program was built from.
#pragma once

#include <map>
#include <string>

namespace cli {

/// The project's version.
extern const char* const kVersion;

/// The source's git revision, "+" appended when files differed from it; "unknown" outside of a git checkout.
extern const char* const kRevision;

/// A hash of the sources that shape recordings: tools/cli/recording_sources.cmake has the list.
extern const char* const kRecordingSources;

/// The libraries in use and their versions.
std::map<std::string, std::string> libraries();

/// The processor's name, as people know it.
std::string processor();

/// What tells programs apart that may record other bits from one scenario: the sources of walk, world and
/// recording, how they were built, the libraries, and the processor's maker.
std::string recording_identity();

/// What tells programs apart that may score one recording otherwise: the revision, and of one with changes, or
/// none, a hash of the program itself.
std::string program_identity();

/// All of the above as text for people.
std::string version_text();

}  // namespace cli
