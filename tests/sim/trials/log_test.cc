#include "sim/trials/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::trials {
namespace {

using files::FileError;
using files::TemporaryFolder;
using testing::HasSubstr;

TrialRecord record(int i) {
  return {"key-" + std::to_string(i), static_cast<std::uint64_t>(i), "completed", "", {{"rmse_m", 0.1 * i}}};
}

std::string open_error(const std::filesystem::path& file, const std::string& purpose) {
  try {
    TrialLog log(file, purpose);
  } catch (const FileError& e) {
    return e.what();
  }
  return "";
}

TEST(TrialLog, ARecordComesBackWithTheSameBits) {
  TrialRecord odd{"k", 18446744073709551615u, "diverged", "lost at 3 s: \"dark\"\nand so on", {}};
  odd.values = {{"third", 1.0 / 3},
                {"tiny", std::numeric_limits<double>::denorm_min()},
                {"most", std::numeric_limits<double>::max()},
                {"minus_zero", -0.0},
                {"none", std::numeric_limits<double>::infinity()}};
  const auto back = from_line(to_line(odd));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, odd);
  EXPECT_TRUE(std::signbit(back->values.at("minus_zero")));
  EXPECT_EQ(to_line(odd).find('\n'), std::string::npos);
  odd.values = {{"no_number", std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_TRUE(std::isnan(from_line(to_line(odd))->values.at("no_number")));
}

TEST(TrialLog, KeysTellWhereOnePartEnds) {
  EXPECT_NE(trial_key({"ab", "c"}), trial_key({"a", "bc"}));
  EXPECT_NE(trial_key({"a", ""}), trial_key({"a"}));
  EXPECT_EQ(trial_key({"a", "b"}), trial_key({"a", "b"}));
}

TEST(TrialLog, WhereverItIsCutOffWholeLinesAreKeptAndTheRestIsWrittenAgain) {
  const TemporaryFolder folder;
  const auto file = folder / "trials.jsonl";
  {
    TrialLog log(file, "a sweep");
    for (int i = 0; i < 3; ++i) log.add(record(i));
    log.add({"key-1", 1, "fell", "twice", {}});
  }
  EXPECT_EQ(*TrialLog(file, "a sweep").find("key-1"), record(1));
  const std::string whole = files::read_text(file);
  files::write_text(file, whole + std::string(40, '\0') + "\n");  // as a power failure leaves it
  EXPECT_EQ(TrialLog(file, "a sweep").size(), 3u);
  EXPECT_EQ(files::read_text(file), whole);
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    files::write_text(file, whole.substr(0, bytes));
    {
      TrialLog log(file, "a sweep");
      for (int i = 0; i < 3; ++i) log.add(record(i));
    }
    EXPECT_EQ(files::read_text(file), whole) << "cut after " << bytes << " bytes";
  }
}

TEST(TrialLog, ADamagedLineAnotherPurposeAndAnotherWriterAreErrors) {
  const TemporaryFolder folder;
  const auto file = folder / "trials.jsonl";
  {
    TrialLog log(file, "a sweep");
    for (int i = 0; i < 3; ++i) log.add(record(i));
    EXPECT_THAT(open_error(file, "a sweep"), HasSubstr("another process"));
  }
  EXPECT_THAT(open_error(file, "another sweep"), HasSubstr("another sweep"));
  std::string text = files::read_text(file);
  text[text.find("key-0") - 3] = '#';
  files::write_text(file, text);
  EXPECT_THAT(open_error(file, "a sweep"), HasSubstr("line 2"));
  EXPECT_EQ(files::read_text(file), text) << "an unreadable log is not changed";
}

TEST(TrialLog, SortedItIsTheSameWhateverTheOrderAndTheThreadsOfItsTrials) {
  const TemporaryFolder folder;
  const auto text = [&](const std::string& name, int of_the_other) {
    {
      TrialLog log(folder / name, "a sweep");
      std::thread other([&] {
        for (int i = 100; i-- > 100 - of_the_other;) log.add(record(i));
      });
      for (int i = 0; i < 100 - of_the_other; ++i) log.add(record(i));
      other.join();
      EXPECT_EQ(read_trial_log(folder / name, "a sweep").size(), 100u);
      log.sort();
    }
    EXPECT_EQ(TrialLog(folder / name, "a sweep").size(), 100u);
    return files::read_text(folder / name);
  };
  EXPECT_EQ(text("a", 0), text("b", 50));
}

/// Writes one byte into the pipe for each finished record, until it is killed.
[[noreturn]] void write_until_killed(const std::filesystem::path& file, int pipe_end) {
  TrialLog log(file, "a sweep");
  for (int i = static_cast<int>(log.size());; ++i) {
    log.add(record(i));
    if (::write(pipe_end, "x", 1) != 1) _exit(1);
  }
}

TEST(TrialLog, KilledAtAnyMomentItLosesNoFinishedTrial) {
  const TemporaryFolder folder;
  std::mt19937 random(1);
  std::size_t finished = 0;
  for (int life = 0; life < 30; ++life) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t writer = fork();
    if (writer == 0) write_until_killed(folder / "trials.jsonl", ends[1]);
    ::close(ends[1]);
    char byte = 0;
    ASSERT_EQ(::read(ends[0], &byte, 1), 1);
    ::usleep(random() % 3000);
    ::kill(writer, SIGKILL);
    for (++finished; ::read(ends[0], &byte, 1) == 1;) ++finished;
    ::waitpid(writer, nullptr, 0);
    ::close(ends[0]);
    const TrialLog log(folder / "trials.jsonl", "a sweep");
    ASSERT_GE(log.size(), finished);
    ASSERT_LE(log.size(), finished + 1) << "the one that was on its way";
    finished = log.size();
    for (std::size_t i = 0; i < finished; ++i) ASSERT_NE(log.find(record(static_cast<int>(i)).key), nullptr);
  }
}

}  // namespace
}  // namespace sim::trials
