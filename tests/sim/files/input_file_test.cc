#include "sim/files/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <functional>
#include <utility>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/files/trajectory_file.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

void make_socket(const fs::path& file) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, file.c_str(), sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(fd);
}

// Opening a pipe that nobody writes would block without end.
TEST(InputFile, ThatIsNotRegularIsRefusedAtOnce) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  make_socket(folder / "socket");
  fs::create_symlink("pipe", folder / "link");
  fs::create_symlink("/dev/zero", folder / "device");
  for (const char* name : {"pipe", "socket", "link", "device"}) {
    const fs::path file = folder / name;
    const std::function<void()> readers[] = {
        [&] { read_text(file); }, [&] { read_json(file); }, [&] { CsvReader rows(file); },
        [&] { CsvReader rows(file, {"a,b"}); }, [&] { read_trajectory(file); }};
    for (const auto& read : readers)
      EXPECT_THAT(read, ThrowsMessage<FileError>(
                            HasSubstr(std::string(name) + ": is not a regular file, expected one")));
  }
}

TEST(InputFile, ByALinkIsRead) {
  const TemporaryFolder folder;
  write_text(folder / "a", "content");
  fs::create_symlink("a", folder / "link");
  EXPECT_EQ(read_text(folder / "link"), "content");
}

// What a shell passes for <(...).
TEST(InputFile, MayBeAPipeOfThisProcess) {
  int ends[2] = {};
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "a,b\n1,2\n", 8), 8);
  ::close(ends[1]);
  EXPECT_EQ(read_text("/dev/fd/" + std::to_string(ends[0])), "a,b\n1,2\n");
  ::close(ends[0]);
}

// Sparse files, which take no room on the disk.
TEST(InputFile, ThatIsTooLargeIsRefusedBeforeItIsRead) {
  const TemporaryFolder folder;
  const auto sparse = [&](const std::string& name, std::uintmax_t bytes) {
    write_text(folder / name, "");
    fs::resize_file(folder / name, bytes);
    return folder / name;
  };
  const fs::path large = sparse("large", 3221225473);
  EXPECT_THAT(
      [&] { read_text(large); },
      ThrowsMessage<FileError>(HasSubstr("large: has 3221225473 bytes, expected at most 2147483648")));
  EXPECT_THAT([&] { read_text(large, 100); },
              ThrowsMessage<FileError>(HasSubstr("large: has 3221225473 bytes, expected at most 100")));
  EXPECT_THAT([&] { read_json(large); }, ThrowsMessage<FileError>(HasSubstr("expected at most 67108864")));
  const fs::path largest = sparse("largest", std::uintmax_t{1} << 40);
  EXPECT_THAT([&] { CsvReader rows(largest); },
              ThrowsMessage<FileError>(HasSubstr("has 1099511627776 bytes, expected at most 17179869184")));
  EXPECT_THAT([&] { CsvReader rows(large); },
              ThrowsMessage<FileError>(HasSubstr("large:1: has more than 1048576 characters")));
  write_text(folder / "quoted", "a,b\n\"" + std::string((1 << 20) + 1, '\n'));
  EXPECT_THAT(
      [&] {
        CsvReader rows(folder / "quoted");
        rows.next();
      },
      ThrowsMessage<FileError>(HasSubstr("quoted:2: has more than 1048576 characters")));
}

TEST(InputFile, OfAPipeIsReadUpToTheLimitOnly) {
  int ends[2] = {};
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "0123456789", 10), 10);
  ::close(ends[1]);
  EXPECT_THAT([&] { read_text("/dev/fd/" + std::to_string(ends[0]), 9); },
              ThrowsMessage<FileError>(HasSubstr(": has more than 9 bytes")));
  ::close(ends[0]);
}

TEST(InputFile, IsGivenInPiecesAndMayBeMoved) {
  const TemporaryFolder folder;
  const std::string whole(200'000, 'x');
  write_text(folder / "a", whole);
  InputFile first(folder / "a", whole.size());
  EXPECT_EQ(first.size(), whole.size());
  std::string read(first.next());
  InputFile second = std::move(first);
  for (std::string_view piece; !(piece = second.next()).empty();) read += piece;
  EXPECT_EQ(read, whole);
}

}  // namespace
}  // namespace sim::files
