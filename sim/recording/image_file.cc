#include "sim/recording/image_file.h"

#include <fmt/format.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "sim/files/file_error.h"
#include "sim/recording/grey_png.h"

namespace sim::recording {
namespace {

[[noreturn]] void fail_size(const std::filesystem::path& file, int width, int height, const ImageSize& size) {
  throw files::FileError(file, fmt::format("is an image of {}x{}, the camera's sensor.yaml has {}x{}", width,
                                           height, size.width, size.height));
}

// Empty where OpenCV cannot decode it.
cv::Mat decoded_by_opencv(std::string_view bytes, int flags) try {
  const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  return cv::imdecode(row, flags);
} catch (const cv::Exception&) {
  return {};
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
  const cv::Mat image = decoded_by_opencv(bytes, flags);
  if (image.empty()) throw files::FileError(file, "cannot be read as an image");
  if (image.cols != size.width || image.rows != size.height) fail_size(file, image.cols, image.rows, size);
  return image;
}

}  // namespace sim::recording
