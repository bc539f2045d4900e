// The script and the style sheet of the pages, bundled into the program when it is built.
#pragma once

#include <string_view>

namespace sim::pages {

std::string_view page_script();
std::string_view page_style();

}  // namespace sim::pages
