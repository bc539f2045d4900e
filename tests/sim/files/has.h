// Matchers of texts that contain all of several parts, or none of them.
#pragma once

#include <gmock/gmock.h>

namespace tests {

auto Has(const auto&... parts) { return testing::AllOf(testing::HasSubstr(parts)...); }
auto Lacks(const auto&... parts) { return testing::AllOf(testing::Not(testing::HasSubstr(parts))...); }

}  // namespace tests
