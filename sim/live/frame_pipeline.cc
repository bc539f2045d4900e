#include "sim/live/frame_pipeline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "sim/camera/shapes.h"

namespace sim::live {

using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kInFlight = 4;  // frames that are drawn or wait beside the walk

nanoseconds frame_period(const camera::CameraOptions& options) {
  return std::chrono::milliseconds(std::llround(std::ceil(1e3 / options.rate_hz)));
}

}  // namespace

FramePipeline::FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside)
    : options_(scenario.camera.value_or(camera::CameraOptions{})),
      lead_(camera::Shutter(options_).lead()),
      readings_(scenario, models, beside),
      motion_(readings_.reach(lead_ + frame_period(options_))),
      draws_(scenario.camera.has_value()),
      in_flight_(beside && draws_ ? kInFlight : 0) {
  if (draws_) surfaces_ = camera::room_surfaces(*models.in_room);
}

nanoseconds FramePipeline::next_due() const {
  return std::chrono::milliseconds(std::llround(1e3 * next_ / options_.rate_hz));
}

nanoseconds FramePipeline::next_event() const {
  return frames_.empty() ? next_due() : std::min(next_due(), frames_.front().observation.t + lead_);
}

void FramePipeline::draw_complete(nanoseconds t) {
  for (; !frames_.empty() && t >= frames_.front().observation.t + lead_; frames_.pop_front()) {
    const nanoseconds end = frames_.front().observation.t + lead_;
    drawn_.push_back({std::move(frames_.front()),
                      readings_.start(end, std::make_shared<const camera::RecentMotion>(motion_))});
  }
}

// Each sensor's readings in order of time, one sensor after another.
Frame FramePipeline::pop() {
  Drawn drawn = std::move(drawn_.front());
  drawn_.pop_front();
  Frame& frame = drawn.frame;
  std::vector<RigFrame> all;
  for (slam::RigReading& imu : std::exchange(frame.observation.rig, {})) all.push_back({std::move(imu), {}});
  for (auto& readings : drawn.readings) std::ranges::move(readings.get().get(), std::back_inserter(all));
  std::ranges::stable_sort(
      all, {}, [](const RigFrame& each) { return std::pair(each.reading.sensor, each.reading.t); });
  for (RigFrame& each : all) {
    frame.render_ms += each.render_ms, frame.encode_ms += each.encode_ms;
    if (each.reading.sensor == kHeadCamera) {
      frame.observation.image = each.reading.image, frame.png = std::move(each.png);
    } else {
      frame.observation.rig.push_back(std::move(each.reading));
      frame.rig_pngs.push_back(std::move(each.png));
    }
  }
  return std::move(frame);
}

}  // namespace sim::live
