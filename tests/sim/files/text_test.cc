#include "sim/files/text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Text, IsReadAsItWasWrittenByteForByte) {
  const TemporaryFolder folder;
  for (const std::string& text :
       {std::string(), std::string("a\r\n\0\xff b\n", 8), std::string(200'000, 'x')}) {
    write_text(folder / "a", text);
    EXPECT_EQ(read_text(folder / "a"), text);
  }
}

TEST(Text, ThatCannotBeReadOrWrittenIsNamedWithTheReason) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { read_text(folder / "none"); },
              ThrowsMessage<FileError>(HasSubstr("none: cannot be read: No such file or directory")));
  EXPECT_THAT([&] { read_text(folder.path()); },
              ThrowsMessage<FileError>(HasSubstr(": cannot be read: Is a directory")));
  EXPECT_THAT([&] { write_text(folder / "none/a", "x"); },
              ThrowsMessage<FileError>(HasSubstr("none/a: cannot be written: No such file or directory")));
  EXPECT_THAT([&] { write_text("/dev/full", "x"); },
              ThrowsMessage<FileError>(HasSubstr("/dev/full: cannot be written: No space left on device")));
}

}  // namespace
}  // namespace sim::files
