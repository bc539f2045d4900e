#include "sim/recording/cache.h"

#include "sim/recording/manifest.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::recording {
namespace {

using testing::HasSubstr, testing::IsEmpty;

constexpr std::size_t kFrameBytes = 100'000;

std::string key(char letter) { return std::string(32, letter); }

/// The parts of a walk's result folder that the cache reads.
void make_result(const fs::path& result) {
  fs::create_directories(result / "recording");
  ManifestWriter manifest(result / "recording");
  files::HashedFile frame(result / "recording/frame.png");
  frame.write(std::string(kFrameBytes, 'x'));
  frame.close();
  manifest.add("frame.png", frame.hash());
  manifest.finish();
  std::ofstream(result / "about.json") << R"({"scenario": "walk", "seed": 7})";
}

class CacheTest : public testing::Test {
 protected:
  static constexpr std::uintmax_t kRoomForTwo = 5 * kFrameBytes / 2;

  CachedRecording get(char letter) {
    return cache_.get(
        key(letter), [this](const fs::path& p) { ++made_, make_result(p); }, say());
  }
  Cache::Say say() {
    return [this](const std::string& text) { said_.push_back(text); };
  }
  bool has(char letter) const { return fs::exists(cache_.place().folder / key(letter)); }

  files::TemporaryFolder folder_;
  Cache cache_{{folder_ / "cache", kRoomForTwo}};
  int made_ = 0;
  std::vector<std::string> said_;
};

TEST_F(CacheTest, ARecordingIsMadeOnceAndOneThatFailsLeavesNothing) {
  const auto half = [](const fs::path& result) {
    fs::create_directories(result / "recording");
    throw std::runtime_error("no such robot");
  };
  EXPECT_THROW(cache_.get(key('a'), half, say()), std::runtime_error);
  EXPECT_FALSE(has('a'));
  EXPECT_TRUE(get('a').made);
  const CachedRecording again = get('a');
  EXPECT_FALSE(again.made);
  EXPECT_EQ(made_, 1);
  EXPECT_TRUE(fs::exists(again.folder / "recording/frame.png"));
  EXPECT_FALSE(cache_.find(key('b'), say()));
  EXPECT_THAT(said_, IsEmpty());
}

// Removes or restores the permission to write the folder and its contents.
void permit_writing(const fs::path& folder, bool allowed) {
  const auto how = allowed ? fs::perm_options::add : fs::perm_options::remove;
  const auto writing = allowed ? fs::perms::owner_write
                               : fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  fs::permissions(folder, writing, how);
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    fs::permissions(entry.path(), writing, how);
}

TEST_F(CacheTest, AnUnwritableCacheServesWhatItHas) {
  get('a');
  std::optional<CachedRecording> reader;
  {
    permit_writing(cache_.place().folder, false);
    const files::AsUser user;
    reader = get('a');
    EXPECT_FALSE(reader->made);
    EXPECT_TRUE(cache_.find(key('a'), say()));
    ASSERT_EQ(cache_.list().size(), 1u);
    EXPECT_THAT(files::error_of([&] { get('b'); }),
                HasSubstr("cache: lacks an intact copy of this recording, and cannot store one: Permission "
                          "denied; set GAITSLAM_CACHE to another folder"));
  }
  permit_writing(cache_.place().folder, true);
  EXPECT_EQ(made_, 1);
  EXPECT_THAT(said_, IsEmpty());
  EXPECT_EQ(cache_.clean(0).kept, 1u) << "the reader's lock counts";
  EXPECT_TRUE(has('a'));
}

TEST_F(CacheTest, ADamagedRecordingIsReportedAndMadeAgain) {
  const fs::path frame = get('a').folder / "recording/frame.png";
  std::fstream(frame, std::ios::in | std::ios::out | std::ios::binary) << 'y';
  EXPECT_FALSE(cache_.find(key('a'), say()));
  ASSERT_EQ(said_.size(), 1u);
  EXPECT_THAT(said_[0], HasSubstr(frame.string() + ": edited"));
  EXPECT_TRUE(get('a').made);
  EXPECT_EQ(said_.size(), 2u) << "reported again when it is made again";
  const CachedRecording made = get('a');
  EXPECT_FALSE(made.made);

  std::ofstream(made.folder / "recording/frame.png") << "z";
  files::Hash hash;
  hash.add("z");
  ManifestWriter manifest(made.folder / "recording");
  manifest.add("frame.png", hash);
  manifest.finish();
  EXPECT_FALSE(cache_.find(key('a'), say()));
  EXPECT_THAT(said_.back(), HasSubstr("contains a recording other than the stored one"));
}

TEST_F(CacheTest, TheLeastRecentlyUsedRecordingIsRemovedFirst) {
  const auto use = [this](char letter) {
    get(letter);
    ::usleep(20000);  // more than the resolution of the file system's clock
  };
  use('a'), use('b'), use('a');
  const auto two = cache_.list();
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[1].key, key('a'));
  EXPECT_GT(two[1].bytes, kFrameBytes);
  use('c');
  EXPECT_TRUE(has('a') && !has('b') && has('c'));
}

TEST_F(CacheTest, SeveralProcessesCleanItAtTheSameTime) {
  const Cache roomy{{folder_ / "cache", 1'000'000'000}};
  for (const char letter : std::string("0123456789abcdef")) roomy.get(key(letter), make_result, say());
  std::vector<std::future<Cache::Cleaned>> cleanings;
  for (int i = 0; i < 4; ++i)
    cleanings.push_back(std::async(std::launch::async, [&] { return roomy.clean(0); }));
  std::size_t removed = 0;
  for (auto& cleaning : cleanings) EXPECT_NO_THROW(removed += std::size_t(cleaning.get().removed));
  EXPECT_EQ(removed, 16u);
  EXPECT_THAT(roomy.list(), IsEmpty());
}

TEST_F(CacheTest, ARecordingInUseIsNeverRemoved) {
  const CachedRecording used = get('a');
  get('b'), get('c');
  EXPECT_TRUE(has('a')) << "though it was used longest ago";
  const Cache::Cleaned cleaned = cache_.clean(0);
  EXPECT_EQ(cleaned.kept, 1u);
  EXPECT_TRUE(has('a') && !has('b') && !has('c'));
  EXPECT_EQ(cleaned.removed, 2u);
  EXPECT_GT(cleaned.bytes, 2 * kFrameBytes);
}

TEST_F(CacheTest, FoldersWithoutTheCachesMarkerAreLeftAlone) {
  get('a'), get('b');
  const fs::path others = cache_.place().folder / key('c');
  fs::create_directory(others);
  std::ofstream(others / "thesis.tex") << "mine";
  EXPECT_EQ(cache_.list().size(), 2u);
  files::mark_folder(cache_.place().folder / ".x.partial");  // left by a killed process
  EXPECT_EQ(cache_.clean(0).removed, 2u);
  EXPECT_FALSE(has('a') || fs::exists(cache_.place().folder / ".x.partial"));
  EXPECT_TRUE(fs::exists(others / "thesis.tex"));
  EXPECT_THROW(get('c'), files::FileError);
}

TEST_F(CacheTest, OnlyOneOfThoseThatNeedARecordingAtTheSameTimeMakesIt) {
  const auto slowly = [this](const fs::path& result) {
    std::ofstream(folder_ / "made", std::ios::app) << 'x';
    ::usleep(200000);
    make_result(result);
  };
  std::vector<std::future<bool>> all;
  for (int i = 0; i < 3; ++i)
    all.push_back(std::async(std::launch::async, [&] {
      return fs::exists(cache_.get(key('a'), slowly, say()).folder);  // and not used any longer
    }));
  for (auto& one : all) EXPECT_TRUE(one.get());
  EXPECT_EQ(fs::file_size(folder_ / "made"), 1u);
}

TEST(CachePlace, FollowsTheEnvironment) {
  for (const auto& [name, value, folder] :
       {std::tuple("XDG_CACHE_HOME", "/caches", "/caches/gaitslam"), {"GAITSLAM_CACHE", "/mine", "/mine"}}) {
    ::setenv(name, value, 1);
    EXPECT_EQ(cache_place().folder, folder);
  }
  EXPECT_EQ(cache_place().most_bytes, 20'000'000'000u);
  ::setenv("GAITSLAM_CACHE_GB", "0.5", 1);
  EXPECT_EQ(cache_place().most_bytes, 500'000'000u);
  for (const char* bad : {"much", "-1", "1GB", "nan"}) {
    ::setenv("GAITSLAM_CACHE_GB", bad, 1);
    EXPECT_THROW(cache_place(), std::invalid_argument) << bad;
  }
  for (const char* name : {"GAITSLAM_CACHE", "XDG_CACHE_HOME", "GAITSLAM_CACHE_GB"}) ::unsetenv(name);
  EXPECT_TRUE(cache_place().folder.string().ends_with("/.cache/gaitslam"));
}

}  // namespace
}  // namespace sim::recording
