// The filter on the synthetic room over several seeds: what the unit tests are too short to show. Not part of
// the suite.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>

#include "slam/filter.h"
#include "tests/slam/synthetic_room.h"

namespace {

using namespace slam;
using synthetic::Path;

Eigen::Vector3d log(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

struct Score {
  double ate = 0, rmse = 0, end = 0, end_yaw = 0, nees_p = 0, nees_q = 0, cpu_ms = 0, nis = 0, gyro_nis = 0,
         v_nis = 0;
  int loop = 0, landmarks = 0;
  double wrong = 0;  ///< share of accepted matches over 3 px from the truth
  double pixel_rms = 0;
  std::string cause;
};

struct Track {
  Eigen::Vector3d p_W;
  bool early;
  double last_s;
  bool away;
};

Score run(const synthetic::Room& room, synthetic::Recording& recording, const Options& options,
          std::uint64_t seed) {
  recording.reseed(seed);
  const synthetic::Walk& walk = recording.walk();
  const Camera camera(synthetic::calibration().camera);
  synthetic::Normal normal(seed * 0x9E3779B97F4A7C15ULL);
  const Eigen::Isometry3d start = walk.X_WC(0);
  Eigen::Isometry3d believed = start;
  believed.translation() += options.start.sigma_position_m * Eigen::Vector3d(normal(), normal(), normal());
  const Eigen::Vector3d tilt =
      options.start.sigma_orientation_rad * Eigen::Vector3d(normal(), normal(), normal());
  believed.linear() =
      believed.linear() * Eigen::AngleAxisd(tilt.norm(), tilt.normalized()).toRotationMatrix();
  Filter filter(options, synthetic::calibration(), believed, seed);
  Score s;
  std::map<int, Track> tracks;
  Eigen::Matrix3Xd truth(3, walk.frames()), estimate(3, walk.frames());
  int matches = 0, wrong = 0, nis_n = 0, good = 0;
  double pixel = 0;
  std::map<int, bool> loop;
  const bool verbose = std::getenv("VERBOSE") != nullptr;
  for (int k = 0; k < walk.frames(); ++k) {
    const Observation o = recording.observation(k);
    const std::clock_t begin = std::clock();
    const FrameReport& report = filter.step(o);
    s.cpu_ms += 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const double t = std::chrono::duration<double>(o.t).count();
    const Eigen::Isometry3d X = walk.X_WC(t), E = filter.estimate().X_WC;
    truth.col(k) = X.translation();
    estimate.col(k) = E.translation();
    const Eigen::Vector3d dq = log(E.linear().transpose() * X.linear()),
                          dp = X.translation() - E.translation();
    const Matrix6d& C = filter.estimate().covariance;
    s.nees_p += dp.dot(C.bottomRightCorner<3, 3>().llt().solve(dp));
    s.nees_q += dq.dot(C.topLeftCorner<3, 3>().llt().solve(dq));
    if (report.vision) s.nis += report.vision->value / report.vision->dof, ++nis_n;
    if (report.gyro) s.gyro_nis += report.gyro->value / 3;
    if (report.plan_velocity) s.v_nis += report.plan_velocity->value / 3;
    for (const Sighting& b : report.begun) {
      const Eigen::Vector3d p = room.hit(X.translation(), X.linear() * camera.unproject(b.pixel)->h);
      tracks[b.landmark] = {p, t < walk.duration_s / 4, t, false};
    }
    for (const Sighting& m : report.matched) {
      Track& track = tracks[m.landmark];
      const auto true_pixel = camera.project(X.inverse() * track.p_W);
      const double error = true_pixel ? (true_pixel->pixel - m.pixel).norm() : 99;
      ++matches;
      if (error > 3)
        ++wrong;
      else {
        pixel += error * error / 2;
        ++good;
      }
      if (t - track.last_s > 5) track.away = true;
      if (track.early && track.away && t > 0.75 * walk.duration_s && error < 3) loop[m.landmark] = true;
      track.last_s = t;
    }
    if (verbose && k % 15 == 0)
      std::printf(
          "t %.2f lm %d pred %d meas %d acc %d  dp %6.1f %6.1f %6.1f mm (sd %.1f %.1f %.1f) dq %5.2f %5.2f "
          "%5.2f mrad (sd %.2f %.2f %.2f) %s\n",
          t, report.landmarks, report.predicted, report.measured, report.accepted, 1e3 * dp.x(), 1e3 * dp.y(),
          1e3 * dp.z(), 1e3 * std::sqrt(C(3, 3)), 1e3 * std::sqrt(C(4, 4)), 1e3 * std::sqrt(C(5, 5)),
          1e3 * dq.x(), 1e3 * dq.y(), 1e3 * dq.z(), 1e3 * std::sqrt(C(0, 0)), 1e3 * std::sqrt(C(1, 1)),
          1e3 * std::sqrt(C(2, 2)), report.refused.c_str());
    s.landmarks = report.landmarks;
    s.cause = report.cause;
  }
  const double n = walk.frames();
  s.rmse = std::sqrt((truth - estimate).squaredNorm() / n);
  const Eigen::Isometry3d A(Eigen::umeyama(estimate, truth, false));
  s.ate = std::sqrt((truth - ((A.linear() * estimate).colwise() + A.translation())).squaredNorm() / n);
  s.end = (truth.rightCols<1>() - estimate.rightCols<1>()).norm();
  const Eigen::Vector3d dq =
      log(filter.estimate().X_WC.linear() * walk.X_WC(walk.duration_s).linear().transpose());
  s.end_yaw = std::abs(dq.z()) * 57.2958;
  s.nees_p /= n, s.nees_q /= n, s.cpu_ms /= n, s.nis /= std::max(1, nis_n), s.gyro_nis /= n, s.v_nis /= n;
  s.loop = static_cast<int>(loop.size());
  s.wrong = matches > 0 ? static_cast<double>(wrong) / matches : 0;
  s.pixel_rms = std::sqrt(pixel / std::max(1, good));
  return s;
}

/// Rendered once per machine: the files are named after the path in $GAITSLAM_CACHE.
std::vector<cv::Mat> cached_images(const synthetic::Room& room, const synthetic::Walk& walk, char name) {
  const char* folder = std::getenv("GAITSLAM_CACHE");
  if (folder == nullptr) return synthetic::render(room, walk, 2);
  const std::string file = std::string(folder) + "/walk_" + name + ".raw";
  constexpr int kRows = 240, kColumns = 320;
  std::vector<cv::Mat> images;
  if (std::FILE* in = std::fopen(file.c_str(), "rb")) {
    for (int k = 0; k < walk.frames(); ++k) {
      images.emplace_back(kRows, kColumns, CV_8UC1);
      if (std::fread(images.back().data, 1, kRows * kColumns, in) != kRows * kColumns) break;
    }
    std::fclose(in);
    if (static_cast<int>(images.size()) == walk.frames()) return images;
  }
  images = synthetic::render(room, walk, 2);
  if (std::FILE* out = std::fopen(file.c_str(), "wb")) {
    for (const cv::Mat& image : images) std::fwrite(image.data, 1, kRows * kColumns, out);
    std::fclose(out);
  }
  return images;
}

void set(Options& o, const std::string& word) {
  const auto at = word.find('=');
  const std::string key = word.substr(0, at);
  const double value = std::stod(word.substr(at + 1));
  std::map<std::string, double*> numbers{{"start.p", &o.start.sigma_position_m},
                                         {"start.q", &o.start.sigma_orientation_rad},
                                         {"acc", &o.motion.sigma_acceleration_m_s2},
                                         {"ang", &o.motion.sigma_angular_acceleration_rad_s2},
                                         {"gyro", &o.gyro.sigma_rad_s},
                                         {"bias", &o.gyro.sigma_bias_rad_s},
                                         {"asig", &o.accelerometer.sigma_m_s2},
                                         {"aframe", &o.accelerometer.sigma_frame_m_s2},
                                         {"abias", &o.accelerometer.sigma_bias_m_s2},
                                         {"v", &o.plan_velocity.sigma_m_s},
                                         {"slip", &o.plan_velocity.sigma_slip_m_s},
                                         {"slip_t", &o.plan_velocity.slip_time_s},
                                         {"h", &o.height.sigma_m},
                                         {"px", &o.vision.sigma_px},
                                         {"gpx", &o.vision.gate_sigma_px},
                                         {"ncc", &o.vision.minimum_correlation},
                                         {"corner", &o.vision.corner_threshold},
                                         {"rho", &o.depth.inverse_1_m},
                                         {"srho", &o.depth.sigma_inverse_1_m},
                                         {"lin", &o.depth.linearity}};
  if (numbers.count(key))
    *numbers[key] = value;
  else if (key == "n")
    o.vision.visible_landmarks = static_cast<int>(value);
  else if (key == "oc")
    o.consistency.observability_constrained = value != 0;
  else if (key == "use_gyro")
    o.gyro.enabled = value != 0;
  else if (key == "use_a")
    o.accelerometer.enabled = value != 0;
  else if (key == "use_v")
    o.plan_velocity.enabled = value != 0;
  else if (key == "use_h")
    o.height.enabled = value != 0;
  else if (key == "vision")
    o.vision.enabled = value != 0;
  else if (key == "world")
    o.plan_velocity.axes = value != 0 ? VelocityAxes::plan : VelocityAxes::robot;
  else
    std::fprintf(stderr, "unknown %s\n", key.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  int seeds = 3;
  synthetic::Walk walk;
  Options options;
  std::string which = "tp";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("seeds=", 0) == 0)
      seeds = std::stoi(word.substr(6));
    else if (word.rfind("walk=", 0) == 0)
      which = word.substr(5);
    else if (word.rfind("w.slip=", 0) == 0)
      walk.slip = std::stod(word.substr(7));
    else if (word.rfind("w.img=", 0) == 0)
      walk.image_sigma = std::stod(word.substr(6));
    else
      set(options, word);
  }
  const synthetic::Room room;
  for (const char c : which) {
    walk.path = c == 't' ? Path::tangent : Path::perpendicular;
    synthetic::Recording recording(walk, cached_images(room, walk, c));
    Score mean;
    for (int seed = 1; seed <= seeds; ++seed) {
      const Score s = run(room, recording, options, static_cast<std::uint64_t>(seed));
      std::printf(
          "%c seed %2d: ate %.4f rmse %.4f end %.4f yaw %.2f deg nees p %.2f q %.2f nis %.2f/%.2f/%.2f loop "
          "%d map %d px %.2f wrong %.4f cpu %.3f ms %s\n",
          c, seed, s.ate, s.rmse, s.end, s.end_yaw, s.nees_p, s.nees_q, s.nis, s.gyro_nis, s.v_nis, s.loop,
          s.landmarks, s.pixel_rms, s.wrong, s.cpu_ms, s.cause.c_str());
      mean.ate += s.ate / seeds, mean.rmse += s.rmse / seeds, mean.end += s.end / seeds,
          mean.end_yaw += s.end_yaw / seeds, mean.nees_p += s.nees_p / seeds, mean.nees_q += s.nees_q / seeds;
    }
    std::printf("%c MEAN: ate %.4f rmse %.4f end %.4f yaw %.2f nees p %.2f q %.2f\n", c, mean.ate, mean.rmse,
                mean.end, mean.end_yaw, mean.nees_p, mean.nees_q);
  }
}
