// SHA-256: the hash by which a page names the script that a browser may run.
#pragma once

#include <string>
#include <string_view>

namespace sim::files {

/// SHA-256 (FIPS 180-4) of the bytes: 32 bytes.
std::string sha256(std::string_view bytes);

}  // namespace sim::files
