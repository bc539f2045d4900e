#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "sim/files/text.h"
#include "sim/pages/run_data.h"

namespace {

using sim::pages::Table;
using testing::ElementsAre;
using testing::HasSubstr;

class TableTest : public testing::Test {
 protected:
  std::filesystem::path file_ =
      testing::TempDir() + "gaitslam_table_" + testing::UnitTest::GetInstance()->current_test_info()->name();
  ~TableTest() override { std::filesystem::remove(file_); }
  Table table(const std::string& text) {
    std::ofstream(file_) << text;
    return Table(file_);
  }
  std::string complaint(const std::string& text) {
    try {
      table(text).numbers("b");
    } catch (const sim::files::FileError& e) {
      return e.what();
    }
    return "";
  }
};

TEST_F(TableTest, ColumnsAreFoundByTheirNamesWithoutUnit) {
  const Table t = table("#timestamp [ns],b [m],kind\n1500000000,2.5,point\n2000000000,,line\n");
  EXPECT_EQ(t.rows(), 2u);
  EXPECT_THAT(t.seconds("timestamp"), ElementsAre(1.5, 2));
  EXPECT_EQ(t.numbers("b")[0], 2.5);
  EXPECT_TRUE(std::isnan(t.numbers("b")[1])) << "an empty field is not zero";
  EXPECT_THAT(t.text("kind"), ElementsAre("point", "line"));
}

TEST_F(TableTest, ARowOfAnotherLengthIsNamed) {
  EXPECT_THAT(complaint("a,b\n1,2\n1\n"), HasSubstr(":3: expected 2 fields, found 1"));
}

TEST_F(TableTest, AMissingColumnAndAnEmptyFileAreNamed) {
  EXPECT_THAT(complaint("a,c\n1,2\n"), HasSubstr("no column 'b'"));
  EXPECT_THAT(complaint(""), HasSubstr("is empty"));
}

}  // namespace
