// Damage to a file's bytes, drawn from a stream of random numbers: what a reader of outside input must bear.
#pragma once

#include <array>
#include <string>

#include "sim/stream/random.h"

namespace tests {

/// A place in the bytes, also just behind them.
inline std::size_t place(const std::string& bytes, sim::stream::Random& random) {
  return random.bits() % (bytes.size() + 1);
}

/// One to four wounds: bytes changed, bits flipped, pieces lost, doubled or moved, numbers replaced by
/// extreme ones, the end cut off.
inline std::string damaged(std::string bytes, sim::stream::Random& random) {
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
  for (std::uint64_t wounds = 1 + random.bits() % 4; wounds > 0; --wounds) {
    const std::size_t at = place(bytes, random), length = random.bits() % 30;
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
        bytes.insert(place(bytes, random), bytes.substr(at, length));
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
