// What this program was built from.
#pragma once

#include <map>
#include <string>

namespace cli {

/// The project's version.
extern const char* const kVersion;

/// The source's git revision, "+" appended when files differed from it; "unknown" outside of a git checkout.
extern const char* const kRevision;

/// The libraries in use and their versions.
std::map<std::string, std::string> libraries();

/// The processor's name, as people know it.
std::string processor();

/// What tells programs apart that may record other bits from one scenario: the revision (of one with changes,
/// or none, a hash of the program itself), how it was built, the libraries, and the processor's maker.
std::string program_identity();

/// All of the above as text for people.
std::string version_text();

}  // namespace cli
