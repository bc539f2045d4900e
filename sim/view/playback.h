// The view of finished results, and what a recording knows of each frame.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/pages/frame.h"
#include "sim/recording/recording.h"
#include "sim/view/server.h"
#include "sim/view/site.h"
#include "sim/view/strips.h"

namespace sim::view {

/// The robot of a scenario, posed by hand. poses: of its model's bodies, by the angles of the encoders and
/// the waist's pose in W.
struct RobotModel {
  Model model;
  std::function<std::vector<float>(const Eigen::VectorXd& q, const Eigen::Isometry3d& X_WB)> poses;
};

FootPlace place_of(const recording::TrueFoot& foot);

/// Adds feet, zero-moment point and, given a robot, its bodies. frames: in order of time.
void add_recorded(std::vector<Frame>& frames, const std::filesystem::path& recording,
                  const RobotModel* robot);

/// Frames from a recording only, for the view of a replay: truth, and the parts of add_recorded(), without
/// images.
std::vector<Frame> read_recorded_frames(const std::filesystem::path& recording, const RobotModel* robot);

/// Loads the robot of a scenario; empty in a program without the simulator. Throws std::runtime_error where
/// the scenario's models do not load.
using MakeRobot = std::function<RobotModel(const scenario::Scenario&)>;

/// The robot maker of a program with the simulator; empty otherwise.
MakeRobot robot_maker(const std::filesystem::path& models);

/// A result as the page plays it.
struct Playback {
  ShownRun run;
  std::string scenario;                             ///< its name
  std::vector<Frame> frames;                        ///< without images
  std::vector<std::filesystem::path> images;        ///< PNG of each frame, or empty
  std::shared_ptr<const pages::Pictures> pictures;  ///< absent without a recording
};

/// Reads a result folder and its recording: its own, or that of the result it lies in as `replay` leaves it.
/// Missing parts are listed in ShownRun::missing. Throws FileError if the folder is not a result or a file is
/// broken.
Playback read_playback(const std::filesystem::path& result, const MakeRobot& make_robot);

/// Serves one result, or two of one scenario.
class PlaybackView {
 public:
  /// Throws std::invalid_argument for two scenarios, and as Server does.
  PlaybackView(const Access& access, const std::vector<Playback>& results);
  const Access& access() const { return server_.access(); }

 private:
  Site site_;
  Server server_;
};

}  // namespace sim::view
