#include "sim/live/pending_frames.h"

#include <cmath>
#include <utility>

#include "sim/live/recorded.h"
#include "sim/world/surfaces.h"

namespace sim::live {

using std::chrono::nanoseconds;

PendingFrames::PendingFrames(const scenario::Scenario& scenario, const std::filesystem::path& models)
    : options_(scenario.camera.value_or(world::CameraOptions{})),
      lights_off_(scenario.world.lights_off),
      motion_(2 * world::Shutter(options_).lead()) {
  const world::WorldOptions& w = scenario.world;
  if (scenario.camera) camera_.emplace(world::load_model(w.robot, w.room, models), options_, w.seed);
}

std::vector<recording::RecordedSurface> PendingFrames::surfaces() const {
  std::vector<recording::RecordedSurface> surfaces;
  if (!camera_) return surfaces;
  for (const world::RoomPrimitive& primitive : world::room_primitives(camera_->model()))
    surfaces.push_back(recorded(primitive));
  return surfaces;
}

void PendingFrames::add_positions(const world::World& world) {
  if (camera_) motion_.add(world.time(), *world.model(), *world.data());
}

bool PendingFrames::is_due(nanoseconds t) const {
  return t == std::chrono::milliseconds(std::llround(1e3 * next_ / options_.rate_hz));
}

void PendingFrames::push(Frame frame) {
  frames_.push_back(std::move(frame));
  ++next_;
}

bool PendingFrames::is_complete(nanoseconds t) const {
  const nanoseconds lead = camera_ ? camera_->lead() : nanoseconds(0);
  return !frames_.empty() && t >= frames_.front().observation.t + lead;
}

Frame PendingFrames::pop() {
  Frame frame = std::move(frames_.front());
  frames_.pop_front();
  if (camera_) frame.observation.image = camera_->render(motion_, frame.observation.t, lights_off_);
  return frame;
}

}  // namespace sim::live
