// The map's upkeep: landmarks begun, turned into points, deleted.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/landmark.h"
#include "slam/options.h"

namespace slam {

class Map {
 public:
  explicit Map(std::uint64_t seed) : random_(seed) { landmarks_.reserve(256); }  // growing takes memory

  const std::vector<Landmark>& landmarks() const { return landmarks_; }

  /// Counts one search for a landmark, and whether it was accepted.
  void count(std::size_t index, bool success);

  /// Makes a landmark that was just measured less certain by what the change of view since it was last
  /// counted may have moved its patch's apparent centre: sigma_view_px.
  void seen_anew(std::size_t index, const Camera& camera, const Options& options, Kalman& kalman);

  /// Turns the surface of a landmark that was just found at `pixel` if its template fits better then.
  void learn_surface(std::size_t index, const cv::Mat& image, const Eigen::Vector2d& pixel,
                     const Camera& camera, const State& state);

  /// Begins the landmarks known beforehand: each at the corner of the image nearest to where it should be
  /// seen, within 3 sigma. Returns how many were seen.
  int begin_known(const cv::Mat& image, Stamp t, const Camera& camera, const Options& options,
                  Kalman& kalman);

  /// Begins at most `wanted` landmarks at corners away from the pixels `taken`, which theirs join; returns
  /// how many. New ones are at the end of landmarks().
  int begin(const cv::Mat& image, Stamp t, std::vector<Eigen::Vector2d>& taken, int wanted,
            const Camera& camera, const Options& options, Kalman& kalman);

  /// Turns inverse depths that have become nearly Gaussian in space into points.
  void convert(double linearity, Kalman& kalman);

  /// Looks for the landmarks that are still lines; those with a sharp depth become points, those with none
  /// are deleted. Their ids join `deleted`; what came to be believed of each depth joins `lines`.
  void follow_lines(const cv::Mat& image, const Camera& camera, const Options& options, Kalman& kalman,
                    std::vector<int>& deleted, std::vector<DepthHypotheses>& lines);
  /// How many landmarks are still lines.
  int lines() const;

  /// Deletes what was searched for at least 10 times and found less than every second time (Davison et al.
  /// 2007), or has come to lie behind its own first sight; their ids join `deleted`.
  void prune(Kalman& kalman, std::vector<int>& deleted);

 private:
  void add(const cv::Mat& image, Stamp t, const Eigen::Vector2i& pixel, const Camera& camera,
           const Options& options, Kalman& kalman);
  void make_point(Landmark& landmark, const Eigen::Vector3d& p_W, const Eigen::Ref<const Eigen::MatrixXd>& J,
                  Kalman& kalman);
  void erase(std::size_t index, Kalman& kalman);

  std::vector<Landmark> landmarks_;
  int next_id_ = 0;
  std::mt19937_64 random_;
};

}  // namespace slam
