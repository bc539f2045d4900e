// Results of earlier commands, moved out of the way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"
#include "tools/cli/jobs/results.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

class Stale : public testing::Test {
 protected:
  void make(const std::string& name) const {
    fs::create_directory(folder_ / name);
    sim::files::write_text(folder_ / name / "score.json", "{}");
  }
  const sim::files::TemporaryFolder folder_;
};

TEST_F(Stale, OnlyNamesAsTheProgramWritesThemAreResults) {
  for (const char* name : {"seed-1", "seed-2", "seed-10", "seed-07", "seed-+3", "seed-x", "seed-"})
    make(name);
  EXPECT_THAT(results_of_other_seeds(folder_.path(), {1}), ElementsAre("seed-2", "seed-10"));
}

TEST_F(Stale, WhatCannotBeMovedIsNamedAndTheOthersAreMoved) {
  make("seed-1");
  EXPECT_THAT(
      [&] {
        set_aside(folder_.path(), {"seed-7", "seed-1"});
      },
      ThrowsMessage<sim::files::FileError>(
          AllOf(HasSubstr("earlier-1: cannot be moved there: seed-7: No such file or directory"),
                Not(HasSubstr("seed-1:")))));
  EXPECT_TRUE(fs::exists(folder_ / "earlier-1/seed-1/score.json"));
  EXPECT_THROW(set_aside(folder_.path(), {"seed-7"}), sim::files::FileError);
  EXPECT_FALSE(fs::exists(folder_ / "earlier-2")) << "no empty folder stays";
}

}  // namespace
}  // namespace cli
