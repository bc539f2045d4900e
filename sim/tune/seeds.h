// Lists of seeds as users write them: 1..5, or 1,2,7, or both.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace sim::tune {

/// The seeds in the order of the text. Throws std::invalid_argument, whose message says what is wrong and
/// what was expected, when the text is no such list, names a seed twice, or names more than 100 000 seeds.
std::vector<std::uint64_t> parse_seeds(std::string_view text);

}  // namespace sim::tune
