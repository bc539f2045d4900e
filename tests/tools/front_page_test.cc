// The front page shows the last measurements of tools/figures/front_page.py.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

namespace {

std::string text_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(GAITSLAM_SOURCE_DIR "/" + file).rdbuf();
  return text.str();
}

/// The text between the markers of a part of the page, or "marker missing".
std::string shown(const std::string& page, const std::string& part) {
  const std::string begin = "<!-- " + part + ": tools/figures/front_page.py -->\n",
                    end = "<!-- end of " + part + " -->\n";
  const std::size_t from = page.find(begin), to = page.find(end);
  if (from == page.npos || to == page.npos) return "marker missing";
  return page.substr(from + begin.size(), to - from - begin.size());
}

TEST(FrontPage, ShowsWhatItsScriptMeasuredLast) {
  const std::string page = text_of("README.md"), stored = text_of("tools/figures/front_page.md");
  ASSERT_GT(stored.size(), 1000u);
  EXPECT_EQ(shown(page, "scores") + "\n" + shown(page, "first run"), stored);
}

TEST(FrontPage, IsOnePage) {
  const std::string page = text_of("README.md");
  EXPECT_LE(std::count(page.begin(), page.end(), '\n'), 150);
}

}  // namespace
