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

TEST(InputFile, IsGivenInPiecesAndMayBeMoved) {
  const TemporaryFolder folder;
  const std::string whole(200'000, 'x');
  write_text(folder / "a", whole);
  InputFile first(folder / "a");
  EXPECT_EQ(first.size(), whole.size());
  std::string read(first.next());
  InputFile second = std::move(first);
  for (std::string_view piece; !(piece = second.next()).empty();) read += piece;
  EXPECT_EQ(read, whole);
}

}  // namespace
}  // namespace sim::files
