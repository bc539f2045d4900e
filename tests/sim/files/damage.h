// Random damage to a file's bytes, for tests of the readers of outside input.
#pragma once

#include <array>
#include <string>

#include "sim/sensor_errors/random.h"

namespace tests {

/// A random index into the bytes, from 0 to their number.
inline std::size_t random_index(const std::string& bytes, sim::sensor_errors::Random& random) {
  return random.bits() % (bytes.size() + 1);
}

/// Applies one to four edits: bytes changed, bits flipped, pieces removed, copied, or replaced by extreme
/// numbers and syntax, the end cut off.
inline std::string damaged(std::string bytes, sim::sensor_errors::Random& random) {
  using namespace std::string_literals;
  static const std::array kWords{"9223372036854775807"s,
                                 "-9223372036854775808"s,
                                 "1e308"s,
                                 "-1"s,
                                 "nan"s,
                                 "0"s,
                                 "99999999999999999999"s,
                                 ""s,
                                 ","s,
                                 "\n"s,
                                 "[[[["s,
                                 "{"s,
                                 "&a *a"s,
                                 "\0"s,
                                 "\xff\xfe"s,
                                 "#"s,
                                 ": "s,
                                 "- "s,
                                 "'"s,
                                 "../.."s};
  for (std::uint64_t edits = 1 + random.bits() % 4; edits > 0; --edits) {
    const std::size_t at = random_index(bytes, random), length = random.bits() % 30;
    switch (random.bits() % 6) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(random.bits());
        break;
      case 1:
        if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.bits() % 8));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(random_index(bytes, random), bytes.substr(at, length));
        break;
      case 4:
        bytes.replace(at, random.bits() % 12, kWords[random.bits() % kWords.size()]);
        break;
      default:
        if (random.bits() % 4 == 0) bytes.resize(at);
    }
  }
  return bytes;
}

}  // namespace tests
