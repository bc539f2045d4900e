// What a frame costs on its way to the filter: noise and light, encoding, decoding. The picture is a rendered
// one of the repository, or smooth noise where it has another size.
#include <benchmark/benchmark.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/stream/image_errors.h"
#include "sim/stream/random.h"

namespace {

using namespace sim::stream;

cv::Mat picture(int width) {
  cv::Mat grey = cv::imread(GAITSLAM_SOURCE_DIR "/tools/figures/head_view.png", cv::IMREAD_GRAYSCALE);
  cv::resize(grey, grey, {width, width * 3 / 4}, 0, 0, cv::INTER_AREA);
  return grey;
}

void image_errors(benchmark::State& state, const ImageOptions& options) {
  const cv::Mat ideal = picture(static_cast<int>(state.range(0)));
  ImageErrors errors(options, 1, {});
  std::int64_t t = 0;
  for (auto _ : state) benchmark::DoNotOptimize(errors.apply(ideal, slam::Stamp(++t)));
}

ImageOptions vignetted() {
  ImageOptions options;
  options.vignetting_fraction = 0.4;
  options.gain = 1.3;
  options.exposure_sigma_fraction = 0.1;
  return options;
}

void encode(benchmark::State& state, int level, int strategy) {
  const cv::Mat image = picture(static_cast<int>(state.range(0)));
  std::vector<unsigned char> png;
  std::vector<int> how{cv::IMWRITE_PNG_COMPRESSION, level};
  if (strategy >= 0) how.insert(how.end(), {cv::IMWRITE_PNG_STRATEGY, strategy});
  for (auto _ : state) cv::imencode(".png", image, png, how);
  state.counters["bytes"] = static_cast<double>(png.size());
}

void decode(benchmark::State& state, int level, int strategy) {
  std::vector<unsigned char> png;
  std::vector<int> how{cv::IMWRITE_PNG_COMPRESSION, level};
  if (strategy >= 0) how.insert(how.end(), {cv::IMWRITE_PNG_STRATEGY, strategy});
  cv::imencode(".png", picture(static_cast<int>(state.range(0))), png, how);
  for (auto _ : state) benchmark::DoNotOptimize(cv::imdecode(png, cv::IMREAD_UNCHANGED));
}

BENCHMARK_CAPTURE(image_errors, noise, ImageOptions{})->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(image_errors, noise_vignetting_gain_exposure, vignetted())->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(encode, level_1, 1, -1)->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(encode, level_1_huffman, 1, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY)->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(encode, level_1_rle, 1, cv::IMWRITE_PNG_STRATEGY_RLE)->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(encode, level_1_filtered, 1, cv::IMWRITE_PNG_STRATEGY_FILTERED)->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(decode, level_1, 1, -1)->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(decode, level_1_huffman, 1, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY)->Arg(320)->Arg(640);
BENCHMARK_CAPTURE(decode, level_1_rle, 1, cv::IMWRITE_PNG_STRATEGY_RLE)->Arg(320)->Arg(640);

}  // namespace

BENCHMARK_MAIN();
