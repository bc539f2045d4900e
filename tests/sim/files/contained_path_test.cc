#include "sim/files/contained_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;

TEST(ContainedPath, NamesAndLinksThatLeadOutAreRejected) {
  const TemporaryFolder folder;
  const fs::path root = folder / "root";
  fs::create_directories(root / "below");
  write_text(root / "below/a.txt", "inside");
  write_text(folder / "secret.txt", "outside");
  fs::create_symlink(folder / "secret.txt", root / "link.txt");
  fs::create_directory_symlink(folder.path(), root / "up");
  fs::create_directory_symlink(folder.path(), root / "below/up");
  fs::create_symlink("below/a.txt", root / "near.txt");
  fs::create_symlink("loop", root / "loop");
  fs::create_directory_symlink(root, folder / "alias");

  EXPECT_EQ(contained_path(root, "not/there/yet"), root / "not/there/yet");
  EXPECT_EQ(contained_path(root, "..a"), root / "..a") << "two dots in front of a name";
  EXPECT_EQ(read_text(contained_path(root, "near.txt")), "inside");
  EXPECT_EQ(read_text(contained_path(folder / "alias", "below/a.txt")), "inside") << "itself a link";
  for (const std::string& name :
       {std::string(), std::string("../secret.txt"), std::string("below/../../secret.txt"),
        std::string("below/.."), std::string("/etc/passwd"), std::string("//etc/passwd"),
        std::string("a\0b", 3), std::string("below/up/secret.txt"), std::string("link.txt"),
        std::string("up/secret.txt")})
    EXPECT_THAT(error_of([&] { contained_path(root, name); }), testing::HasSubstr("leads out of the folder"))
        << name;
  EXPECT_THROW(contained_path(root, "loop"), FileError);
}

}  // namespace
}  // namespace sim::files
