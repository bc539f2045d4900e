#include "sim/files/contained_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

class ContainedPath : public testing::Test {
 protected:
  ContainedPath() {
    fs::create_directories(root_ / "below");
    write_text(root_ / "below/a.txt", "inside");
    write_text(folder_ / "secret.txt", "outside");
  }
  void expect_rejected(const std::string& name) const {
    EXPECT_THAT([&] { contained_path(root_, name); },
                ThrowsMessage<FileError>(HasSubstr("leads out of the folder")))
        << name;
  }
  const TemporaryFolder folder_;
  const fs::path root_ = folder_ / "root";
};

TEST_F(ContainedPath, NamesInTheFolderAreAccepted) {
  EXPECT_EQ(contained_path(root_, "below/a.txt"), root_ / "below/a.txt");
  EXPECT_EQ(contained_path(root_, "not/there/yet"), root_ / "not/there/yet");
  EXPECT_EQ(contained_path(root_, "..a"), root_ / "..a") << "two dots in front of a name";
}

TEST_F(ContainedPath, NamesThatLeadOutAreRejected) {
  for (const char* name :
       {"", "../secret.txt", "below/../../secret.txt", "below/..", "/etc/passwd", "//etc/passwd"})
    expect_rejected(name);
  expect_rejected(std::string("a\0b", 3));
}

TEST_F(ContainedPath, OnlyLinksThatLeadOutAreRejected) {
  fs::create_symlink(folder_ / "secret.txt", root_ / "link.txt");
  fs::create_directory_symlink(folder_.path(), root_ / "up");
  fs::create_symlink("below/a.txt", root_ / "near.txt");
  fs::create_symlink("loop", root_ / "loop");
  fs::create_directory_symlink(folder_.path(), root_ / "below/up");
  expect_rejected("below/up/secret.txt");
  expect_rejected("link.txt");
  expect_rejected("up/secret.txt");
  EXPECT_EQ(read_text(contained_path(root_, "near.txt")), "inside");
  EXPECT_THROW(contained_path(root_, "loop"), FileError);
}

TEST_F(ContainedPath, TheFolderItselfMayBeALink) {
  fs::create_directory_symlink(root_, folder_ / "alias");
  EXPECT_EQ(read_text(contained_path(folder_ / "alias", "below/a.txt")), "inside");
}

}  // namespace
}  // namespace sim::files
