#include "sim/recording/image_file.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "sim/files/text.h"
#include "sim/recording/grey_png.h"

namespace sim::recording {
namespace {

[[noreturn]] void fail_size(const std::filesystem::path& file, int width, int height, const ImageSize& size) {
  throw files::FileError(file, fmt::format("is an image of {}x{}, the camera's sensor.yaml has {}x{}", width,
                                           height, size.width, size.height));
}

// cv::imdecode, which is loaded for the first image that is no grey PNG: OpenCV's codecs come with 120
// libraries, GDAL among them, which would cost each process 70 ms at its start.
auto opencv_decoder(const std::filesystem::path& file) {
  constexpr char kImdecode[] = "_ZN2cv8imdecodeERKNS_11_InputArrayEi";
  static void* const library = dlopen(GAITSLAM_IMGCODECS, RTLD_NOW | RTLD_LOCAL);
  static void* const function = library ? dlsym(library, kImdecode) : nullptr;
  if (!function)
    throw files::FileError(file, "cannot be read: there is no " GAITSLAM_IMGCODECS " to decode it");
  return reinterpret_cast<cv::Mat (*)(cv::InputArray, int)>(function);
}

// Empty where OpenCV cannot decode it.
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
