// The view of a run or a replay, opened from a request. The implementations that need the simulator are in
// sim/view/live; a build without it has stubs.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"
#include "sim/view/access.h"

namespace sim::live {
struct RunObserver;
}
namespace sim::exports {
struct RobotDescription;
}

namespace sim::view {

struct ViewRequest : Access {
  bool view = false, control = false, wait = false;
  std::function<void(const std::string& url)> opened = [](const std::string&) {};
};

/// A view that is open while this exists.
class ViewSession {
 public:
  virtual ~ViewSession() = default;
  /// Hooks for the loop of a run or a replay.
  virtual const live::RunObserver& run_observer() const = 0;
  virtual const tracking::TrackingObserver& tracking_observer() const = 0;
  /// Reports to the viewers how it ended.
  virtual void end(const std::string& how) = 0;
};

/// Null unless requested. Throws as LiveView does.
std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario& read,
                                         const std::filesystem::path& models);
/// recording: the replayed one.
std::unique_ptr<ViewSession> view_of_replay(const ViewRequest& request, const scenario::ReadScenario& read,
                                            const std::filesystem::path& recording,
                                            const std::filesystem::path& models);

/// For exports; null without the simulator. Throws std::runtime_error if the models do not load.
std::shared_ptr<const exports::RobotDescription> robot_description(const scenario::Scenario& scenario,
                                                                   const std::filesystem::path& models);

/// Draws the robot in its room at a time, with its true waist pose and its measured joint angles.
using RobotView = std::function<cv::Mat(slam::Stamp t, const Eigen::Isometry3d& X_WB)>;
/// Empty without the simulator. Must be called in order of time by the thread that made it. Throws FileError
/// for broken encoder files of the recording.
RobotView robot_from_outside(const scenario::Scenario& scenario, const std::filesystem::path& recording,
                             const std::filesystem::path& models);

}  // namespace sim::view
