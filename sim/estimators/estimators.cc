#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <sstream>

#include "sim/estimators/child_program.h"
#include "sim/estimators/messages.h"
#include "sim/files/hash.h"
#include "slam/filter.h"

namespace sim::estimators {
namespace {

namespace fs = std::filesystem;

constexpr double kMost_m = 1e9;             // beyond, squares of positions lose their accuracy
constexpr double kRotation = 1e-6;          // bound on R^T R - I of numbers that were printed
constexpr double kSymmetric = 1e-6;         // relative to the largest element
constexpr double kExitWithin_s = 2;         // after END
constexpr double kLastLinesWithin_s = 0.2;  // to write its last lines after it failed
constexpr std::string_view kFilter = "filter", kOdometry = "odometry", kPlanAlone = "plan_alone";
constexpr double kOdometryPivot_m = 0.25;  // best on the training walks
constexpr std::array kNames{kFilter, kOdometry, kPlanAlone};

template <class Matrix>
void require_covariance(const Matrix& P, std::string_view of) {
  if (!P.allFinite()) throw EstimatorFailed(fmt::format("the covariance of {} is not finite", of));
  const double largest = P.cwiseAbs().maxCoeff();
  if ((P - P.transpose()).cwiseAbs().maxCoeff() > kSymmetric * largest)
    throw EstimatorFailed(fmt::format("the covariance of {} is not symmetric", of));
}

/// The calibration, with the depth camera that is aligned with the head camera if the filter uses it.
slam::Calibration with_depth(const Start& start) {
  slam::Calibration calibration = start.calibration;
  if (start.options.depth.first_sight != slam::FirstSight::measured_depth) return calibration;
  for (std::size_t i = 0; i < start.rig.size(); ++i)
    if (start.rig[i].kind == rig::Kind::depth && start.rig[i].aligned_with == rig::kHeadCamera)
      calibration.depth = {static_cast<int>(i), rig::inverse_depth_sigma(start.rig[i])};
  if (!calibration.depth)
    throw std::invalid_argument(
        "slam.depth.first_sight: measured_depth needs a depth camera that is aligned with cam0");
  return calibration;
}

class FilterEstimator : public Estimator {
 public:
  explicit FilterEstimator(const Start& start)
      : calibration_(with_depth(start)), filter_(start.options, calibration_, start.X_WC, start.seed) {
    if (start.options.vision.enabled) filter_.record();
  }

  Answer step(const slam::Observation& observation) override {
    const slam::FrameReport& report = filter_.step(observation);
    const slam::Estimate& estimate = filter_.estimate();
    return {PoseEstimate{estimate.t, estimate.X_WC, estimate.covariance}, report};
  }
  bool uses(int sensor) const override { return calibration_.depth && calibration_.depth->sensor == sensor; }
  std::vector<slam::MapPoint> map() const override { return filter_.map(); }
  std::vector<PoseEstimate> smoothed() override {
    std::vector<PoseEstimate> poses;
    for (const slam::SmoothedPose& pose : filter_.smoothed().value_or(std::vector<slam::SmoothedPose>()))
      poses.push_back({pose.t, pose.X_WC, std::nullopt});
    return poses;
  }

 private:
  slam::Calibration calibration_;
  slam::Filter filter_;
};

std::string at(const slam::Observation& observation) {
  return fmt::format("at t = {:.3f} s", slam::seconds(observation.t));
}

/// Checks the answers of an estimator and keeps the latest map that an answer contains. A pose older than the
/// last one, as of a late observation, is left out.
class CheckedEstimator : public Estimator {
 public:
  Answer step(const slam::Observation& observation) final {
    newest_ = std::max(newest_, observation.t);
    Answer answer = ask(observation);
    try {
      require_valid(answer, observation.t, last_, newest_);
    } catch (const EstimatorFailed& invalid) {
      throw failed(at(observation), invalid.what());
    }
    if (answer.estimate && answer.estimate->t < last_) answer.estimate.reset();
    if (answer.estimate) last_ = answer.estimate->t;
    if (answer.map) map_ = *answer.map;
    answer.report.t = observation.t;
    answer.report.landmarks = static_cast<int>(map_.size());
    return answer;
  }
  std::vector<slam::MapPoint> map() const override { return map_; }

 private:
  virtual Answer ask(const slam::Observation& observation) = 0;
  /// Returns what to throw for an invalid answer. when: "at t = 1.000 s".
  virtual EstimatorFailed failed(const std::string& when, const std::string& cause) {
    return EstimatorFailed(fmt::format("{}: {}", when, cause));
  }

  slam::Stamp newest_{0}, last_{0};  // of the observations; of the last answer's pose
  std::vector<slam::MapPoint> map_;
};

class FunctionEstimator : public CheckedEstimator {
 public:
  explicit FunctionEstimator(Step step) : step_(std::move(step)) {}

 private:
  Answer ask(const slam::Observation& observation) override { return step_(observation); }

  Step step_;
};

/// The filter without its images: gyro, accelerometer and leg odometry, with their covariance. Without images
/// an error of the point about which the robot tilts would be taken for a bias of the gyro.
std::unique_ptr<Estimator> odometry(Start start) {
  double& pivot_m = start.options.leg_odometry.sigma_pivot_m;
  pivot_m = std::max(pivot_m, kOdometryPivot_m);
  start.options.vision.enabled = false;
  start.options.known_landmarks.at_m.clear();
  return std::make_unique<FilterEstimator>(start);
}

Step plan_alone(const Start& start) {
  PoseEstimate planned;
  planned.X_WC = start.X_WC;
  return [planned](const slam::Observation& observation) mutable -> Answer {
    planned.t = observation.t;
    if (observation.plan) planned.X_WC = observation.plan->X_PC;
    return {planned, {}};
  };
}

/// The conversation with a program, from START to END. Failures contain the time and the program's last
/// lines.
class ProgramEstimator : public CheckedEstimator {
 public:
  ProgramEstimator(const EstimatorChoice& choice, const Start& start)
      : choice_(choice), rig_(start.rig), program_(choice.words) {
    try {
      const TimeLimit limit(choice_.start_within_s);
      program_.send(start_message(choice_, start), limit);
      read_ready(receive(GAITSLAM_MESSAGE_READY, limit));
    } catch (const InvalidMessage& refusal) {
      throw std::invalid_argument(
          fmt::format("estimator: {}: {}{}", choice_.name, refusal.what(), last_lines()));
    } catch (const EstimatorFailed& failure) {
      throw failed("at its start", failure.what());
    }
  }

  std::string finish() override {
    try {
      program_.send(end_message(), TimeLimit(kExitWithin_s));
    } catch (const EstimatorFailed&) {
      // It has already exited.
    }
    program_.end(TimeLimit(kExitWithin_s));
    if (starts_message(program_.unread())) throw failed("at its end", kUnsolicited);
    return program_.log();
  }

 private:
  static constexpr const char* kUnsolicited =
      "it wrote more than one message to its standard output for each that it received";

  Answer ask(const slam::Observation& observation) override {
    const double before_ms = program_.cpu_ms();
    try {
      if (const std::string early = program_.unread(); starts_message(early))
        throw InvalidMessage(kUnsolicited);
      else if (!early.empty())
        throw InvalidMessage(fmt::format("its standard output has bytes that are not a message: '{}'",
                                         printable(early.substr(0, sizeof(gaitslam_header)))));
      const TimeLimit limit(choice_.answer_within_s);
      program_.send(observation_message(observation, rig_), limit);
      Answer answer = read_answer(receive(GAITSLAM_MESSAGE_ANSWER, limit));
      answer.external_cpu_ms = std::max(0.0, program_.cpu_ms() - before_ms);
      return answer;
    } catch (const EstimatorFailed& failure) {
      throw failed(at(observation), failure.what());
    }
  }

  EstimatorFailed failed(const std::string& when, const std::string& cause) override {
    const std::string lines = last_lines();
    return EstimatorFailed(fmt::format("the estimator {} failed {}: {}{}", choice_.name, when, cause, lines),
                           program_.log());
  }

  /// Ends the program.
  std::string last_lines() {
    program_.end(TimeLimit(kLastLinesWithin_s));
    const std::string lines = program_.last_lines();
    return lines.empty() ? "" : "; its last lines: " + lines;
  }

  std::string receive(std::uint32_t type, const TimeLimit& limit) {
    const std::size_t bytes = payload_bytes(program_.receive(kHeaderBytes, limit), type);
    return program_.receive(bytes, limit);
  }

  EstimatorChoice choice_;
  std::vector<rig::RigSensor> rig_;
  ChildProgram program_;
};

std::optional<std::string> hash_of(const fs::path& file) {
  std::error_code fault;
  std::ifstream in(file, std::ios::binary);
  if (!in || !fs::is_regular_file(file, fault)) return std::nullopt;
  files::Hash hash;
  for (std::array<char, 1 << 16> piece; in.read(piece.data(), piece.size()), in.gcount() > 0;)
    hash.add({piece.data(), static_cast<std::size_t>(in.gcount())});
  return hash.hex();
}

/// Searches a program without a slash in its name in PATH. Returns the word if it is not found.
fs::path program_file(const std::string& word) {
  const char* const path = std::getenv("PATH");
  if (word.find('/') != word.npos || !path) return word;
  std::istringstream folders(path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path file = fs::path(folder.empty() ? "." : folder) / word;
        ::access(file.c_str(), X_OK) == 0)
      return file;
  return word;
}

}  // namespace

void require_valid(const Answer& answer, slam::Stamp observed, slam::Stamp last, slam::Stamp newest) {
  if (answer.estimate) {
    const auto& [t, X, covariance] = *answer.estimate;
    if (t != observed && (t < last || t > newest))
      throw EstimatorFailed(fmt::format(
          "its pose has the stamp {} ns, expected that of the observation, {} ns, or of the last pose, {} ns",
          t.count(), observed.count(), last.count()));
    if (!X.matrix().allFinite()) throw EstimatorFailed("its pose is not finite");
    if (const Eigen::Matrix3d R = X.linear();
        !(R.transpose() * R).isIdentity(kRotation) || R.determinant() < 0)
      throw EstimatorFailed("the orientation of its pose is not a rotation matrix");
    if (X.translation().cwiseAbs().maxCoeff() > kMost_m)
      throw EstimatorFailed("its position is more than 1e9 m away");
    if (covariance) require_covariance(*covariance, "its pose");
  }
  if (!answer.map) return;
  for (const slam::MapPoint& point : *answer.map) {
    if (!point.p_W.allFinite()) throw EstimatorFailed(fmt::format("its landmark {} is not finite", point.id));
    require_covariance(point.covariance, fmt::format("its landmark {}", point.id));
  }
}

std::string printable(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == '\n' || c == '\t' || c == '\r';
    line += blank ? ' ' : c >= ' ' && c <= '~' ? c : '?';
  }
  return line;
}

std::unique_ptr<Estimator> estimator_from(Step step) {
  return std::make_unique<FunctionEstimator>(std::move(step));
}

std::span<const std::string_view> estimator_names() { return kNames; }

std::unique_ptr<Estimator> make_estimator(const EstimatorChoice& choice, const Start& start) {
  if (choice.source == Source::program) return std::make_unique<ProgramEstimator>(choice, start);
  if (choice.source == Source::built_in && choice.name == kFilter)
    return std::make_unique<FilterEstimator>(start);
  if (choice.source == Source::built_in && choice.name == kOdometry) return odometry(start);
  if (choice.source == Source::built_in && choice.name == kPlanAlone)
    return estimator_from(plan_alone(start));
  throw std::invalid_argument(
      "estimator: was a command on an exported recording, which gaitslam evaluate runs; expected another "
      "estimator");
}

std::string program_name(const std::vector<std::string>& words) {
  constexpr std::array kRunners{"python",  "pypy", "sh",      "bash",   "dash", "zsh",
                                "perl",    "ruby", "node",    "julia",  "java", "lua",
                                "Rscript", "env",  "timeout", "stdbuf", "nice", "taskset"};
  std::string name;
  for (const std::string& word : words) {
    const bool is_argument = word.empty() || word[0] == '-' || word.find('=') != word.npos ||
                             word.find_first_not_of("0123456789.") == word.npos;
    if (word == "-c") break;  // code instead of a file
    if (is_argument && !name.empty()) continue;
    name = fs::path(word).stem().string();
    const std::string program = name.substr(0, name.find_last_not_of("0123456789.") + 1);
    if (std::ranges::find(kRunners, program) == kRunners.end()) break;
  }
  return name;
}

void require_program(const EstimatorChoice& choice) {
  const fs::path file = program_file(choice.words.at(0));
  if (::access(file.c_str(), X_OK) != 0)
    throw std::invalid_argument(fmt::format("estimator: the program {} cannot be started: {}",
                                            choice.words[0], std::strerror(errno)));
}

std::string estimator_files_identity(const EstimatorChoice& choice) {
  std::string text;
  for (std::size_t i = 0; const std::string& word : command_words(choice)) {
    if (const auto hash = hash_of(i == 0 ? program_file(word) : fs::path(word)))
      text += fmt::format(" {} {}", i, *hash);
    ++i;
  }
  return text;
}

std::vector<std::string> command_words(const EstimatorChoice& choice) {
  if (choice.source != Source::command) return choice.words;
  std::istringstream words(choice.words.front());
  return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace sim::estimators
