#include "sim/files/text.h"

#include <cerrno>
#include <cstring>
#include <fstream>

namespace sim::files {

std::string read_text(const std::filesystem::path& file, std::uintmax_t most) {
  InputFile in(file, most);
  std::string text;
  for (std::string_view piece; !(piece = in.next()).empty();) text += piece;
  return text;
}

void write_text(const std::filesystem::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) throw FileError(file, std::string("cannot be written: ") + std::strerror(errno));
}

}  // namespace sim::files
