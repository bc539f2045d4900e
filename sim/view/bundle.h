// The page, its script and its style sheet, bundled into the program when it is built.
#pragma once

#include <string_view>

namespace sim::view {

std::string_view page_html();  ///< TOKEN stands where the token is to be
std::string_view page_script();
std::string_view page_style();

}  // namespace sim::view
