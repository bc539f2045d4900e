// An image of a recording: a decoded image has the requested size.
#include <opencv2/imgcodecs.hpp>

#include "sim/recording/image_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const sim::recording::ImageSize asked{48, 36};
  fuzz::read_or_reject([&] {
    const cv::Mat image =
        sim::recording::decode_image("image.png", fuzz::text_of(data, size), asked, cv::IMREAD_GRAYSCALE);
    fuzz::require(image.cols == asked.width && image.rows == asked.height && image.type() == CV_8UC1);
  });
  return 0;
}
