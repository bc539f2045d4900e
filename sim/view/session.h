// The view of a run, opened from a request, and the pictures of its video. The implementations that
// need the simulator are in sim/view/live; a build without it has stubs.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"
#include "sim/view/server.h"
#include "slam/filter.h"

namespace sim::live {
struct RunObserver;
}
namespace sim::exports {
struct RobotDescription;
}

namespace sim::view {

namespace fs = std::filesystem;

/// wait: the run waits for a viewer and starts in real time, and the view stays open after it.
struct ViewRequest : Access {
  bool view = false, control = false, wait = false;
  std::function<void(const std::string& url)> opened = [](const std::string&) {};
};

/// A view that is open while this object exists.
class ViewSession {
 public:
  virtual ~ViewSession() = default;
  /// Returns the hooks for the loop of the run.
  virtual const live::RunObserver& run_observer() const = 0;
  virtual void wait_for_viewer() const = 0;
  /// Tells the viewers how the run ended. If ViewRequest::wait is set, the page becomes the playback of the
  /// result.
  virtual void end(const std::string& how, const fs::path& result) = 0;
};

/// Returns the view of a run, or null if none is requested. Throws whatever LiveView throws.
std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario& read,
                                         const fs::path& models);

/// Returns the robot, or null without the simulator. Throws std::runtime_error if the models do not load.
std::shared_ptr<const exports::RobotDescription> robot_description(const scenario::Scenario& scenario,
                                                                   const fs::path& models);

/// Draws the robot in its room at a given time, with its true waist pose and its measured joint angles.
using RobotView = std::function<cv::Mat(slam::Stamp t, const Eigen::Isometry3d& X_WB)>;
/// Returns a function to be called from this thread in chronological order; empty without the simulator.
/// Throws FileError.
RobotView robot_from_outside(const scenario::Scenario& scenario, const fs::path& recording,
                             const fs::path& models);

inline constexpr int kPanelWidth = 640, kPanelHeight = 480;  // px

/// Returns the image, enlarged to fit the panel, with each search's 3-sigma ellipse: green, with its 11 x 11
/// patch, if the match was used, otherwise yellow; blue patches for new landmarks.
cv::Mat3b draw_view(const slam::Observation& seen, const slam::FrameReport& report);

}  // namespace sim::view
