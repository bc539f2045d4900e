#include "sim/pages/html.h"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/pages/paper.h"
#include "tests/sim/files/temporary_folder.h"

namespace {

using namespace sim::pages;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPayload = R"(</title></script><img src=x onerror='a()'>"<!--&)";
constexpr const char* kShown =
    "&lt;/title&gt;&lt;/script&gt;&lt;img src=x onerror=&#39;a()&#39;&gt;&quot;&lt;!--&amp;";

TEST(Html, TextIsShownAsItIsInElementsAndAttributes) {
  EXPECT_EQ(escaped(kPayload), kShown);
  EXPECT_EQ(escaped("ATE of 5 mm, 3 \xcf\x83"), "ATE of 5 mm, 3 \xcf\x83");
}

TEST(Html, DataCannotEndItsScriptElement) {
  const std::string html = data_script("data", nlohmann::json{{"name", kPayload}}.dump());
  const std::string inside = html.substr(html.find('>') + 1, html.rfind("</script>") - html.find('>') - 1);
  EXPECT_THAT(inside, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(inside)["name"], kPayload);
}

TEST(Html, ThePolicyAllowsTheScriptsByTheirHashesAndNothingElse) {
  const std::string with = html_page("a", "", "", {"alert('Hello, world.');"}),
                    without = html_page("a", "", "", {});
  // The example of the specification of Content Security Policies, level 3, section 8.3.
  EXPECT_THAT(with, HasSubstr("script-src 'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng=';"));
  EXPECT_THAT(without, HasSubstr("script-src 'none';"));
  for (const std::string& page : {with, without}) {
    EXPECT_THAT(page, HasSubstr("default-src 'none';"));
    EXPECT_THAT(page, HasSubstr("base-uri 'none'; form-action 'none'"));
    EXPECT_THAT(page, Not(HasSubstr("script-src 'unsafe-inline'")));
    EXPECT_LT(page.find("Content-Security-Policy"), page.find("<title>")) << "it applies to what follows it";
  }
}

TEST(Html, AScriptThatEndsItsElementIsNotWritten) {
  for (const char* script : {"a = '</script>'", "a = '<!--'", "a\r\n"})
    EXPECT_THROW(html_page("a", "", "", {script}), std::logic_error) << script;
  EXPECT_GT(page_script().size() + map_script().size(), 100000u) << "they are in the program";
}

TEST(Html, Base64GivesTheTestVectorsOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

/// Without the scripts of the page, which are the same for all.
std::string without_scripts(const std::string& page) { return page.substr(0, page.find("<script>")); }

void expect_harmless(const std::string& page) {
  const std::string html = without_scripts(page);
  EXPECT_THAT(html, HasSubstr("Content-Security-Policy"));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr(kShown));
}

class ReceivedTuning : public testing::Test {
 protected:
  ReceivedTuning() {
    const nlohmann::json sides{{"start", {1, 2}}, {"best", {1, nullptr}}};
    nlohmann::json side{{"runs", {kPayload, kPayload}}};
    for (const char* name : {kPayload, "nees_position_mean", "nees_orientation_mean"})
      side["values"][name] = sides;
    tuning_ = {{"accepted", true},
               {"name", kPayload},
               {"objective", kPayload},
               {"parameters",
                {{{"key", kPayload},
                  {"unit", kPayload},
                  {"from", 1},
                  {"to", 2},
                  {"scale", "log"},
                  {"start", 1},
                  {"best", 2}}}},
               {"training", side},
               {"holdout", side}};
  }
  std::string page() const {
    std::ofstream(folder_ / "tune.json") << tuning_.dump();
    std::ofstream(folder_ / "history.csv")
        << "#setting,origin," << kPayload << "," << kPayload << "2\n0,a,1.5,3\n1,a,1.2,2\n";
    return tune_page(folder_.path());
  }
  nlohmann::json tuning_;
  const sim::files::TemporaryFolder folder_;
};

TEST_F(ReceivedTuning, NamesAreShownAsTheyAre) {
  tuning_["objective"] = std::string(kPayload) + "2";
  for (const char* side : {"training", "holdout"})
    tuning_[side]["values"][std::string(kPayload) + "2"] = tuning_[side]["values"][kPayload];
  expect_harmless(page());
}

TEST_F(ReceivedTuning, AHoldOutOfOneRunIsAWarning) {
  EXPECT_THAT(page(), Not(HasSubstr("The hold-out is one run")));
  tuning_["holdout"]["runs"] = {"walks/seed-3"};
  EXPECT_THAT(page(), HasSubstr("The hold-out is one run"));
  EXPECT_THAT(page(), HasSubstr("<li id='holdout-1'>walks/seed-3: "));
}

TEST_F(ReceivedTuning, AnotherTypeIsNamedWithItsKey) {
  const nlohmann::json whole = tuning_;
  const auto complaint = [&](const nlohmann::json& patch) -> std::string {
    tuning_ = whole;
    tuning_.merge_patch(patch);
    try {
      page();
    } catch (const sim::files::FileError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(complaint({{"accepted", 1}}),
              HasSubstr("tune.json: accepted: expected true or false, found number"));
  EXPECT_THAT(complaint({{"parameters", 5}}),
              HasSubstr("tune.json: parameters: expected a list, found number"));
  EXPECT_THAT(complaint({{"holdout", {{"runs", nlohmann::json::array()}}}}),
              HasSubstr("holdout.runs: is empty"));
}

TEST(PaperPage, TheRevisionIsShownAsItIs) { expect_harmless(paper_page({}, kPayload)); }

TEST(Figure, NamesAreShownAsTheyAre) {
  Figure figure{"a", kPayload, kPayload, kPayload};
  figure.lines = {{kPayload, Role::truth, {0, 1}, {0, 1}}};
  figure.levels = {{kPayload, 0.5}};
  figure.moments = {{kPayload, 0.5}};
  EXPECT_THAT(to_svg(figure, 100, 100), Not(HasSubstr("<img")));
  EXPECT_THAT(to_svg(figure, 100, 100), HasSubstr(kShown));
}

}  // namespace
