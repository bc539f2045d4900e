// Whether tuning recovers the noise of the sensors: walks in a synthetic room with known noise, a filter that
// starts a factor 5 off in every parameter, and the noise found compared with the known one.
#include <fmt/core.h>

#include <Eigen/Core>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/sensor_errors/random.h"
#include "sim/tracking/tracking.h"
#include "sim/tune/trial.h"
#include "sim/tune/tuning.h"
#include "tests/sim/tune/synthetic_result.h"

namespace {

namespace fs = std::filesystem;
namespace synthetic = slam::synthetic;
using namespace sim;

/// What is planted: gyro noise of a reading; scatter of pixels at the image's centre; error of the planned
/// velocity, root mean square over its three axes.
struct Planted {
  double gyro_rad_s, pixel_px, plan_m_s;
};

synthetic::Walk walk() {
  synthetic::Walk walk;
  walk.duration_s = 12;
  walk.turns = 0.45;
  walk.sway_m = 0.01, walk.bounce_m = 0.003;
  walk.slip = walk.yaw_error = 0;  // the plan is right but for what is planted
  walk.stand_s = -2;  // on its way at the start: no acceleration that the motion model does not have
  return walk;
}

/// Shakes a picture as hot air does: every place by a shift of its own, of that standard deviation at the
/// centre and twice that at the corners, anew in each picture, over about 40 pixels alike.
cv::Mat shaken(const cv::Mat& picture, const slam::Camera& camera, double sigma_px,
               sensor_errors::Random& random) {
  constexpr int kCell = 40;
  const cv::Size nodes(picture.cols / kCell + 3, picture.rows / kCell + 3);
  cv::Mat shift(nodes, CV_32FC2), fine;
  for (int i = 0; i < nodes.area(); ++i)
    shift.at<cv::Vec2f>(i / nodes.width, i % nodes.width) = {static_cast<float>(random.normal()),
                                                             static_cast<float>(random.normal())};
  cv::resize(shift, fine, nodes * kCell, 0, 0, cv::INTER_CUBIC);
  constexpr double kLost = 1.38;  // by which interpolation between independent shifts makes them smaller
  cv::Mat map(picture.size(), CV_32FC2), out;
  for (int v = 0; v < picture.rows; ++v)
    for (int u = 0; u < picture.cols; ++u) {
      const auto size = static_cast<float>(kLost * camera.sigma({u, v}, sigma_px));
      map.at<cv::Vec2f>(v, u) = cv::Vec2f(static_cast<float>(u), static_cast<float>(v)) +
                                size * fine.at<cv::Vec2f>(v + kCell, u + kCell);
    }
  cv::remap(picture, out, map, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return out;
}

/// One recording for each seed, made once.
std::vector<fs::path> recordings(const fs::path& folder, double sigma_px,
                                 const std::vector<cv::Mat>& pictures, int count) {
  const slam::Camera camera(synthetic::calibration().camera);
  std::vector<fs::path> all;
  for (int seed = 1; seed <= count; ++seed) {
    all.push_back(folder / fmt::format("shaken-{}-px", sigma_px) / fmt::format("seed-{}", seed));
    if (fs::exists(all.back() / "about.json")) continue;
    sensor_errors::Random random(static_cast<std::uint64_t>(seed), "shaken");
    std::vector<cv::Mat> own;
    for (const cv::Mat& picture : pictures) own.push_back(shaken(picture, camera, sigma_px, random));
    tests::write_result(all.back(), walk(), own, fmt::format("seed: {}\n", seed));
  }
  return all;
}

/// Matches minus where their landmark truly was, each about the landmark's own mean (its template was cut out
/// where the first picture was shaken to), by what the filter's model makes of the place in the image.
double pixel_error(const tune::Recording& recording, const scenario::Scenario& scenario) {
  const synthetic::Room room;
  const slam::Camera camera(recording.setup.calibration.camera);
  tracking::Tracking tracking(scenario, recording.setup.calibration, recording.setup.X_WC_start);
  for (const slam::Observation& o : recording.observations) tracking.step(o);
  const tracking::Tracked tracked = tracking.finish();
  std::map<int, Eigen::Vector3d> point;
  std::map<int, std::vector<std::pair<Eigen::Vector2d, double>>> errors;
  const auto X_WC = [&](slam::Stamp t) { return walk().X_WC(slam::seconds(t)); };
  for (const tracking::TrackedFrame& frame : tracked.frames) {
    const Eigen::Isometry3d X = X_WC(frame.report.t);
    for (const slam::Sighting& s : frame.report.initialized)
      point[s.landmark] = room.hit(X.translation(), X.linear() * camera.unproject(s.pixel)->h);
    for (const slam::Sighting& s : frame.report.matched)
      if (const auto there = camera.project(X.inverse() * point.at(s.landmark)))
        errors[s.landmark].push_back({s.pixel - there->pixel, camera.sigma(s.pixel, 1)});
  }
  double sum = 0, count = 0;
  for (const auto& [landmark, all] : errors) {
    if (all.size() < 5) continue;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto& [error, size] : all) mean += error / static_cast<double>(all.size());
    for (const auto& [error, size] : all) sum += (error - mean).squaredNorm() / (size * size);
    count += 2 * (static_cast<double>(all.size()) - 1);
  }
  return std::sqrt(sum / count);
}

/// What the planned velocity is off, root mean square over frames and axes.
double plan_error(const tune::Recording& recording) {
  double sum = 0, count = 0;
  const slam::Observation* before = nullptr;
  for (const slam::Observation& o : recording.observations) {
    if (before) {
      const double dt = slam::seconds(o.t - before->t);
      const Eigen::Vector3d planned = o.plan->X_PC.translation() - before->plan->X_PC.translation();
      const Eigen::Vector3d walked =
          walk().X_WC(slam::seconds(o.t)).translation() - walk().X_WC(slam::seconds(before->t)).translation();
      sum += ((planned - walked) / dt).squaredNorm(), count += 3;
    }
    before = &o;
  }
  return std::sqrt(sum / count);
}

/// A parameter of the search, started a factor off what was planted.
tune::Parameter about(const std::string& key, double planted, double factor) {
  return {key, {}, planted / 12, planted * 12, planted * factor, true};
}

tune::Spec spec_of(const Planted& planted, const std::vector<fs::path>& folders, tune::Objective objective,
                   int trials) {
  tune::Spec spec;
  spec.name = "recovery";
  spec.parameters = {about("slam.gyro.sigma_rad_s", planted.gyro_rad_s, 5),
                     about("slam.vision.sigma_px", planted.pixel_px, 0.2),
                     about("slam.plan_velocity.sigma_m_s", planted.plan_m_s, 5),
                     {"slam.motion.sigma_angular_acceleration_rad_s2", {}, 0.01, 10, 6, true}};
  spec.parameters[1].also = {"slam.vision.gate_sigma_px", "slam.vision.sigma_first_px"};  // shaken, too
  tune::RecordingSet set;
  set.set = {fmt::format("errors.gyro.sigma_rad_s={}", planted.gyro_rad_s),
             fmt::format("errors.plan.velocity_sigma_m_s={}", planted.plan_m_s * std::sqrt(1.5)),
             "errors.image.read_sigma_grey=1",
             "errors.image.shot_sigma_grey=0",
             "slam.plan_velocity.sigma_sway_m_s=0",
             "slam.plan_velocity.sigma_stride=0",
             "slam.vision.viewpoint_sigma_px=0",
             "slam.plan_velocity.pivots_on_foot=false",
             "slam.accelerometer.sigma_bias_m_s2=0",
             "slam.accelerometer.sigma_bias_walk_m_s3=0",
             "slam.height.sigma_m=0.003",
             "slam.start.sigma_position_m=0.0005",  // where it starts is known exactly
             "slam.start.sigma_orientation_rad=0.0005",
             "slam.start.sigma_velocity_m_s=0.5",
             "slam.start.sigma_rate_rad_s=0.5"};
  spec.training = spec.holdout = {set};
  spec.training[0].folders = {folders.begin(), folders.end() - 1};
  spec.holdout[0].folders = {folders.back()};
  spec.objective = objective;
  spec.trials = trials, spec.polish = trials / 4, spec.population = 24;
  return spec;
}

nlohmann::json json_of(const fs::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in);
}

void recover(const Planted& planted, const std::vector<fs::path>& folders, const fs::path& out,
             tune::Objective objective, int trials) {
  const tune::Spec spec = spec_of(planted, folders, objective, trials);
  const fs::path own = out / fmt::format("{}-gyro-{}-pixel-{}-plan-{}", tune::name(objective),
                                         planted.gyro_rad_s, planted.pixel_px, planted.plan_m_s);
  const auto result = tune::tune(spec, own, {2}, "tune_recovery", [](const tune::Progress&) {});
  const nlohmann::json json = json_of(own / "tune.json");
  scenario::Changes changes{spec.training[0].set, {}, {}};
  for (const auto& p : json["parameters"]) {
    changes.overrides.push_back(fmt::format("{}={}", p["key"].get<std::string>(), p["best"].get<double>()));
    for (const auto& also : p["also"])
      changes.overrides.push_back(fmt::format("{}={}", also.get<std::string>(), p["best"].get<double>()));
  }
  const scenario::Scenario tuned =
      scenario::read_scenario(folders.front() / "scenario.yaml", changes).scenario;
  const tune::Recording recording = tune::load(folders.front(), tuned);
  const double present[] = {planted.gyro_rad_s, pixel_error(recording, tuned), plan_error(recording)};
  fmt::print("{}", result.text);
  fmt::print("{}{}\n", tune::name(objective), result.accepted ? "" : ", worse than the start on hold-out");
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& p = json["parameters"][i];
    const auto& profile = json["profiles"][i];
    fmt::print(
        "  {:<30} planted {:<7.4g} present {:<8.4g} start {:<7.4g} found {:<8.4g} ({:+.0f} %)  95 % {} to "
        "{}\n",
        p["key"].get<std::string>(),
        i == 0   ? planted.gyro_rad_s
        : i == 1 ? planted.pixel_px
                 : planted.plan_m_s,
        present[i], p["start"].get<double>(), p["best"].get<double>(),
        100 * (p["best"].get<double>() / present[i] - 1), profile["low"].dump(), profile["high"].dump());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: tune_recovery FOLDER [TRIALS] [RECORDINGS]\n");
    return 2;
  }
  Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 8 << 20);
  cv::setNumThreads(1);
  const int trials = argc > 2 ? std::atoi(argv[2]) : 240, count = argc > 3 ? std::atoi(argv[3]) : 5;
  const std::vector<cv::Mat> pictures = render(synthetic::Room(), walk());
  for (const tune::Objective objective : {tune::Objective::innovation_nll, tune::Objective::pose_nll})
    for (const Planted& planted :
         {Planted{0.01, 1.0, 0.05}, Planted{0.03, 0.3, 0.05}, Planted{0.004, 0.3, 0.02}})
      recover(planted, recordings(argv[1], planted.pixel_px, pictures, count), argv[1], objective, trials);
}
