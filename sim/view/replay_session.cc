// The view of a replay: the filter live, on the recorded walk.
#include <fmt/format.h>

#include "sim/view/live_view.h"
#include "sim/view/session.h"
#include "sim/view/site.h"

namespace sim::view {

void add_tracked(Frame& frame, const slam::Observation& observation, const tracking::Tracking* tracking,
                 bool with_map) {
  frame.image = observation.image;
  if (!tracking || !tracking->newest()) return;
  const tracking::TrackedFrame& newest = *tracking->newest();
  if (newest.estimate) frame.estimate = newest.estimate->X_WC, frame.covariance = newest.estimate->covariance;
  frame.report = newest.report;
  if (with_map) frame.map = tracking->map();
}

namespace {

class ReplaySession : public ViewSession {
 public:
  ReplaySession(const ViewRequest& request, const scenario::ReadScenario& read, const fs::path& recording,
                const fs::path& models) {
    const recording::RecordingSetup setup = recording::RecordingReader(recording).setup();
    ShownRun run{.label = fmt::format("{}, seed {}, replayed", read.scenario.name, read.scenario.seed)};
    const MakeRobot make = robot_maker(models);
    std::optional<RobotModel> robot;
    if (make) robot = make(read.scenario);
    frames_ = read_recorded_frames(recording, robot ? &*robot : nullptr);
    run.camera = setup.calibration.camera;
    run.rig = setup.rig;
    run.moments = faults_of(read.scenario);
    if (!frames_.empty()) run.duration_s = slam::seconds(frames_.back().t);
    add_robot(run, robot);
    view_.emplace(request, run, request.control);
    request.opened(url(view_->access()));
    view_->begin(setup);
    if (request.wait) view_->wait_for_viewer();
    observer_.wants = [this](const slam::Observation& o) {
      view_->pace(o.t);
      view_->wants(o);
      return true;
    };
    observer_.tracked = [this](const slam::Observation& o, const tracking::Tracking* t) { show(o, t); };
  }

  // Never called.
  const live::RunObserver& run_observer() const override { throw std::logic_error("a replay is not a run"); }
  const tracking::TrackingObserver& tracking_observer() const override { return observer_; }
  void end(const std::string& how) override { view_->end(how); }

 private:
  void show(const slam::Observation& observation, const tracking::Tracking* tracking) {
    while (next_ < frames_.size() && frames_[next_].t < observation.t) ++next_;
    Frame frame{.t = observation.t};
    if (next_ < frames_.size() && frames_[next_].t == observation.t) frame = frames_[next_];
    if (observation.plan) frame.plan = observation.plan->X_PC;
    add_tracked(frame, observation, tracking, view_->wants_map());
    view_->show(frame);
  }

  std::vector<Frame> frames_;  // frames of the recording
  std::size_t next_ = 0;
  tracking::TrackingObserver observer_;
  std::optional<LiveView> view_;
};

}  // namespace

std::unique_ptr<ViewSession> view_of_replay(const ViewRequest& request, const scenario::ReadScenario& read,
                                            const fs::path& recording, const fs::path& models) {
  if (!request.view) return nullptr;
  return std::make_unique<ReplaySession>(request, read, recording, models);
}

}  // namespace sim::view
