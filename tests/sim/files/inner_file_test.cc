#include "sim/files/inner_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

class InnerFile : public testing::Test {
 protected:
  InnerFile() {
    fs::create_directories(root_ / "below");
    write_text(root_ / "below/a.txt", "inside");
    write_text(folder_ / "secret.txt", "outside");
  }
  void expect_refused(const std::string& name) const {
    EXPECT_THAT([&] { inner_file(root_, name); },
                ThrowsMessage<FileError>(HasSubstr("leads out of the folder")))
        << name;
  }
  const TemporaryFolder folder_;
  const fs::path root_ = folder_ / "root";
};

TEST_F(InnerFile, NamesInTheFolderAreTaken) {
  EXPECT_EQ(inner_file(root_, "below/a.txt"), root_ / "below/a.txt");
  EXPECT_EQ(inner_file(root_, "not/there/yet"), root_ / "not/there/yet");
  EXPECT_EQ(inner_file(root_, "..a"), root_ / "..a") << "two dots that begin a name";
}

TEST_F(InnerFile, NamesThatLeadOutAreRefused) {
  for (const char* name :
       {"", "../secret.txt", "below/../../secret.txt", "below/..", "/etc/passwd", "//etc/passwd"})
    expect_refused(name);
  expect_refused(std::string("a\0b", 3));
}

TEST_F(InnerFile, LinksThatLeadOutAreRefusedAndOthersAreNot) {
  fs::create_symlink(folder_ / "secret.txt", root_ / "link.txt");
  fs::create_directory_symlink(folder_.path(), root_ / "up");
  fs::create_symlink("below/a.txt", root_ / "near.txt");
  fs::create_symlink("loop", root_ / "loop");
  expect_refused("link.txt");
  expect_refused("up/secret.txt");
  EXPECT_EQ(read_text(inner_file(root_, "near.txt")), "inside");
  EXPECT_THROW(inner_file(root_, "loop"), FileError);
}

// What is known of a folder holds for that folder alone, and not for what is in it.
TEST_F(InnerFile, LinksAreRefusedInListsWhoseFoldersAreKnown) {
  fs::create_directory_symlink(folder_.path(), root_ / "below/up");
  fs::create_symlink(folder_ / "secret.txt", root_ / "below/link.txt");
  InnerFiles files(root_);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(files.file("below/a.txt"), root_ / "below/a.txt");
    for (const char* name : {"below/link.txt", "below/up/secret.txt"})
      EXPECT_THAT([&] { files.file(name); }, ThrowsMessage<FileError>(HasSubstr("leads out of the folder")))
          << name;
  }
}

TEST_F(InnerFile, TheFolderItselfMayBeALink) {
  fs::create_directory_symlink(root_, folder_ / "alias");
  EXPECT_EQ(read_text(inner_file(folder_ / "alias", "below/a.txt")), "inside");
}

}  // namespace
}  // namespace sim::files
