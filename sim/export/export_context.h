// What every exporter needs: the run's sensors, its observations, and how files and the README are written.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/export/exported_run.h"
#include "sim/export/lens_conversion.h"
#include "sim/recording/filter_input.h"
#include "sim/recording/sensor_yaml.h"

namespace sim::exports {

/// A run that is being exported into `folder`.
class ExportContext {
 public:
  /// undistort: images are those of a pinhole; else they are as recorded, of a camera with the equidistant
  /// lens. passes: how often filter_input() will be read to its end.
  ExportContext(const ExportedRun& run, const std::filesystem::path& folder, bool undistort, int passes = 1);

  const ExportedRun& run;
  const std::filesystem::path folder;
  recording::RecordingSetup setup;  ///< its camera is that of the exported images
  recording::ImuNoise noise;

  /// The observations from the beginning of the run, for next().
  recording::FilterInput filter_input() const { return {run.result / "recording", run.errors, run.seed}; }
  /// The next of them in order of time; nothing after the last.
  std::optional<slam::Observation> next(recording::FilterInput& input) const {
    run.progress((passed_ + input.part()) / passes_);
    auto observation = input.next_in_order();
    if (!observation) ++passed_;
    return observation;
  }
  /// Empty where the export is to be without truth.
  recording::Truth truth() const {
    return run.with_truth ? recording::read_truth(run.result / "recording") : recording::Truth();
  }
  /// The filter's X_WC; empty if no filter was run, or where the export is to be without truth.
  std::vector<files::TumRow> estimate() const;
  const slam::CameraIntrinsics& camera() const { return setup.calibration.camera; }
  /// An image of the filter's input, as it is exported.
  cv::Mat exported(const cv::Mat& image) const { return undistortion_ ? (*undistortion_)(image) : image; }

  /// The path of a file to be written; its folders are made as needed.
  std::filesystem::path new_file(const std::string& name) const;
  /// Writes a whole file.
  void write(const std::string& name, std::string_view bytes) const;
  /// write() of true poses, but where the export is to be without truth.
  void write_truth(const std::string& name, std::string_view bytes) const {
    if (run.with_truth) write(name, bytes);
  }
  /// Writes exported(image).
  void write_png(const std::string& name, const cv::Mat& image) const;
  /// Writes README.md: the text, then what holds for every export.
  void write_readme(const std::string& text) const;

 private:
  std::string lens_text() const;

  FittedCamera equidistant_;
  const int passes_;
  mutable int passed_ = 0;
  std::optional<Undistortion> undistortion_;
};

}  // namespace sim::exports
