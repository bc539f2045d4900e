#include "sim/report/pictures.h"

#include <cmath>
#include <fstream>
#include <iterator>

#include "sim/stream/file_error.h"

namespace sim::report {
namespace {

constexpr int kPictures = 8;

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty()) throw stream::FileError(file, "cannot be read");
  return bytes;
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

nlohmann::ordered_json pictures(const RunData& run) {
  auto json = nlohmann::ordered_json::array();
  const auto camera = run.folder / "recording/mav0/cam0";
  if (!std::filesystem::exists(camera / "data.csv")) return json;
  const Table frames(camera / "data.csv");
  const auto t = frames.seconds("timestamp");
  const auto& names = frames.text("filename");
  for (int k = 0; k < kPictures && !t.empty(); ++k) {
    const std::size_t i = k * (t.size() - 1) / (kPictures - 1);
    json.push_back({{"t", std::round(10 * (t[i] - t[0])) / 10},
                    {"uri", "data:image/png;base64," + base64(bytes_of(camera / "data" / names[i]))}});
  }
  return json;
}

}  // namespace sim::report
