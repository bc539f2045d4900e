#include "sim/files/text.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <system_error>

namespace sim::files {
namespace {

constexpr std::size_t kPiece = 1 << 16;  // bytes

[[noreturn]] void fail_reading(const fs::path& file, int fault = errno) {
  fail_by_errno(file, "cannot be read", fault);
}

bool is_between(std::string_view character, std::string_view first, std::string_view last) {
  return character.size() == first.size() && character >= first && character <= last;
}

// The number of bytes of the first character; 0 if it is not UTF-8, including overlong forms and surrogates
// (RFC 3629).
std::size_t bytes_of_first(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const int bytes = first < 0x80 ? 1 : first >= 0xC2 && first < 0xF5 ? std::countl_one(first) : 0;
  const auto n = std::size_t(bytes);
  if (n == 0 || n > text.size()) return 0;
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
  const std::string_view two = text.substr(0, 2);
  const bool overlong = is_between(two, "\xE0\x80", "\xE0\x9F") || is_between(two, "\xF0\x80", "\xF0\x8F"),
             beyond = is_between(two, "\xED\xA0", "\xED\xBF") || is_between(two, "\xF4\x90", "\xF4\xBF");
  return !overlong && !beyond && std::ranges::all_of(text.substr(1, n - 1), continues) ? n : 0;
}

bool is_obeyed(std::string_view character) {
  if (character.size() == 1)
    return character != "\n" && character != "\t" && (character[0] < ' ' || character[0] == '\x7F');
  return is_between(character, "\xC2\x80", "\xC2\x9F") ||          // C1 controls
         is_between(character, "\xE2\x80\xAA", "\xE2\x80\xAE") ||  // U+202A to U+202E
         is_between(character, "\xE2\x81\xA6", "\xE2\x81\xA9") ||  // U+2066 to U+2069
         is_between(character, "\xEF\xBF\xBE", "\xEF\xBF\xBF");    // U+FFFE and U+FFFF, which XML forbids
}

/// True if a part of the name is a link or cannot be examined.
bool may_lead_elsewhere(fs::path at, const fs::path& name) {
  return std::ranges::any_of(name, [&](const fs::path& part) {
    std::error_code error;
    const fs::file_type type = fs::symlink_status(at /= part, error).type();
    return type == fs::file_type::symlink || type == fs::file_type::none;
  });
}

constexpr const char* kLeadsOut = "leads outside the folder";

constexpr std::size_t kGap = 2;

/// One column: the lines of its title, and its cells.
struct TableColumn {
  std::vector<std::string> title, cells;
  bool left = false;

  std::size_t width() const {
    std::size_t width = 0;
    for (const auto* lines : {&title, &cells})
      for (const std::string& line : *lines) width = std::max(width, line.size());
    return width;
  }

  /// Breaks the title after '_' and '.' into lines as wide as the cells; longer parts stay whole.
  void break_title() {
    constexpr std::size_t kLeast = 10;
    const std::string whole = std::exchange(title, {""})[0];
    std::size_t most = kLeast;
    for (const std::string& cell : cells) most = std::max(most, cell.size());
    for (std::size_t from = 0, to; from < whole.size(); from = to) {
      to = std::min(whole.find_first_of("_.", from), whole.size() - 1) + 1;
      if (!title.back().empty() && title.back().size() + to - from > most) title.emplace_back();
      title.back() += whole.substr(from, to - from);
    }
  }
};

using Columns = std::vector<TableColumn>;

std::size_t width_of(const Columns& columns) {
  std::size_t width = 0;
  for (const TableColumn& column : columns) width += column.width() + (width > 0 ? kGap : 0);
  return width;
}

std::string drawn(const Columns& columns) {
  std::size_t head = 0;
  for (const TableColumn& column : columns) head = std::max(head, column.title.size());
  std::string text;
  const auto add_line = [&](const auto& cell_of) {
    std::string line;
    for (const TableColumn& column : columns)
      line += std::string(line.empty() ? 0 : kGap, ' ') +
              (column.left ? fmt::format("{:<{}}", cell_of(column), column.width())
                           : fmt::format("{:>{}}", cell_of(column), column.width()));
    text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
  };
  for (std::size_t row = 0; row < head; ++row)  // titles are aligned with the first row of cells
    add_line([&](const TableColumn& column) {
      const std::size_t above = head - column.title.size();
      return row < above ? "" : column.title[row - above];
    });
  const std::vector<std::string>& first = columns[0].cells;
  for (std::size_t row = 0; row < first.size(); ++row) {
    if (row > 0 && first[row] != first[row - 1]) text += "\n";
    add_line([&](const TableColumn& column) { return column.cells[row]; });
  }
  return text;
}

}  // namespace

bool is_of_device(int fault) {
  return fault == ENOSPC || fault == EDQUOT || fault == EFBIG || fault == EIO || fault == ESTALE;
}

void fail_by_errno(const fs::path& file, const std::string& what, int fault) {
  const std::string why = what + ": " + std::strerror(fault);
  if (is_of_device(fault)) throw DeviceError(file, why);
  throw FileError(file, why);
}

std::string sanitize(const std::string& text) {
  std::string cleaned;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t n = bytes_of_first(rest);
    const std::string_view character = rest.substr(0, std::max<std::size_t>(n, 1));
    cleaned += n == 0 || is_obeyed(character) ? "?" : character;
    rest.remove_prefix(character.size());
  }
  return cleaned;
}

std::string one_line(const std::string& text) {
  std::string line = sanitize(text);
  for (char& c : line)
    if (c == '\n' || c == '\t') c = '?';
  return line;
}

std::string shell_word(const std::string& text) {
  static constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == text.npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

Descriptor::~Descriptor() {
  if (fd >= 0) ::close(fd);
}

InputFile::InputFile(const fs::path& file, std::uintmax_t most)
    : file_(file),
      in_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)),
      most_(most),
      piece_(std::make_unique_for_overwrite<char[]>(kPiece)) {
  const int fd = in_.fd;
  if (fd < 0 && errno == ENXIO) throw FileError(file, kNotRegular);  // a socket
  if (fd < 0) fail_reading(file);
  struct stat found {};
  if (::fstat(fd, &found) != 0) fail_reading(file);
  if (S_ISDIR(found.st_mode)) fail_reading(file, EISDIR);
  if (S_ISREG(found.st_mode))
    size_ = std::uintmax_t(found.st_size);
  else if (file == "/dev/stdin" || file.parent_path() == "/dev/fd" || file.parent_path() == "/proc/self/fd")
    ::fcntl(fd, F_SETFL, 0);  // reads wait for bytes
  else
    throw FileError(file, kNotRegular);
  if (size_ > most) throw FileError(file, "has {} bytes, expected at most {}", size_, most);
}

std::string_view InputFile::next() {
  ssize_t n;
  do n = ::read(in_.fd, piece_.get(), kPiece);
  while (n < 0 && errno == EINTR);
  if (n < 0) fail_reading(file_);
  const auto bytes = std::size_t(n);
  if ((read_ += bytes) > most_) throw FileError(file_, "has more than {} bytes", most_);
  return {piece_.get(), bytes};
}

std::string read_text(const fs::path& file, std::uintmax_t most) {
  InputFile in(file, most);
  std::string text;
  for (std::string_view piece; !(piece = in.next()).empty();) text += piece;
  return text;
}

void write_text(const fs::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), std::streamsize(text.size()));
  out.close();
  if (!out) fail_by_errno(file, "cannot be written");
}

void require_below(const fs::path& folder, std::string_view name) {
  const bool has_nul = name.find('\0') != name.npos, is_absolute = name.starts_with('/');
  if (name.empty() || is_absolute || has_nul || fmt::format("/{}/", name).find("/../") != std::string::npos)
    throw FileError(folder / std::string(name.substr(0, name.find('\0'))), kLeadsOut);
}

fs::path contained_path(const fs::path& folder, std::string_view name) {
  require_below(folder, name);
  const fs::path file = folder / name;
  if (!may_lead_elsewhere(folder, name)) return file;
  std::error_code no_root, no_file;
  const fs::path root = fs::canonical(folder, no_root), real = fs::weakly_canonical(file, no_file);
  if (no_root || no_file)
    throw FileError(file, "cannot be opened: " + (no_root ? no_root : no_file).message());
  if (std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first != root.end())
    throw FileError(file, kLeadsOut);
  return file;
}

std::string text_table(const std::vector<std::vector<std::string>>& rows, const TableShape& shape) {
  Columns all(rows.at(0).size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].left = i == 0;
    all[i].title = {one_line(rows[0][i])};
    for (std::size_t k = 1; k < rows.size(); ++k) all[i].cells.push_back(one_line(rows[k][i]));
  }
  if (width_of(all) > shape.width) std::ranges::for_each(all, &TableColumn::break_title);
  const auto values = all.begin() + std::ptrdiff_t(std::min(shape.naming, all.size()));
  Columns table(all.begin(), values);
  std::string text;
  for (auto column = values; column != all.end(); ++column) {
    table.push_back(*column);
    if (width_of(table) <= shape.width || table.size() == shape.naming + 1) continue;
    table.pop_back();
    text += drawn(table) + "\n";
    table.assign(all.begin(), values);
    table.push_back(*column);
  }
  return text + drawn(table);
}

std::optional<std::string> titled_lines(std::string_view text, std::string_view title) {
  const std::string begin = fmt::format("@@ {}\n", title);
  const std::size_t at = text.find(begin);
  if (at == text.npos) return std::nullopt;
  return std::string(text.substr(at + begin.size(), text.find("@@ ", at + 3) - at - begin.size()));
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace sim::files
