#include "sim/recording/image_file.h"

#include <dlfcn.h>
#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <opencv2/imgcodecs.hpp>

namespace sim::recording {
namespace {

using std::string_view_literals::operator""sv;
using Byte = unsigned char;

constexpr std::string_view kJpeg = "\xff\xd8", kJpegEnd = "\xff\xd9";
constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
/// The bytes of a header after width and height: bits, color type, deflate, adaptive filtering, not
/// interlaced. Empty for image types that are not encoded.
std::string_view png_format(int type) {
  if (type == CV_8UC1) return "\x08\0\0\0\0"sv;
  if (type == CV_8UC3) return "\x08\x02\0\0\0"sv;
  return type == CV_16UC1 ? "\x10\0\0\0\0"sv : "";
}
/// Two-byte samples are swapped between the machine's byte order and PNG's, which has the most significant
/// byte first.
constexpr int swapped(int type) {
  return CV_MAT_DEPTH(type) == CV_16U && std::endian::native == std::endian::little ? 1 : 0;
}
/// The last chunk, with its length and checksum.
constexpr std::string_view kEnd("\0\0\0\0IEND\xae\x42\x60\x82", 12);
/// The filter of each row (ISO/IEC 15948, section 9): its difference from the row above.
constexpr Byte kUp = 2;
constexpr std::size_t kLargest = 1 << 14;  // width and height, pixels

std::size_t big_endian(std::string_view bytes) {
  std::size_t n = 0;
  for (const char c : bytes.substr(0, 4)) n = n << 8 | static_cast<Byte>(c);
  return n;
}

void append_big_endian(std::string& out, std::size_t n) {
  for (int shift = 24; shift >= 0; shift -= 8) out += char(n >> shift & 0xff);
}

void append_chunk(std::string& out, std::string_view name, std::string_view data) {
  append_big_endian(out, data.size());
  const std::size_t start = out.size();
  out.append(name).append(data);
  append_big_endian(out, libdeflate_crc32(0, out.data() + start, out.size() - start));
}

std::string compressed(const cv::Mat& image) {
  const int width = image.cols * int(image.elemSize()), swap = swapped(image.type());  // bytes
  std::string coded(std::size_t(image.rows) * std::size_t(width + 1), '\0');
  auto* to = reinterpret_cast<Byte*>(coded.data());
  const cv::Mat nothing = cv::Mat::zeros(1, width, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    const Byte *row = image.ptr(v), *above = v > 0 ? image.ptr(v - 1) : nothing.ptr(0);
    *to++ = kUp;
    for (int i = 0; i < width; ++i) *to++ = static_cast<Byte>(row[i ^ swap] - above[i ^ swap]);
  }
  constexpr int kFastest = 1;
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kFastest), &libdeflate_free_compressor);
  std::string out(libdeflate_zlib_compress_bound(compressor.get(), coded.size()), '\0');
  out.resize(libdeflate_zlib_compress(compressor.get(), coded.data(), coded.size(), out.data(), out.size()));
  return out;
}

// Returns cv::imdecode, loaded for the first image that is not a gray PNG. OpenCV's codecs bring 120
// libraries, which would cost each process 70 ms at startup.
auto opencv_decoder(const fs::path& file) {
  constexpr char kImdecode[] = "_ZN2cv8imdecodeERKNS_11_InputArrayEi";
  static void* const library = dlopen(GAITSLAM_IMGCODECS, RTLD_NOW | RTLD_LOCAL);
  static void* const function = library ? dlsym(library, kImdecode) : nullptr;
  if (!function) throw files::FileError(file, "cannot be decoded: " GAITSLAM_IMGCODECS " is missing");
  return reinterpret_cast<cv::Mat (*)(cv::InputArray, int)>(function);
}

}  // namespace

void require_size(const fs::path& file, const cv::Mat& image, const cv::Size& size) {
  if (image.size() != size)
    throw files::FileError(file, "is an image of {}x{}, the camera's sensor.yaml has {}x{}", image.cols,
                           image.rows, size.width, size.height);
}

cv::Mat decode_image(const fs::path& file, std::string_view bytes, const cv::Size& size) {
  cv::Mat image;
  if (auto gray = decode_png(bytes, CV_8UC1)) {  // twice as fast as OpenCV
    image = *gray;
  } else if (bytes.starts_with(kSignature) || bytes.starts_with(kJpeg)) {
    // OpenCV fills the missing part of a JPEG with gray. An embedded small picture ends in the first half.
    if (bytes.starts_with(kJpeg) && bytes.find(kJpegEnd, bytes.size() / 2) == bytes.npos)
      throw files::FileError(file, "is cut off: the image has no end");
    const auto imdecode = opencv_decoder(file);
    const cv::Mat row(1, int(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    try {
      image = imdecode(row, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {  // leaves `image` empty, as most faults in the bytes do
    }
  }
  if (image.empty()) throw files::FileError(file, "cannot be read as an image: expected PNG or JPEG");
  require_size(file, image, size);
  return image;
}

std::string encode_png(const cv::Mat& image) {
  CV_Assert(!png_format(image.type()).empty());
  std::string header, png(kSignature);
  append_big_endian(header, std::size_t(image.cols));
  append_big_endian(header, std::size_t(image.rows));
  append_chunk(png, "IHDR", header.append(png_format(image.type())));
  append_chunk(png, "IDAT", compressed(image));
  return png.append(kEnd);
}

std::optional<cv::Mat> decode_png(std::string_view png, int type) {
  constexpr std::size_t kPixels = 41;  // after the header and the start of the pixel chunk
  if (png.size() < kPixels + 4 + kEnd.size() || !png.starts_with(kSignature) || png.substr(12, 4) != "IHDR" ||
      png.substr(24, 5) != png_format(type) || png.substr(37, 4) != "IDAT" || !png.ends_with(kEnd) ||
      kPixels + big_endian(png.substr(33)) + 4 + kEnd.size() != png.size())
    return std::nullopt;
  const std::size_t width = big_endian(png.substr(16)), height = big_endian(png.substr(20));
  if (width == 0 || height == 0 || width > kLargest || height > kLargest) return std::nullopt;
  const std::size_t row_bytes = width * CV_ELEM_SIZE(type);
  const auto swap = std::size_t(swapped(type));
  std::string coded(height * (row_bytes + 1), '\0');
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (libdeflate_zlib_decompress(decompressor.get(), png.data() + kPixels, png.size() - kPixels - 16,
                                 coded.data(), coded.size(), nullptr) != LIBDEFLATE_SUCCESS)
    return std::nullopt;
  cv::Mat image(int(height), int(width), type);
  const std::string nothing(row_bytes, '\0');
  const auto* from = reinterpret_cast<const Byte*>(coded.data());
  const auto* above = reinterpret_cast<const Byte*>(nothing.data());
  for (int v = 0; v < image.rows; ++v, from += row_bytes + 1) {
    if (from[0] != kUp) return std::nullopt;
    Byte* const row = image.ptr(v);
    for (std::size_t i = 0; i < row_bytes; ++i)
      row[i ^ swap] = static_cast<Byte>(from[1 + i] + above[i ^ swap]);
    above = row;
  }
  return image;
}

}  // namespace sim::recording
