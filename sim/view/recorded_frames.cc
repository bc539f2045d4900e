#include <fmt/format.h>

#include "sim/files/contained_path.h"
#include "sim/files/csv.h"
#include "sim/recording/recording.h"
#include "sim/view/playback.h"

namespace sim::view {
namespace {

namespace fs = std::filesystem;

slam::Stamp from_file(std::int64_t stamp) { return slam::Stamp(stamp) - recording::kEpoch; }

/// The last row of a CSV file of the recording's at or before a time. Times are asked for in order.
class RowsOverTime {
 public:
  RowsOverTime(const fs::path& file, std::size_t fields) : reader_(file), row_(fields) {
    more_ = reader_.next();
    if (more_ && reader_.fields() != fields + 1)
      throw files::FileError(file, 1,
                             fmt::format("has {} columns, expected {}", reader_.fields(), fields + 1));
  }
  const std::vector<double>* at(slam::Stamp t) {
    for (; more_ && from_file(reader_.integer(0)) <= t; more_ = reader_.next()) {
      any_ = true;
      for (std::size_t i = 0; i < row_.size(); ++i) row_[i] = reader_.number(1 + i);
    }
    return any_ ? &row_ : nullptr;
  }

 private:
  files::CsvReader reader_;
  std::vector<double> row_;
  bool more_ = false, any_ = false;
};

FootPlace place_of(const recording::TrueFoot& foot) {
  return {foot.truth, foot.plan, foot.planned_down, foot.load_n};
}

void add_feet(std::vector<Frame>& frames, const std::vector<recording::TrueFeet>& feet) {
  std::size_t row = 0;
  for (Frame& frame : frames) {
    while (row + 1 < feet.size() && feet[row + 1].t <= frame.t) ++row;
    if (row < feet.size()) frame.feet = {place_of(feet[row].left), place_of(feet[row].right)};
  }
}

void add_zmp(std::vector<Frame>& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  RowsOverTime forces(file, 12);
  for (Frame& frame : frames) {
    const std::vector<double>* const row = forces.at(frame.t);
    if (!row || !frame.feet) continue;
    const auto sole = [&](std::size_t foot) {
      const double* const f = row->data() + 6 * foot;
      return SoleForce{(*frame.feet)[foot].truth, {f[0], f[1], f[2]}, {f[3], f[4], f[5]}};
    };
    frame.zmp = zero_moment_point({sole(0), sole(1)});
  }
}

std::size_t columns_of(const fs::path& file) { return files::CsvReader(file).titles().size(); }

void add_bodies(std::vector<Frame>& frames, const fs::path& file, const std::vector<files::TimedPose>& waist,
                const RobotModel& robot) {
  const std::size_t joints = columns_of(file) - 1;
  RowsOverTime encoders(file, joints);
  std::size_t row = 0;
  for (Frame& frame : frames) {
    while (row < waist.size() && waist[row].t < frame.t) ++row;
    const std::vector<double>* const q = encoders.at(frame.t);
    if (!q || row == waist.size() || waist[row].t != frame.t) continue;
    frame.bodies = robot.poses(
        Eigen::Map<const Eigen::VectorXd>(q->data(), static_cast<Eigen::Index>(joints)), waist[row].X);
  }
}

}  // namespace

void add_recorded(std::vector<Frame>& frames, const fs::path& recording, const RobotModel* robot) {
  const recording::Truth truth = recording::read_truth(recording);
  add_feet(frames, truth.feet);
  add_zmp(frames, recording / "mav0/forces0/data.csv");
  const fs::path encoders = recording / "mav0/encoders0/data.csv";
  if (robot && fs::exists(encoders)) add_bodies(frames, encoders, truth.waist, *robot);
}

std::vector<Frame> read_recorded_frames(const fs::path& recording, const RobotModel* robot) {
  const recording::Truth truth = recording::read_truth(recording);
  std::vector<Frame> frames(truth.camera.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].t = truth.camera[i].t, frames[i].truth = truth.camera[i].X;
  add_recorded(frames, recording, robot);
  return frames;
}

}  // namespace sim::view
