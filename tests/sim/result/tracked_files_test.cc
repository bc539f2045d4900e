#include <gtest/gtest.h>

#include "sim/files/csv.h"
#include "sim/result/result.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::result {
namespace {

TEST(TrackedFiles, TextsOfAFrameRoundTrip) {
  const std::string words[] = {"plain",
                               "inconsistent: plan, its distances are too long by 9 standard deviations",
                               "it reads \"no\", twice",
                               "\"quoted\"",
                               "two\nlines\r\n",
                               " blanks ",
                               "\"",
                               "",
                               "\x01\t\x7f"};
  tracking::Tracked tracked;
  for (const std::string& cause : words) {
    tracking::TrackedFrame frame;
    frame.report.t = std::chrono::seconds(tracked.frames.size());
    frame.report.health = slam::Health::lost;
    frame.report.cause = cause, frame.report.refused = "gyro, " + cause, frame.report.suspect = cause + ",";
    tracked.frames.push_back(frame);
  }
  const files::TemporaryFolder folder;
  write_tracked(folder.path(), tracked);
  files::CsvReader rows(folder / "frames.csv");
  for (const std::string& cause : words) {
    ASSERT_TRUE(rows.next());
    const std::size_t n = rows.fields();
    EXPECT_EQ(rows.text(n - 4), "lost");
    EXPECT_EQ(rows.text(n - 3), cause);
    EXPECT_EQ(rows.text(n - 2), "gyro, " + cause);
    EXPECT_EQ(rows.text(n - 1), cause + ",");
  }
  EXPECT_FALSE(rows.next());
}

}  // namespace
}  // namespace sim::result
