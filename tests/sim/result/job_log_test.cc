#include "sim/result/job_log.h"

#include "tests/sim/files/temporary_folder.h"

namespace sim::result {
namespace {

JobRecord record(int i) {
  return {"key-" + std::to_string(i), static_cast<std::uint64_t>(i), "completed", "", {{"rmse_m", 0.1 * i}}};
}

TEST(JobLog, ARecordIsReadBackBitForBit) {
  JobRecord odd{"k", 18446744073709551615u, "diverged", "lost at 3 s: \"dark\"\nand so on", {}};
  odd.values = {{"third", 1.0 / 3},
                {"tiny", std::numeric_limits<double>::denorm_min()},
                {"most", std::numeric_limits<double>::max()},
                {"minus_zero", -0.0}};
  const auto back = from_line(to_line(odd));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, odd);
  EXPECT_TRUE(std::signbit(back->values.at("minus_zero")));
  EXPECT_EQ(to_line(odd).find('\n'), std::string::npos);
}

TEST(JobLog, KeysShowWhereEachPartEnds) {
  EXPECT_NE(job_key({"ab", "c"}), job_key({"a", "bc"}));
  EXPECT_NE(job_key({"a", ""}), job_key({"a"}));
  EXPECT_EQ(job_key({"a", "b"}), job_key({"a", "b"}));
}

TEST(JobLog, WhereverItIsCutOffCompleteLinesAreKeptAndTheRestIsWrittenAgain) {
  const files::TemporaryFolder folder;
  const auto file = folder / "trials.jsonl";
  {
    JobLog log(file, "a sweep");
    for (int i = 0; i < 3; ++i) log.add(record(i));
    log.add({"key-1", 1, "fell", "twice", {}});
  }
  EXPECT_EQ(*JobLog(file, "a sweep").find("key-1"), record(1));
  const std::string whole = files::read_text(file);
  files::write_text(file, whole + std::string(40, '\0') + "\n");  // as a power failure leaves it
  EXPECT_EQ(JobLog(file, "a sweep").size(), 3u);
  EXPECT_EQ(files::read_text(file), whole);
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    files::write_text(file, whole.substr(0, bytes));
    {
      JobLog log(file, "a sweep");
      for (int i = 0; i < 3; ++i) log.add(record(i));
    }
    EXPECT_EQ(files::read_text(file), whole) << "cut after " << bytes << " bytes";
  }
}

TEST(JobLog, ADamagedLineAWrongPurposeAndAnotherWriterAreErrors) {
  const files::TemporaryFolder folder;
  const auto file = folder / "trials.jsonl";
  const auto expect_error = [&](const char* purpose, const char* why) {
    EXPECT_THAT(files::error_of([&] { JobLog(file, purpose); }), testing::HasSubstr(why));
  };
  {
    JobLog log(file, "a sweep");
    for (int i = 0; i < 3; ++i) log.add(record(i));
    expect_error("a sweep", "another process");
  }
  expect_error("another sweep", "another sweep");
  std::string text = files::read_text(file);
  text[text.find("key-0") - 3] = '#';
  files::write_text(file, text);
  expect_error("a sweep", "line 2");
  EXPECT_EQ(files::read_text(file), text) << "an unreadable log is not changed";
}

TEST(JobLog, TheSortedLogDoesNotDependOnOrderOrThreadsOfItsTrials) {
  const files::TemporaryFolder folder;
  const auto text = [&](const std::string& name, int of_the_other) {
    {
      JobLog log(folder / name, "a sweep");
      std::thread other([&] {
        for (int i = 100; i-- > 100 - of_the_other;) log.add(record(i));
      });
      for (int i = 0; i < 100 - of_the_other; ++i) log.add(record(i));
      other.join();
      EXPECT_EQ(read_job_log(folder / name, "a sweep").size(), 100u) << "what is added is in the file";
      log.sort();
    }
    EXPECT_EQ(JobLog(folder / name, "a sweep").size(), 100u);
    return files::read_text(folder / name);
  };
  EXPECT_EQ(text("a", 0), text("b", 50));
}

}  // namespace
}  // namespace sim::result
