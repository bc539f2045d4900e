#include "sim/pages/html.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

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
  EXPECT_THAT(page(), HasSubstr("<td>walks/seed-3</td>"));
}

TEST_F(ReceivedTuning, NoHoldOutIsNamed) {
  tuning_["holdout"]["runs"] = nlohmann::json::array();
  try {
    page();
    ADD_FAILURE();
  } catch (const sim::files::FileError& e) {
    EXPECT_THAT(e.what(), HasSubstr("tune.json: holdout.runs: is empty"));
  }
}

TEST_F(ReceivedTuning, RunsAreListedBeforeAndAfterWithTheirMeans) {
  EXPECT_THAT(page(), HasSubstr("<tr><td>mean</td><td class='number'>1.5</td><td class='number'>1</td>"));
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

TEST(Table, ColumnsAreFoundByTheirNamesWithoutUnit) {
  const sim::files::TemporaryFolder folder;
  const auto file = folder / "table.csv";
  sim::files::write_text(file, "#timestamp [ns],b [m],kind\n1500000000,2.5,point\n2000000000,,line\n");
  const Table t(file);
  EXPECT_EQ(t.rows(), 2u);
  EXPECT_THAT(t.seconds("timestamp"), testing::ElementsAre(1.5, 2));
  EXPECT_EQ(t.numbers("b")[0], 2.5);
  EXPECT_TRUE(std::isnan(t.numbers("b")[1])) << "an empty field is not zero";
  EXPECT_THAT(t.text("kind"), testing::ElementsAre("point", "line"));
  EXPECT_THROW(t.text("a"), sim::files::FileError);
  sim::files::write_text(file, "");
  EXPECT_THROW(Table{file}, sim::files::FileError);
}

}  // namespace
