// Embeds the page and the files that esbuild makes from web/.
#include "sim/view/bundle.h"

#define GAITSLAM_EMBED(name, file)                                                          \
  asm(".section .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name "_end:\n.text\n"); \
  extern "C" const char name##_begin[] __attribute__((visibility("hidden")));               \
  extern "C" const char name##_end[] __attribute__((visibility("hidden")));

GAITSLAM_EMBED(gaitslam_view_page, GAITSLAM_VIEW_PAGE)
GAITSLAM_EMBED(gaitslam_view_script, GAITSLAM_VIEW_BUNDLE "/view.js")
GAITSLAM_EMBED(gaitslam_view_style, GAITSLAM_VIEW_BUNDLE "/view.css")

namespace sim::view {

std::string_view page_html() { return {gaitslam_view_page_begin, gaitslam_view_page_end}; }
std::string_view page_script() { return {gaitslam_view_script_begin, gaitslam_view_script_end}; }
std::string_view page_style() { return {gaitslam_view_style_begin, gaitslam_view_style_end}; }

}  // namespace sim::view
