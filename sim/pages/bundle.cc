// Embeds the files that esbuild makes from web/.
#include "sim/pages/bundle.h"

#define GAITSLAM_EMBED(name, file)                                                          \
  asm(".section .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name "_end:\n.text\n"); \
  extern "C" const char name##_begin[] __attribute__((visibility("hidden")));               \
  extern "C" const char name##_end[] __attribute__((visibility("hidden")));

GAITSLAM_EMBED(gaitslam_pages_script, GAITSLAM_BUNDLE "/bundle.js")
GAITSLAM_EMBED(gaitslam_pages_style, GAITSLAM_BUNDLE "/bundle.css")

namespace sim::pages {

std::string_view page_script() { return {gaitslam_pages_script_begin, gaitslam_pages_script_end}; }
std::string_view page_style() { return {gaitslam_pages_style_begin, gaitslam_pages_style_end}; }

}  // namespace sim::pages
