#include "sim/live/frame_pipeline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "sim/camera/shapes.h"
#include "sim/recording/image_file.h"
#include "sim/result/timing.h"

namespace sim::live {

using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kInFlight = 4;  // frames that are drawn or wait beside the walk

nanoseconds frame_period(const camera::CameraOptions& options) {
  return std::chrono::milliseconds(std::llround(std::ceil(1e3 / options.rate_hz)));
}

// Each sensor's readings in order of time, one sensor after another.
void add(std::vector<RigFrame> readings, Frame& frame) {
  std::vector<RigFrame> all;
  for (slam::RigReading& reading : frame.observation.rig) all.push_back({std::move(reading), {}});
  for (std::string& png : frame.rig_pngs) all[std::size_t(&png - frame.rig_pngs.data())].png = std::move(png);
  std::ranges::move(readings, std::back_inserter(all));
  std::ranges::stable_sort(
      all, {}, [](const RigFrame& each) { return std::pair(each.reading.sensor, each.reading.t); });
  frame.observation.rig.clear(), frame.rig_pngs.clear();
  for (RigFrame& each : all) {
    frame.observation.rig.push_back(std::move(each.reading));
    frame.rig_pngs.push_back(std::move(each.png));
    frame.render_ms += each.render_ms, frame.encode_ms += each.encode_ms;
  }
}

}  // namespace

FramePipeline::FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside)
    : options_(scenario.camera.value_or(camera::CameraOptions{})),
      lights_off_(scenario.world.lights_off),
      lead_(camera::Shutter(options_).lead()),
      rig_(scenario, models, beside),
      motion_(std::max<nanoseconds>(2 * lead_, rig_.reach(lead_ + frame_period(options_)))),
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
    const auto motion = std::make_shared<const camera::RecentMotion>(motion_);
    auto rig = rig_.start(stamp + lead_, motion);
    drawn_.push_back({stamp, worker_.do_next([this, frame = std::move(frames_.front()), motion]() mutable {
                        return drawn(std::move(frame), *motion);
                      }),
                      std::move(rig)});
  }
}

Frame FramePipeline::drawn(Frame frame, const camera::RecentMotion& motion) {
  if (!camera_) return frame;
  RigFrame depth;
  const bool with_depth = rig_.head_depth() >= 0;
  {
    const result::StageClock clock(frame.render_ms);
    frame.observation.image = camera_->render(motion, frame.observation.t, lights_off_,
                                              with_depth ? &depth.reading.image : nullptr);
  }
  const result::StageClock clock(frame.encode_ms);
  frame.png = recording::encode_grey_png(frame.observation.image);
  if (!with_depth) return frame;
  depth.reading.sensor = rig_.head_depth();
  depth.reading.t = frame.observation.t;
  depth.png = recording::encode_png(depth.reading.image);
  add({std::move(depth)}, frame);
  return frame;
}

Frame FramePipeline::pop() {
  Drawn drawn = std::move(drawn_.front());
  drawn_.pop_front();
  Frame frame = drawn.frame.get();
  std::vector<RigFrame> rig;
  for (auto& readings : drawn.rig) std::ranges::move(readings.get(), std::back_inserter(rig));
  add(std::move(rig), frame);
  return frame;
}

}  // namespace sim::live
