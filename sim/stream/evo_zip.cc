#include "sim/stream/evo_zip.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>

#include "sim/stream/durable_file.h"

namespace sim::stream {
namespace {

// CRC-32 of ISO 3309, bit by bit.
std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320 : 0);
  }
  return ~crc;
}

// Little-endian, `size` bytes.
std::string little(std::uint64_t value, int size) {
  std::string bytes;
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFF);
  return bytes;
}

// A ZIP archive whose files are stored as they are (APPNOTE 6.3, sections 4.3.7, 4.3.12 and 4.3.16).
class Zip {
 public:
  void add(const std::string& name, const std::string& content) {
    constexpr int kVersion = 20, kFirstOf1980 = 0x21;
    const std::string common = little(kVersion, 2) + little(0, 6) + little(kFirstOf1980, 2) +
                               little(crc32(content), 4) + little(content.size(), 4) +
                               little(content.size(), 4) + little(name.size(), 2) + little(0, 2);
    directory_ +=
        "PK\x01\x02" + little(kVersion, 2) + common + little(0, 10) + little(files_.size(), 4) + name;
    files_ += "PK\x03\x04" + common + name + content;
    ++count_;
  }
  std::string bytes() const {
    return files_ + directory_ + "PK\x05\x06" + little(0, 4) + little(count_, 2) + little(count_, 2) +
           little(directory_.size(), 4) + little(files_.size(), 4) + little(0, 2);
  }

 private:
  std::string files_, directory_;
  std::uint64_t count_ = 0;
};

// NumPy's format 1.0: doubles, rows first.
std::string npy(const double* values, std::size_t count, const std::string& shape) {
  std::string header = fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape);
  header += std::string(63 - (10 + header.size()) % 64, ' ') + "\n";
  std::string bytes(count * sizeof(double), '\0');
  if (count > 0) std::memcpy(bytes.data(), values, bytes.size());
  return std::string("\x93NUMPY\x01\x00", 8) + little(header.size(), 2) + header + bytes;
}

std::string npy(const std::vector<double>& values) {
  return npy(values.data(), values.size(), fmt::format("{},", values.size()));
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? "\\n" : std::string(1, c);
  }
  return out + "\"";
}

}  // namespace

void write_evo_zip(const std::filesystem::path& file, const EvoResult& r) {
  Zip zip;
  zip.add("info.json",
          fmt::format("{{\"title\": {}, \"ref_name\": {}, \"est_name\": {}, \"label\": {}}}", quoted(r.title),
                      quoted(r.reference), quoted(r.estimate), quoted(r.label)));
  std::string statistics;
  for (const auto& [name, value] : r.statistics)
    statistics += fmt::format("{}\"{}\": {}", statistics.empty() ? "" : ", ", name, value);
  zip.add("stats.json", "{" + statistics + "}");
  zip.add("error_array.npy", npy(r.error));
  zip.add("timestamps.npy", npy(r.timestamps));
  zip.add("seconds_from_start.npy", npy(r.seconds_from_start));
  zip.add("distances_from_start.npy", npy(r.distances_from_start));
  zip.add("distances.npy", npy(r.distances));
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = r.matrix;
  zip.add("alignment_transformation_sim3.npy", npy(rows.data(), 16, "4, 4"));
  write_durably(file, zip.bytes());
}

}  // namespace sim::stream
