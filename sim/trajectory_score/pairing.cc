#include "sim/trajectory_score/pairing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <utility>

namespace sim::trajectory_score {
namespace {

namespace fs = std::filesystem;
using files::TimedPose, score::PosePair, score::Stamp, score::Trajectory;

Trajectory trajectory(const files::TrajectoryFile& file) {
  Trajectory poses;
  for (const files::TumRow& row : file.rows) poses.push_back({row.t, row.X});
  return poses;
}

std::string describe_file(const fs::path& file, const files::TrajectoryFile& read) {
  return fmt::format("{}: {}, {} poses from {:.3f} to {:.3f} s, stamps in {}{}{}", file.string(), read.format,
                     read.rows.size(), seconds(read.rows.front().t), seconds(read.rows.back().t), read.stamps,
                     read.has_orientation ? "" : ", positions only",
                     read.warning.empty() ? "" : "; warning: " + read.warning);
}

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

std::vector<PosePair> pair(const Trajectory& truth, Trajectory estimate, const PairingOptions& options) {
  if (!options.interpolate)
    return score::pair_by_nearest(truth, estimate, stamp(options.most_apart_s), stamp(options.offset_s));
  for (TimedPose& pose : estimate) pose.t += stamp(options.offset_s);
  return score::pair_by_interpolation(truth, estimate, most_gap(truth, options));
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

// An offset and the number of poses that it pairs.
struct Offset {
  Stamp t{0};
  std::size_t pairs = 0;
};

// The most frequent differences between stamps of the truth and some stamps of the estimate.
std::vector<Stamp> likely_offsets(const Trajectory& truth, const Trajectory& estimate, Stamp apart) {
  constexpr std::size_t kSome = 40, kBest = 8;
  std::map<std::int64_t, std::pair<std::size_t, Stamp>> votes;  // by the offset in units of `apart`
  const std::size_t every = std::max<std::size_t>(1, estimate.size() / kSome);
  for (std::size_t i = 0; i < estimate.size(); i += every)
    for (const TimedPose& pose : truth) {
      auto& [count, offset] = votes[(pose.t - estimate[i].t) / apart];
      offset = count++ == 0 ? pose.t - estimate[i].t : offset;
    }
  std::vector<std::pair<std::size_t, Stamp>> all;
  for (const auto& [unit, vote] : votes) all.push_back(vote);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Stamp> best;
  for (std::size_t i = 0; i < std::min(kBest, all.size()); ++i) best.push_back(all[i].second);
  return best;
}

// The offset that pairs the most stamps. Known clocks come first: results start at 0, their exports at 1e9 s.
Offset best_offset(const Trajectory& truth, const Trajectory& estimate, Stamp apart) {
  constexpr Stamp kEpoch = std::chrono::seconds(1'000'000'000);
  std::vector<Stamp> candidates{Stamp(0), -kEpoch, kEpoch, truth.front().t - estimate.front().t};
  for (const Stamp likely : likely_offsets(truth, estimate, std::max(apart, Stamp(1))))
    candidates.push_back(likely);
  Offset best;
  for (const Stamp candidate : candidates)
    if (const std::size_t pairs = score::pair_by_nearest(truth, estimate, apart, candidate).size();
        pairs > best.pairs)
      best = {candidate, pairs};
  return best;
}

// Why no or hardly any poses are paired, and the option that may help.
std::string why_unmatched(const Trajectory& truth, const Trajectory& estimate,
                          const std::vector<PosePair>& pairs, const PairingOptions& options) {
  const Offset best = best_offset(truth, estimate, stamp(options.most_apart_s));
  const double a0 = seconds(truth.front().t), a1 = seconds(truth.back().t),
               b0 = seconds(estimate.front().t) + options.offset_s,
               b1 = seconds(estimate.back().t) + options.offset_s;
  const std::string few = fmt::format(
      "{} of {} estimated poses have a true one{}: ", pairs.size(), estimate.size(),
      pairs.empty() ? "" : fmt::format(", over {:.3f} s", seconds(pairs.back().t - pairs.front().t)));
  if (pairs.empty() && b0 <= a1 && b1 >= a0)
    return few + (options.interpolate
                      ? fmt::format("true poses around them are more than {} s apart (--max-gap)",
                                    seconds(most_gap(truth, options)))
                      : fmt::format("no stamps nearer than {} s (--t-max-diff)", options.most_apart_s));
  return few +
         fmt::format("the truth is from {:.3f} to {:.3f} s, the estimate from {:.3f} to {:.3f} s", a0, a1, b0,
                     b1) +
         (best.pairs > pairs.size() ? fmt::format("; with --t-offset {} {} of its poses have a true one",
                                                  seconds(best.t), best.pairs)
                                    : "");
}

Stamp duration(const Trajectory& poses) { return poses.back().t - poses.front().t; }

// Returns whether the pairs cover only an instant of two trajectories that both last much longer.
bool meet_in_an_instant(const std::vector<PosePair>& pairs, const Trajectory& truth,
                        const Trajectory& estimate) {
  constexpr int kMuchLonger = 100;
  return (pairs.back().t - pairs.front().t) * kMuchLonger < std::min(duration(truth), duration(estimate));
}

// Throws std::invalid_argument if a sum or difference of stamps would overflow.
void require_offset(const Trajectory& truth, const Trajectory& estimate, double offset_s) {
  double furthest_s = std::abs(offset_s);
  for (const Stamp t : {truth.front().t, truth.back().t, estimate.front().t, estimate.back().t})
    furthest_s = std::max(furthest_s, std::abs(offset_s) + std::abs(seconds(t)));
  if (offset_s != 0 && !(furthest_s < 4e9))
    throw std::invalid_argument(fmt::format("--t-offset {}: with it a stamp is beyond 4e9 s", offset_s));
}

bool counts_frames(const files::TrajectoryFile& read) { return read.stamps == "frame numbers"; }

// Returns whether all stamps are whole seconds, like frame numbers that were read as seconds.
bool are_whole(const files::TrajectoryFile& read) {
  const auto whole = [](const files::TumRow& row) { return row.t % std::chrono::seconds(1) == Stamp(0); };
  return read.rows.size() > 2 && std::all_of(read.rows.begin(), read.rows.end(), whole);
}

double duration_s(const files::TrajectoryFile& read) {
  return seconds(read.rows.back().t - read.rows.front().t);
}

// Returns whether the poses last much shorter than the others, and not because they are fewer.
bool last_much_shorter(const files::TrajectoryFile& read, const files::TrajectoryFile& other) {
  constexpr double kMuch = 50;  // a minute has 60 seconds
  if (read.rows.size() < 2 || other.rows.size() < 2) return false;
  const double spans = static_cast<double>(read.rows.size() - 1),
               other_spans = static_cast<double>(other.rows.size() - 1);
  return kMuch * duration_s(read) <= duration_s(other) &&
         kMuch * duration_s(read) / spans <= duration_s(other) / other_spans;
}

// Throws FileError if the stamps of only one file are frame numbers, or if the units differ. Whole numbers
// may be times once a second, unless they last much longer than the other file with about as many poses.
void require_times(const fs::path& file, const files::TrajectoryFile& read, const fs::path& other_file,
                   const files::TrajectoryFile& other, const PairingOptions& options) {
  if (counts_frames(read) && !counts_frames(other))
    throw files::FileError(
        file, fmt::format("its stamps are frame numbers, those of {} are times in {}{}", other_file.string(),
                          other.stamps, read.format == "KITTI" ? "; times.txt beside it has the times" : ""));
  if (!are_whole(read) && !are_whole(other) && last_much_shorter(read, other))
    throw files::FileError(
        file,
        fmt::format(
            "its {} poses last {:.3f} s, the {} of {} last {:.3f} s: their stamps are not in the same unit",
            read.rows.size(), duration_s(read), other.rows.size(), other_file.string(), duration_s(other)));
  if (options.interpolate || !are_whole(read) || are_whole(other)) return;
  const bool longer = duration_s(read) > 1.5 * duration_s(other),
             as_many = 2 * other.rows.size() > read.rows.size();
  if (longer && as_many)
    throw files::FileError(
        file,
        fmt::format("its stamps are whole numbers up to {}, as frame numbers are, those of {} are times over "
                    "{:.3f} s; with --interpolate they are taken for seconds",
                    read.rows.back().t / std::chrono::seconds(1), other_file.string(), duration_s(other)));
}

// Throws FileError if rows of different numbers would have to be paired by their place in the file.
void require_rows(const fs::path& file, const files::TrajectoryFile& read, const fs::path& other_file,
                  const files::TrajectoryFile& other) {
  const bool by_row =
      counts_frames(read) && counts_frames(other) && (read.format == "KITTI" || other.format == "KITTI");
  if (by_row && read.rows.size() != other.rows.size())
    throw files::FileError(
        file,
        fmt::format("has {} poses and {} has {}, all without times: they cannot be paired by their row; "
                    "times.txt beside a KITTI file has the times",
                    read.rows.size(), other_file.string(), other.rows.size()));
}

// Throws FileError if nothing moves: errors of such positions are meaningless.
void require_motion(const fs::path& file, const std::vector<PosePair>& pairs,
                    Eigen::Isometry3d PosePair::*pose) {
  constexpr double kStill_m = 1e-9;
  const Eigen::Vector3d first = (pairs.front().*pose).translation();
  const auto is_there = [&](const PosePair& pair) {
    return ((pair.*pose).translation() - first).norm() <= kStill_m;
  };
  if (pairs.size() > 1 && std::all_of(pairs.begin(), pairs.end(), is_there))
    throw files::FileError(file, fmt::format("all {} matched poses coincide", pairs.size()));
}

}  // namespace

Stamp stamp(double seconds) { return Stamp(std::llround(1e9 * seconds)); }

PairedFiles pair_files(const fs::path& truth, const fs::path& estimate, const PairingOptions& options,
                       bool need_motion) {
  const files::TrajectoryFile a = files::read_trajectory(truth), b = files::read_trajectory(estimate);
  require_times(truth, a, estimate, b, options);
  require_times(estimate, b, truth, a, options);
  require_rows(estimate, b, truth, a);
  const Trajectory of_truth = trajectory(a), of_estimate = trajectory(b);
  require_offset(of_truth, of_estimate, options.offset_s);
  const std::vector<PosePair> pairs = pair(of_truth, of_estimate, options);
  if (pairs.empty() || meet_in_an_instant(pairs, of_truth, of_estimate))
    throw std::invalid_argument(why_unmatched(of_truth, of_estimate, pairs, options));
  if (need_motion) {
    require_motion(truth, pairs, &PosePair::X_true);
    require_motion(estimate, pairs, &PosePair::X_estimate);
  }
  const std::string pairing =
      !options.interpolate ? fmt::format("nearest stamp within {} s", options.most_apart_s)
                           : fmt::format("truth interpolated at the estimate's stamps, across at most {} s",
                                         seconds(most_gap(of_truth, options)));
  return {describe_file(truth, a),
          describe_file(estimate, b),
          pairing,
          pairs,
          coverage_of(of_truth, pairs),
          b,
          a.has_orientation && b.has_orientation};
}

}  // namespace sim::trajectory_score
