#include "sim/live/frame_pipeline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/camera/shapes.h"
#include "sim/recording/image_file.h"
#include "sim/result/timing.h"

namespace sim::live {

using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kInFlight = 4;  // frames that are drawn or wait beside the walk

}  // namespace

FramePipeline::FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside)
    : options_(scenario.camera.value_or(camera::CameraOptions{})),
      lights_off_(scenario.world.lights_off),
      lead_(camera::Shutter(options_).lead()),
      motion_(2 * lead_),
      in_flight_(beside && scenario.camera ? kInFlight : 0),
      worker_(in_flight_ > 0) {
  if (!scenario.camera) return;
  physics::Model model = copy_of(models.in_room);
  surfaces_ = camera::room_surfaces(*model);
  auto make = [this, seed = scenario.world.seed, model = std::move(model)]() mutable {
    camera_ = std::make_unique<camera::HeadCamera>(std::move(model), options_, seed);
  };
  worker_.do_next(std::move(make)).get();
}

nanoseconds FramePipeline::next_due() const {
  return std::chrono::milliseconds(std::llround(1e3 * next_ / options_.rate_hz));
}

nanoseconds FramePipeline::next_event() const {
  return frames_.empty() ? next_due() : std::min(next_due(), frames_.front().observation.t + lead_);
}

void FramePipeline::draw_complete(nanoseconds t) {
  for (; !frames_.empty() && t >= frames_.front().observation.t + lead_; frames_.pop_front()) {
    const nanoseconds stamp = frames_.front().observation.t;
    drawn_.push_back(
        {stamp, worker_.do_next([this, frame = std::move(frames_.front()), motion = motion_]() mutable {
           return drawn(std::move(frame), motion);
         })});
  }
}

Frame FramePipeline::drawn(Frame frame, const camera::RecentMotion& motion) {
  if (!camera_) return frame;
  {
    const result::StageClock clock(frame.render_ms);
    frame.observation.image = camera_->render(motion, frame.observation.t, lights_off_);
  }
  {
    const result::StageClock clock(frame.encode_ms);
    frame.png = recording::encode_grey_png(frame.observation.image);
  }
  return frame;
}

Frame FramePipeline::pop() {
  std::future<Frame> frame = std::move(drawn_.front().frame);
  drawn_.pop_front();
  return frame.get();
}

}  // namespace sim::live
