// Consistency of the filter: settings of it tried on recorded walks, with accuracy, NEES, and the share of
// frames in which its mean over the seeds is inside the 95 % band; with --by-time also when and along which
// axis it is not. Usage: consistency_table [--by-time] [--csv FILE] RESULTS FIRST..LAST ["name: key=value
// ..."]... where RESULTS/seed-N are results with recordings. See Variant (recorded_walk.h) for what a setting
// may be.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>

#include "sim/score/band_share.h"
#include "sim/score/statistics.h"
#include "tools/benchmarks/recorded_walk.h"

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kWindow_s = 4;
constexpr std::array kAxes{"ahead", "left", "up", "roll", "pitch", "yaw"};

/// One frame of one seed: errors and standard deviations along kAxes (position m, then orientation rad),
/// NEES.
struct Frame {
  double position = 0, orientation = 0;
  Vector6d error = Vector6d::Zero(), sigma = Vector6d::Zero();
};
/// By time, then a frame of each seed.
using Frames = std::map<double, std::vector<Frame>>;

/// Axes of the true heading, in W.
Eigen::Matrix3d heading_axes(const Eigen::Isometry3d& X_WC) {
  const Eigen::Vector3d forward = X_WC.linear().col(2);
  const double yaw = std::atan2(forward.y(), forward.x());
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

void add_frames(const Trial& trial, Frames& frames) {
  std::map<std::int64_t, const Eigen::Isometry3d*> truth;
  for (const auto& pose : trial.run.truth_camera) truth[pose.t.count()] = &pose.X;
  for (const auto& estimate : *trial.run.estimate) {
    const auto found = truth.find(estimate.t.count());
    if (found == truth.end()) continue;
    const Eigen::Isometry3d& X = *found->second;
    const auto nees = sim::score::pose_nees(X, estimate.X_WC, estimate.covariance);
    if (!nees) continue;
    const Eigen::Matrix3d A = heading_axes(X).transpose(), B = A * estimate.X_WC.linear();
    Frame f{nees->position, nees->orientation};
    f.error << A * (X.translation() - estimate.X_WC.translation()),
        B * sim::score::rotation_vector(estimate.X_WC.linear().transpose() * X.linear());
    f.sigma << (A * estimate.covariance.bottomRightCorner<3, 3>() * A.transpose()).diagonal().cwiseSqrt(),
        (B * estimate.covariance.topLeftCorner<3, 3>() * B.transpose()).diagonal().cwiseSqrt();
    frames[1e-9 * static_cast<double>(estimate.t.count())].push_back(f);
  }
}

double mean_of(const std::vector<Frame>& seeds, const auto& value) {
  double sum = 0;
  for (const Frame& f : seeds) sum += value(f);
  return sum / static_cast<double>(seeds.size());
}

/// Of the frames after sim::score::kSettled_s.
sim::score::BandShare share(const Frames& frames, const auto& nees) {
  std::vector<std::vector<double>> moments;
  for (auto at = frames.lower_bound(sim::score::kSettled_s); at != frames.end(); ++at) {
    moments.emplace_back();
    for (const Frame& f : at->second) moments.back().push_back(nees(f));
  }
  return sim::score::share_in_band(moments, 3).value_or(sim::score::BandShare{});
}

double position(const Frame& f) { return f.position; }
double orientation(const Frame& f) { return f.orientation; }

/// Means over the window's frames and all seeds. error: mean, and standard deviation between seeds of the
/// window's means, both in mm or mrad; sigma: as believed.
void print_windows(const Frames& frames) {
  fmt::print("  t      NEES pos  orient |");
  for (const char* axis : kAxes) fmt::print(" {:>5}: error (sd)  sigma |", axis);
  fmt::print("\n");
  for (double from = 0; from < frames.rbegin()->first; from += kWindow_s) {
    const auto begin = frames.lower_bound(from), end = frames.lower_bound(from + kWindow_s);
    double p = 0, o = 0, count = 0;
    Vector6d sigma = Vector6d::Zero();
    std::vector<Vector6d> errors(begin->second.size(), Vector6d::Zero());
    for (auto it = begin; it != end; ++it, ++count) {
      p += mean_of(it->second, position), o += mean_of(it->second, orientation);
      for (std::size_t s = 0; s < std::min(errors.size(), it->second.size()); ++s) {
        errors[s] += it->second[s].error;
        sigma += it->second[s].sigma / static_cast<double>(errors.size());
      }
    }
    fmt::print("{:4.0f} s {:8.2f} {:8.2f}  |", from, p / count, o / count);
    for (int a = 0; a < 6; ++a) {
      double sum = 0, squares = 0;
      for (const Vector6d& e : errors) sum += e(a) / count, squares += e(a) * e(a) / count / count;
      const double n = static_cast<double>(errors.size()), mean = sum / n;
      fmt::print(" {:6.1f} ({:4.1f}) {:5.1f}       |", 1e3 * mean,
                 1e3 * std::sqrt(std::max(0.0, squares / n - mean * mean)), 1e3 * sigma(a) / count);
    }
    fmt::print("\n");
  }
}

void write_csv(const std::string& file, const std::string& name, const Frames& frames) {
  std::ofstream out(file, std::ios::app);
  for (const auto& [t, seeds] : frames)
    for (std::size_t s = 0; s < seeds.size(); ++s) {
      out << fmt::format("{},{},{},{},{}", name, t, s, seeds[s].position, seeds[s].orientation);
      for (int a = 0; a < 6; ++a) out << fmt::format(",{},{}", seeds[s].error(a), seeds[s].sigma(a));
      out << '\n';
    }
}

struct Arguments {
  bool by_time = false;
  std::string csv, results;
  int first = 0, last = 0;
  std::vector<Variant> variants;
};

Arguments read_arguments(const std::vector<std::string>& words) {
  Arguments arguments;
  std::size_t i = 0;
  for (; i < words.size() && words[i].starts_with("--"); ++i) {
    if (words[i] == "--by-time")
      arguments.by_time = true;
    else if (words[i] == "--csv" && i + 1 < words.size())
      arguments.csv = words[++i];
    else
      throw std::invalid_argument("unknown option " + words[i]);
  }
  if (words.size() < i + 2 ||
      std::sscanf(words[i + 1].c_str(), "%d..%d", &arguments.first, &arguments.last) != 2)
    throw std::invalid_argument("expected [--by-time] RESULTS FIRST..LAST [\"name: key=value ...\"]...");
  arguments.results = words[i];
  for (i += 2; i < words.size(); ++i) arguments.variants.push_back(read_variant(words[i]));
  if (arguments.variants.empty()) arguments.variants.push_back({"as recorded", {}, {}});
  return arguments;
}

/// What the seeds of one variant gave.
struct Results {
  Frames frames;
  std::map<std::string, std::vector<double>> values;
};

void print(const Variant& variant, const Results& g, bool by_time) {
  const auto of = [&](const char* metric) {
    const auto found = g.values.find(metric);
    return found == g.values.end() ? std::nan("") : sim::score::median(found->second);
  };
  const sim::score::BandShare p = share(g.frames, position), o = share(g.frames, orientation);
  fmt::print(
      "{:<28} {:6.4f} {:6.4f} {:6.4f} {:5.2f} {:6.2f} {:5.1f} | {:6.2f} {:5.1f} ({:3.0f}) | {:6.2f} {:5.1f} "
      "({:3.0f}) | {:5.2f}\n",
      variant.name, of("ate_se3_rmse_m"), of("rmse_m"), of("end_position_error_m"), of("end_yaw_error_deg"),
      of("scale_error_percent"), of("loop_landmarks"), p.mean, 100 * p.inside, 100 * p.below, o.mean,
      100 * o.inside, 100 * o.below, of("filter_ms"));
  if (by_time) print_windows(g.frames);
  std::fflush(stdout);
}

void work(const Arguments& arguments) {
  std::vector<Results> results(arguments.variants.size());
  for (int seed = arguments.first; seed <= arguments.last; ++seed) {
    const RecordedWalk walk(std::filesystem::path(arguments.results) / fmt::format("seed-{}", seed));
    for (std::size_t v = 0; v < arguments.variants.size(); ++v) {
      const Trial trial = try_on(walk, arguments.variants[v]);
      add_frames(trial, results[v].frames);
      for (const auto& [name, metric] : trial.metrics)
        if (metric.value) results[v].values[name].push_back(*metric.value);
      results[v].values["filter_ms"].push_back(trial.filter_ms);
      if (trial.tracked.diverged())
        fmt::print(stderr, "{}, seed {}: diverged: {}\n", arguments.variants[v].name, seed,
                   trial.tracked.cause());
    }
  }
  fmt::print("{:<28} {:>6} {:>6} {:>6} {:>5} {:>6} {:>5} | {:>6} {:>5} {:>5} | {:>6} {:>5} {:>5} | {:>5}\n",
             "", "ATE", "rmse", "end", "yaw", "scale%", "loop", "NEES p", "in %", "(low)", "NEES o", "in %",
             "(low)", "ms");
  for (std::size_t v = 0; v < arguments.variants.size(); ++v) {
    print(arguments.variants[v], results[v], arguments.by_time);
    if (!arguments.csv.empty()) write_csv(arguments.csv, arguments.variants[v].name, results[v].frames);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 8 << 20);  // as the program does: the same bits
  try {
    work(read_arguments({argv + 1, argv + argc}));
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "consistency_table: {}\n", e.what());
    return 2;
  }
}
