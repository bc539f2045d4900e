#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/trajectory_score/report.h"

namespace sim::trajectory_score {
namespace {

namespace fs = std::filesystem;
using files::TimedPose, score::PosePair, score::Stamp, score::Trajectory;

struct NamedFile {
  std::string path;
  files::TrajectoryFile read;

  std::size_t poses() const { return read.rows.size(); }
  double begin_s() const { return seconds(read.rows.front().t); }
  double end_s() const { return seconds(read.rows.back().t); }
  double duration_s() const { return seconds(read.rows.back().t - read.rows.front().t); }
  bool counts_frames() const { return read.stamps == "frame numbers"; }
  // Whether all stamps are whole seconds, like frame numbers that were read as seconds.
  bool is_whole() const {
    const auto whole = [](const files::TumRow& row) { return row.t % std::chrono::seconds(1) == Stamp(0); };
    return poses() > 2 && std::ranges::all_of(read.rows, whole);
  }
  Trajectory trajectory() const { return {read.rows.begin(), read.rows.end()}; }
  std::string line() const {
    return fmt::format("{}: {}, {} poses from {:.3f} to {:.3f} s, stamps in {}{}{}", path, read.format,
                       poses(), begin_s(), end_s(), read.stamps,
                       read.has_orientation ? "" : ", positions only",
                       read.warning.empty() ? "" : "; warning: " + read.warning);
  }
  template <class... Arguments>
  [[noreturn]] void fail(fmt::format_string<Arguments...> text, Arguments&&... arguments) const {
    throw files::FileError(path, fmt::format(text, std::forward<Arguments>(arguments)...));
  }
};

// The median time from one pose to the next; 0 for fewer than two.
template <class Poses>
Stamp median_interval(const Poses& poses) {
  std::vector<Stamp> intervals;
  for (std::size_t i = 1; i < poses.size(); ++i) intervals.push_back(poses[i].t - poses[i - 1].t);
  if (intervals.empty()) return Stamp(0);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

constexpr int kGap = 3;  // median intervals
constexpr Stamp kLeastGap = std::chrono::milliseconds(100);

Stamp most_gap(const Trajectory& truth, const PairingOptions& options) {
  return options.most_gap_s ? stamp(*options.most_gap_s) : std::max(kGap * median_interval(truth), kLeastGap);
}

Coverage coverage_of(const Trajectory& truth, const std::vector<PosePair>& pairs) {
  const Stamp of_truth = median_interval(truth), of_pairs = std::max(median_interval(pairs), of_truth),
              gap = std::max(kGap * of_pairs, kLeastGap), whole = truth.back().t - truth.front().t + of_truth;
  Stamp covered = of_pairs;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Stamp interval = pairs[i].t - pairs[i - 1].t;
    covered += interval <= gap ? interval : of_pairs;
  }
  Trajectory walked;
  for (const TimedPose& pose : truth)
    if (pose.t >= pairs.front().t - of_truth / 2 && pose.t <= pairs.back().t + of_truth / 2)
      walked.push_back(pose);
  const double fraction = whole.count() == 0 ? 1 : seconds(covered) / seconds(whole);
  return {truth.size(), std::min(1.0, fraction), score::path_length(walked)};
}

// "; with --t-offset ..." if the offset of a known clock pairs more poses: results start at 0, their exports
// at 1e9 s, other trajectories perhaps both at their first pose.
std::string offset_hint(const Trajectory& truth, const Trajectory& estimate, Stamp apart,
                        std::size_t most_pairs) {
  constexpr Stamp kEpoch = std::chrono::seconds(1'000'000'000);
  std::string hint;
  for (const Stamp offset : {Stamp(0), -kEpoch, kEpoch, truth.front().t - estimate.front().t}) {
    const std::size_t pairs = score::pair_by_nearest(truth, estimate, apart, offset).size();
    if (pairs <= most_pairs) continue;
    most_pairs = pairs;
    hint = fmt::format("; with --t-offset {} {} of its poses have a true one", seconds(offset), pairs);
  }
  return hint;
}

// Throws std::invalid_argument with the reason and the option that may help if no poses are paired, or only
// an instant of two trajectories that both last much longer.
void require_pairs(const NamedFile& truth, const NamedFile& estimate, const std::vector<PosePair>& pairs,
                   const PairingOptions& options) {
  constexpr double kMuchLonger = 100;
  const double paired_s = pairs.empty() ? 0 : seconds(pairs.back().t - pairs.front().t),
               begin_s = estimate.begin_s() + options.offset_s, end_s = estimate.end_s() + options.offset_s;
  if (!pairs.empty() && paired_s * kMuchLonger >= std::min(truth.duration_s(), estimate.duration_s())) return;
  std::string why = fmt::format("{} of {} estimated poses have a true one", pairs.size(), estimate.poses());
  if (!pairs.empty()) why += fmt::format(", over {:.3f} s", paired_s);
  const Trajectory of_truth = truth.trajectory();
  if (!pairs.empty() || begin_s > truth.end_s() || end_s < truth.begin_s())
    why +=
        fmt::format(": the truth is from {:.3f} to {:.3f} s, the estimate from {:.3f} to {:.3f} s{}",
                    truth.begin_s(), truth.end_s(), begin_s, end_s,
                    offset_hint(of_truth, estimate.trajectory(), stamp(options.most_apart_s), pairs.size()));
  else if (options.interpolate)
    why += fmt::format(": true poses around them are more than {} s apart (--max-gap)",
                       seconds(most_gap(of_truth, options)));
  else
    why += fmt::format(": no stamps nearer than {} s (--t-max-diff)", options.most_apart_s);
  throw std::invalid_argument(why);
}

// Returns whether the poses last much shorter than the others, and not because they are fewer.
bool lasts_much_shorter(const NamedFile& file, const NamedFile& other) {
  constexpr double kMuch = 50;  // a minute has 60 seconds
  if (file.poses() < 2 || other.poses() < 2) return false;
  const auto interval_s = [](const NamedFile& f) {
    return f.duration_s() / static_cast<double>(f.poses() - 1);
  };
  return kMuch * file.duration_s() <= other.duration_s() && kMuch * interval_s(file) <= interval_s(other);
}

// Throws FileError if the stamps of only one file are frame numbers, or if the units differ. Whole numbers
// may be times once a second, unless they last much longer than the other file with about as many poses.
void require_times(const NamedFile& file, const NamedFile& other, const PairingOptions& options) {
  if (file.counts_frames() && !other.counts_frames())
    file.fail("its stamps are frame numbers, those of {} are times in {}{}", other.path, other.read.stamps,
              file.read.format == "KITTI" ? "; times.txt beside it has the times" : "");
  if (!file.is_whole() && !other.is_whole() && lasts_much_shorter(file, other))
    file.fail("its {} poses last {:.3f} s, the {} of {} last {:.3f} s: their stamps are not in the same unit",
              file.poses(), file.duration_s(), other.poses(), other.path, other.duration_s());
  if (!options.interpolate && file.is_whole() && !other.is_whole() &&
      file.duration_s() > 1.5 * other.duration_s() && 2 * other.poses() > file.poses())
    file.fail(
        "its stamps are whole numbers up to {}, as frame numbers are, those of {} are times over {:.3f} s; "
        "with --interpolate they are taken for seconds",
        file.read.rows.back().t / std::chrono::seconds(1), other.path, other.duration_s());
}

// Throws FileError if nothing moves: errors of such positions are meaningless.
void require_motion(const NamedFile& file, const std::vector<PosePair>& pairs,
                    Eigen::Isometry3d PosePair::*pose) {
  constexpr double kStill_m = 1e-9;
  const Eigen::Vector3d first = (pairs.front().*pose).translation();
  const auto is_there = [&](const PosePair& pair) {
    return ((pair.*pose).translation() - first).norm() <= kStill_m;
  };
  if (pairs.size() > 1 && std::ranges::all_of(pairs, is_there))
    file.fail("all {} matched poses coincide", pairs.size());
}

}  // namespace

Stamp stamp(double seconds) { return Stamp(std::llround(1e9 * seconds)); }

PairedFiles pair_files(const fs::path& truth, const fs::path& estimate, const PairingOptions& options,
                       bool need_motion) {
  const NamedFile a{truth.string(), files::read_trajectory(truth)},
      b{estimate.string(), files::read_trajectory(estimate)};
  require_times(a, b, options);
  require_times(b, a, options);
  const bool by_row =
      a.counts_frames() && b.counts_frames() && (a.read.format == "KITTI" || b.read.format == "KITTI");
  if (by_row && a.poses() != b.poses())
    b.fail(
        "has {} poses and {} has {}, all without times: they cannot be paired by their row; times.txt beside "
        "a KITTI file has the times",
        b.poses(), a.path, a.poses());
  for (const double t : {a.begin_s(), a.end_s(), b.begin_s(), b.end_s()})  // their sum must not overflow
    if (options.offset_s != 0 && !(std::abs(options.offset_s) + std::abs(t) < 4e9))
      throw std::invalid_argument(
          fmt::format("--t-offset {}: with it a stamp is beyond 4e9 s", options.offset_s));
  const Trajectory of_truth = a.trajectory();
  Trajectory of_estimate = b.trajectory();
  for (TimedPose& pose : of_estimate) pose.t += stamp(options.offset_s);
  const std::vector<PosePair> pairs =
      options.interpolate ? score::pair_by_interpolation(of_truth, of_estimate, most_gap(of_truth, options))
                          : score::pair_by_nearest(of_truth, of_estimate, stamp(options.most_apart_s));
  require_pairs(a, b, pairs, options);
  if (need_motion) {
    require_motion(a, pairs, &PosePair::X_true);
    require_motion(b, pairs, &PosePair::X_estimate);
  }
  const std::string pairing =
      !options.interpolate ? fmt::format("nearest stamp within {} s", options.most_apart_s)
                           : fmt::format("truth interpolated at the estimate's stamps, across at most {} s",
                                         seconds(most_gap(of_truth, options)));
  return {a.line(),
          b.line(),
          pairing,
          pairs,
          coverage_of(of_truth, pairs),
          b.read,
          a.read.has_orientation && b.read.has_orientation};
}

}  // namespace sim::trajectory_score
