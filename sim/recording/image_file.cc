#include "sim/recording/image_file.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "sim/files/text.h"
#include "sim/recording/grey_png.h"

namespace sim::recording {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::uint32_t kMostASide = 1u << 30;

std::uint32_t image_number(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t n = 0;
  for (std::size_t i = at; i < at + count; ++i) n = n << 8 | static_cast<unsigned char>(bytes[i]);
  return n;
}

std::optional<ImageSize> checked_size(std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0 || width > kMostASide || height > kMostASide) return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

/// The header is the first chunk (ISO/IEC 15948).
std::optional<ImageSize> png_size(std::string_view bytes) {
  if (bytes.size() < 24 || bytes.substr(12, 4) != "IHDR") return std::nullopt;
  return checked_size(image_number(bytes, 16, 4), image_number(bytes, 20, 4));
}

/// Segments of a marker and a length, up to the start of a frame (ITU-T T.81, B.2.2).
std::optional<ImageSize> jpeg_size(std::string_view bytes) {
  std::size_t at = 2;
  while (at + 9 <= bytes.size()) {
    if (bytes[at] != '\xff') return std::nullopt;
    const std::uint32_t marker = image_number(bytes, at + 1, 1);
    if (marker == 0xff) {  // fill bytes may precede a marker
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return checked_size(image_number(bytes, at + 7, 2), image_number(bytes, at + 5, 2));
    at += 2 + image_number(bytes, at + 2, 2);
  }
  return std::nullopt;
}

/// Width and height as decimals between blanks and comments.
std::optional<ImageSize> pnm_size(std::string_view bytes) {
  std::uint32_t sides[2] = {};
  std::size_t at = 2;
  for (std::uint32_t& side : sides) {
    while (at < bytes.size() && (" \t\r\n"sv.find(bytes[at]) != std::string_view::npos || bytes[at] == '#'))
      at = bytes[at] == '#' ? bytes.find('\n', at) : at + 1;
    if (at >= bytes.size()) return std::nullopt;
    const auto [end, fault] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), side);
    if (fault != std::errc{}) return std::nullopt;
    at = static_cast<std::size_t>(end - bytes.data());
  }
  return checked_size(sides[0], sides[1]);
}

[[noreturn]] void fail_size(const std::filesystem::path& file, int width, int height, const ImageSize& size) {
  throw files::FileError(file, fmt::format("is an image of {}x{}, the camera's sensor.yaml has {}x{}", width,
                                           height, size.width, size.height));
}

// cv::imdecode, loaded for the first image that is not a grey PNG: OpenCV's codecs come with 120 libraries,
// which would cost each process 70 ms at its start.
auto opencv_decoder(const std::filesystem::path& file) {
  constexpr char kImdecode[] = "_ZN2cv8imdecodeERKNS_11_InputArrayEi";
  static void* const library = dlopen(GAITSLAM_IMGCODECS, RTLD_NOW | RTLD_LOCAL);
  static void* const function = library ? dlsym(library, kImdecode) : nullptr;
  if (!function) throw files::FileError(file, "cannot be decoded: " GAITSLAM_IMGCODECS " is missing");
  return reinterpret_cast<cv::Mat (*)(cv::InputArray, int)>(function);
}

// Empty if OpenCV cannot decode it.
cv::Mat decoded_by_opencv(const std::filesystem::path& file, std::string_view bytes, int flags) {
  const auto imdecode = opencv_decoder(file);
  const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  try {
    return imdecode(row, flags);
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace

std::optional<ImageSize> image_size(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return png_size(bytes);
  if (bytes.starts_with("\xff\xd8"sv)) return jpeg_size(bytes);
  if (bytes.starts_with("P5"sv) || bytes.starts_with("P6"sv)) return pnm_size(bytes);
  return std::nullopt;
}

void require_image_size(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size) {
  const auto found = image_size(bytes);
  if (!found || bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw files::FileError(file, "cannot be read as an image: expected PNG, JPEG, PGM or PPM");
  if (*found != size) fail_size(file, found->width, found->height, size);
}

cv::Mat decode_image(const std::filesystem::path& file, std::string_view bytes, const ImageSize& size,
                     int flags) {
  require_image_size(file, bytes, size);
  if (auto grey = decode_grey_png(bytes)) return *grey;  // twice as fast as OpenCV
  const cv::Mat image = decoded_by_opencv(file, bytes, flags);
  if (image.empty()) throw files::FileError(file, "cannot be read as an image");
  if (image.cols != size.width || image.rows != size.height) fail_size(file, image.cols, image.rows, size);
  return image;
}

}  // namespace sim::recording
