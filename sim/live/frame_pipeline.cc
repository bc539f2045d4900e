#include "sim/live/frame_pipeline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/camera/shapes.h"
#include "sim/recording/grey_png.h"
#include "sim/result/timing.h"

namespace sim::live {
OrderedWorker::OrderedWorker(bool own_thread) {
  if (own_thread) thread_ = std::thread([this] { work(); });
}

OrderedWorker::~OrderedWorker() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void OrderedWorker::add(std::function<void()> task) {
  if (!thread_.joinable()) return task();
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(task));
  }
  changed_.notify_one();
}

void OrderedWorker::work() {
  for (;;) {
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
      if (stopping_) return;
      task = std::move(waiting_.front());
      waiting_.pop_front();
    }
    task();
  }
}

using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kInFlight = 4;  // frames that are drawn or wait beside the walk

}  // namespace

FramePipeline::FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside)
    : options_(scenario.camera.value_or(camera::CameraOptions{})),
      lights_off_(scenario.world.lights_off),
      lead_(scenario.camera ? camera::Shutter(options_).lead() : nanoseconds(0)),
      motion_(2 * camera::Shutter(options_).lead()),
      in_flight_(beside && scenario.camera ? kInFlight : 0),
      worker_(beside && scenario.camera.has_value()) {
  if (!scenario.camera) return;
  auto model = std::make_shared<physics::Model>(copy_of(models.in_room));
  surfaces_ = camera::room_surfaces(**model);
  worker_
      .do_next([this, model, seed = scenario.world.seed] {
        camera_ = std::make_unique<camera::HeadCamera>(std::move(*model), options_, seed);
      })
      .get();
}

void FramePipeline::add_positions(const physics::World& world) {
  if (camera_) motion_.add(world.time(), *world.model(), *world.data());
}

nanoseconds FramePipeline::next_due() const {
  return std::chrono::milliseconds(std::llround(1e3 * next_ / options_.rate_hz));
}

nanoseconds FramePipeline::next_event() const {
  return frames_.empty() ? next_due() : std::min(next_due(), frames_.front().observation.t + lead_);
}

void FramePipeline::push(Frame frame) {
  frames_.push_back(std::move(frame));
  ++next_;
}

void FramePipeline::draw_complete(nanoseconds t) {
  while (!frames_.empty() && t >= frames_.front().observation.t + lead_) draw_oldest();
}

void FramePipeline::draw_all() {
  while (!frames_.empty()) draw_oldest();
}

void FramePipeline::draw_oldest() {
  auto frame = std::make_shared<Frame>(std::move(frames_.front()));
  frames_.pop_front();
  drawn_stamps_.push_back(frame->observation.t);
  drawn_.push_back(worker_.do_next([this, frame, motion = motion_] {
    if (camera_) {
      const result::StageClock clock(frame->render_ms);
      frame->observation.image = camera_->render(motion, frame->observation.t, lights_off_);
    }
    if (camera_) {
      const result::StageClock clock(frame->encode_ms);
      frame->png = recording::encode_grey_png(frame->observation.image);
    }
    return std::move(*frame);
  }));
}

Frame FramePipeline::pop() {
  std::future<Frame> frame = std::move(drawn_.front());
  drawn_.pop_front();
  drawn_stamps_.pop_front();
  return frame.get();
}

void FramePipeline::close_camera() {
  worker_.do_next([this] { camera_.reset(); }).get();
}

}  // namespace sim::live
