#include "sim/files/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace sim::files {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = 1 << 16;  // bytes

[[noreturn]] void fail(const fs::path& file, int fault) {
  throw FileError(file, std::string("cannot be read: ") + std::strerror(fault));
}

bool is_descriptor(const fs::path& file) {
  return file == "/dev/stdin" || file.parent_path() == "/dev/fd" || file.parent_path() == "/proc/self/fd";
}

}  // namespace

InputFile::Descriptor::~Descriptor() {
  if (fd >= 0) ::close(fd);
}

InputFile::InputFile(const fs::path& file, std::uintmax_t most)
    : file_(file),
      in_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)),
      most_(most),
      piece_(std::make_unique_for_overwrite<char[]>(kPiece)) {
  const int fd = in_.fd;
  if (fd < 0 && errno == ENXIO) throw FileError(file, kNotRegular);  // a socket
  if (fd < 0) fail(file, errno);
  struct stat found {};
  if (::fstat(fd, &found) != 0) fail(file, errno);
  if (S_ISDIR(found.st_mode)) fail(file, EISDIR);
  if (S_ISREG(found.st_mode))
    size_ = static_cast<std::uintmax_t>(found.st_size);
  else if (!is_descriptor(file))
    throw FileError(file, kNotRegular);
  else
    ::fcntl(fd, F_SETFL, 0);  // its bytes are waited for
  if (size_ > most) throw FileError(file, fmt::format("has {} bytes, expected at most {}", size_, most));
}

std::string_view InputFile::next() {
  ssize_t n;
  do n = ::read(in_.fd, piece_.get(), kPiece);
  while (n < 0 && errno == EINTR);
  if (n < 0) fail(file_, errno);
  const auto bytes = static_cast<std::size_t>(n);
  if ((read_ += bytes) > most_) throw FileError(file_, fmt::format("has more than {} bytes", most_));
  return {piece_.get(), bytes};
}

}  // namespace sim::files
