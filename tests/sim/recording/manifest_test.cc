#include "sim/recording/manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::recording {
namespace {

using testing::HasSubstr;

TEST(Manifest, HashIsXxh3Of128Bits) {
  // As published with the algorithm: the empty input, seed 0; and as `printf gaitslam | xxh128sum` prints.
  EXPECT_EQ(files::Hash().hex(), "99aa06d3014798d86001c324468d497f");
  files::Hash whole, pieces;
  whole.add("gaitslam");
  for (const char* piece : {"ga", "", "it", "slam"}) pieces.add(piece);
  EXPECT_EQ(pieces.hex(), whole.hex());
  EXPECT_EQ(pieces.bytes(), 8u);
}

TEST(Manifest, ReadsOnlyWhatItLists) {
  const files::TemporaryFolder folder;
  files::HashedFile file(folder / "a.txt");
  file.write("content");
  file.close();
  ManifestWriter writer(folder.path());
  writer.add("a.txt", file.hash());
  writer.finish();
  const Manifest manifest(folder.path());
  EXPECT_EQ(manifest.read("a.txt"), "content");
  EXPECT_THAT(files::error_of([&] { manifest.read("../a.txt"); }), HasSubstr("does not list ../a.txt"));
}

TEST(Manifest, FilesOutsideTheFolderAreRejected) {
  const files::TemporaryFolder folder;
  const std::filesystem::path recording = folder / "recording";
  std::filesystem::create_directories(recording);
  files::write_text(folder / "outside.txt", "content");
  std::filesystem::create_symlink(folder / "outside.txt", recording / "link.txt");
  files::Hash hash;
  hash.add("content");
  for (const std::string& path :
       {std::string("../outside.txt"), (folder / "outside.txt").string(), std::string("link.txt")}) {
    ManifestWriter writer(recording);
    writer.add(path, hash);
    writer.finish();
    EXPECT_THAT(files::error_of([&] { Manifest manifest(recording); }), HasSubstr("leads out of the folder"))
        << path;
  }
}

TEST(HashedFile, AFullDiskIsAnError) {
  files::HashedFile full("/dev/full");
  EXPECT_THAT(files::error_of([&] {
                full.write("x");
                full.close();
              }),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
}

}  // namespace
}  // namespace sim::recording
