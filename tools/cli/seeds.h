// Lists of seeds as users type them: 1..5, 1,2,7, or both.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cli {

/// In the order typed. Throws UsageError when the text is no such list, names a seed twice or more than 100
/// 000 seeds.
std::vector<std::uint64_t> parse_seeds(const std::string& text);

}  // namespace cli
