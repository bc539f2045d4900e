#include "sim/recording/grey_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>

namespace sim::recording {
namespace {

using Byte = unsigned char;

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::size_t kHeaderBytes = 13;
/// Bytes of a header after width and height: 8 bits, grey, deflate, adaptive filtering, not interlaced.
constexpr std::string_view kGrey8("\x08\0\0\0\0", 5);
constexpr Byte kUp = 2;
constexpr std::size_t kLargest = 1 << 14;  // width and height, pixels

std::size_t big_endian(std::string_view bytes) {
  std::size_t n = 0;
  for (int i = 0; i < 4; ++i) n = n << 8 | static_cast<Byte>(bytes[static_cast<std::size_t>(i)]);
  return n;
}

/// The necessary chunks of a PNG file.
struct Chunks {
  std::string_view header;
  std::string pixels;  ///< compressed
};

std::optional<Chunks> chunks_of(std::string_view png) {
  if (!png.starts_with(kSignature)) return std::nullopt;
  Chunks chunks;
  for (std::string_view rest = png.substr(kSignature.size()); rest.size() >= 12;) {
    const std::size_t n = big_endian(rest);
    if (n > rest.size() - 12) return std::nullopt;
    const std::string_view name = rest.substr(4, 4), data = rest.substr(8, n);
    if (name == "IHDR") chunks.header = data;
    if (name == "IDAT") chunks.pixels += data;
    if (name == "tRNS") return std::nullopt;  // one grey level means transparent
    if (name == "IEND") return chunks;
    rest.remove_prefix(n + 12);
  }
  return std::nullopt;
}

bool inflate(std::string_view compressed, std::string& out) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  return libdeflate_zlib_decompress(decompressor.get(), compressed.data(), compressed.size(), out.data(),
                                    out.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

int paeth(int left, int above, int corner) {
  const int from_left = std::abs(above - corner), from_above = std::abs(left - corner),
            from_corner = std::abs(left + above - 2 * corner);
  if (from_left <= from_above && from_left <= from_corner) return left;
  return from_above <= from_corner ? above : corner;
}

template <typename Predicted>
void add(const Byte* coded, const Byte* above, Byte* row, int n, const Predicted& predicted) {
  int left = 0, corner = 0;
  for (int i = 0; i < n; ++i) {
    row[i] = static_cast<Byte>(coded[i] + predicted(left, above[i], corner));
    left = row[i], corner = above[i];
  }
}

/// Reverses the filter of one row (ISO/IEC 15948, section 9). False for an unknown filter.
bool unfilter(Byte filter, const Byte* coded, const Byte* above, Byte* row, int n) {
  switch (filter) {
    case 0:
      return std::copy(coded, coded + n, row), true;
    case 1:
      return add(coded, above, row, n, [](int left, int, int) { return left; }), true;
    case kUp:
      for (int i = 0; i < n; ++i) row[i] = static_cast<Byte>(coded[i] + above[i]);
      return true;
    case 3:
      return add(coded, above, row, n, [](int left, int up, int) { return (left + up) / 2; }), true;
    case 4:
      return add(coded, above, row, n, paeth), true;
    default:
      return false;
  }
}

void append_big_endian(std::string& out, std::size_t n) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(n >> shift & 0xff);
}

void append_chunk(std::string& out, std::string_view name, std::string_view data) {
  append_big_endian(out, data.size());
  const std::size_t start = out.size();
  out.append(name).append(data);
  append_big_endian(out, libdeflate_crc32(0, out.data() + start, out.size() - start));
}

std::string deflate(const std::string& bytes) {
  constexpr int kFastest = 1;
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kFastest), &libdeflate_free_compressor);
  std::string out(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
  out.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(), out.data(), out.size()));
  return out;
}

// Each row as its difference from the one above.
std::string filtered_up(const cv::Mat& image) {
  std::string coded(static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.cols + 1), '\0');
  auto* to = reinterpret_cast<Byte*>(coded.data());
  const cv::Mat nothing = cv::Mat::zeros(1, image.cols, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    const Byte *row = image.ptr(v), *above = v > 0 ? image.ptr(v - 1) : nothing.ptr(0);
    *to++ = kUp;
    for (int i = 0; i < image.cols; ++i) *to++ = static_cast<Byte>(row[i] - above[i]);
  }
  return coded;
}

}  // namespace

std::string encode_grey_png(const cv::Mat& image) {
  CV_Assert(image.type() == CV_8UC1);
  std::string header, png(kSignature);
  append_big_endian(header, static_cast<std::size_t>(image.cols));
  append_big_endian(header, static_cast<std::size_t>(image.rows));
  append_chunk(png, "IHDR", header.append(kGrey8));
  append_chunk(png, "IDAT", deflate(filtered_up(image)));
  append_chunk(png, "IEND", "");
  return png;
}

std::optional<cv::Mat> decode_grey_png(std::string_view png) {
  const auto chunks = chunks_of(png);
  if (!chunks || chunks->header.size() != kHeaderBytes || !chunks->header.ends_with(kGrey8))
    return std::nullopt;
  const std::size_t width = big_endian(chunks->header), height = big_endian(chunks->header.substr(4));
  if (width == 0 || height == 0 || width > kLargest || height > kLargest) return std::nullopt;
  std::string coded(height * (width + 1), '\0');
  if (!inflate(chunks->pixels, coded)) return std::nullopt;
  cv::Mat image(static_cast<int>(height), static_cast<int>(width), CV_8UC1);
  const std::string nothing(width, '\0');
  const auto* from = reinterpret_cast<const Byte*>(coded.data());
  const auto* above = reinterpret_cast<const Byte*>(nothing.data());
  for (int v = 0; v < image.rows; ++v, from += width + 1) {
    if (!unfilter(from[0], from + 1, above, image.ptr(v), image.cols)) return std::nullopt;
    above = image.ptr(v);
  }
  return image;
}

}  // namespace sim::recording
