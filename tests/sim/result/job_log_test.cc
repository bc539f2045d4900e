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
    log.add({record(0), record(1)});
    log.add({{"key-1", 1, "fell", "twice", {}}, record(2)});
  }
  EXPECT_EQ(*JobLog(file, "a sweep").find("key-1"), record(1));
  const std::string whole = files::read_text(file);
  const auto continued = [&](const std::string& left) {
    files::write_text(file, left);
    JobLog log(file, "a sweep");
    log.add({record(0), record(1), record(2)});
    return files::read_text(file);
  };
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_EQ(continued(whole.substr(0, bytes)), whole) << "cut after " << bytes << " bytes";
  for (const char* key : {"key-0", "key-2"}) {  // as left by a power failure
    std::string torn = whole;
    torn.replace(torn.find(key), 5, 5, '\0');
    EXPECT_EQ(continued(torn), whole) << key;
  }
  EXPECT_THAT(files::error_of([&] { JobLog(file, "another sweep"); }),
              testing::HasSubstr("is another log: a sweep, expected another sweep"));
}

}  // namespace
}  // namespace sim::result
