#include "sim/files/text.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace sim::files {

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text;
  std::array<char, 1 << 16> part;
  while (in.read(part.data(), part.size()), in.gcount() > 0)
    text.append(part.data(), static_cast<std::size_t>(in.gcount()));
  if (!in.eof()) throw FileError(file, std::string("cannot be read: ") + std::strerror(errno));
  return text;
}

void write_text(const std::filesystem::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) throw FileError(file, std::string("cannot be written: ") + std::strerror(errno));
}

}  // namespace sim::files
