#include "sim/live/frame_pipeline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <variant>

#include "sim/camera/lidar.h"
#include "sim/camera/shapes.h"
#include "sim/recording/image_file.h"
#include "sim/result/result.h"

namespace sim::live {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kInFlight = 4;  // frames being drawn or waiting while the walk continues

// Returns camera options for the item: the head camera's with a different mount and type.
camera::CameraOptions options_of(const rig::GrayEye& eye, camera::CameraOptions head) {
  static_cast<rig::Mount&>(head) = eye;
  head.position_m += rig::pose(eye).linear() * Eigen::Vector3d(0, -eye.baseline_m, 0);
  return head;
}
camera::CameraOptions options_of(const rig::ColorCamera& color) {
  camera::CameraOptions options;
  static_cast<rig::Mount&>(options) = color;
  static_cast<rig::Imager&>(options) = color;
  options.fov_rad = color.fov_rad, options.distortion = color.distortion;
  return options;
}

// Returns whether a sensor is read with the camera that it is aligned with, or by RigImus.
bool is_read_elsewhere(const rig::Item& item) {
  return std::holds_alternative<rig::DepthCamera>(item) || std::holds_alternative<rig::Imu>(item);
}

std::optional<std::size_t> depth_of(const std::vector<rig::Item>& rig, const std::string& camera) {
  for (std::size_t i = 0; i < rig.size(); ++i)
    if (const auto* depth = std::get_if<rig::DepthCamera>(&rig[i]); depth && depth->aligned_with == camera)
      return i;
  return std::nullopt;
}

}  // namespace

// Created, used and destroyed by its worker.
class FramePipeline::Sensor {
 public:
  // index: in the rig; none for the head camera, which the models already contain. A second eye shares the
  // textures of `head_camera`.
  Sensor(const scenario::Scenario& scenario, const physics::Models& models, SensorIndex index, bool beside,
         const Sensor* head_camera)
      : index_(index), world_(scenario.world), encoder_(beside), worker_(beside) {
    const camera::CameraOptions& head = *scenario.camera;
    if (!index) {
      make_camera(head, {}, camera::Channels::gray, "cam0", scenario, models);
      return;
    }
    const rig::Item& item = scenario.rig[*index];
    if (const auto* eye = std::get_if<rig::GrayEye>(&item)) {
      const camera::CameraOptions options = options_of(*eye, head);
      make_camera(options, options, camera::Channels::gray, eye->name, scenario, models,
                  head_camera->camera_.get());
    } else if (const auto* color = std::get_if<rig::ColorCamera>(&item)) {
      make_camera(options_of(*color), *color, camera::Channels::rgb, color->name, scenario, models);
    } else {
      const auto& lidar = std::get<rig::Lidar>(item);
      rate_hz_ = lidar.rate_hz;
      lead_ = due(1);
      make([this, &lidar, model = copy_of(models.in_room)]() mutable {
        const physics::Place place = physics::place_of(*model, lidar);
        lidar_ = std::make_unique<camera::Lidar>(std::move(model), place, lidar);
      });
    }
  }
  ~Sensor() {
    make([] {});  // encoding uses the camera
    encoder_.do_next([] {}).get();
    make([this] { camera_.reset(), lidar_.reset(); });
  }

  nanoseconds lead() const { return lead_; }

  void start(nanoseconds end, const std::shared_ptr<const camera::RecentMotion>& motion,
             std::vector<std::future<Encoded>>& started) {
    for (; (lidar_ ? due(next_ + 1) : due(next_) + lead_) <= end; ++next_)
      started.push_back(worker_.do_next([this, t = due(next_), until = due(next_ + 1), motion] {
        return lidar_ ? sweep(t, until, *motion) : image(t, *motion);
      }));
  }

 private:
  nanoseconds due(int k) const { return milliseconds(std::llround(1e3 * k / rate_hz_)); }

  void make(auto&& function) { worker_.do_next(std::forward<decltype(function)>(function)).get(); }

  void make_camera(const camera::CameraOptions& options, const rig::Mount& mount, camera::Channels channels,
                   const std::string& name, const scenario::Scenario& scenario, const physics::Models& models,
                   const camera::HeadCamera* shares = nullptr) {
    depth_ = depth_of(scenario.rig, name);
    rate_hz_ = options.rate_hz;
    lead_ = options.lead();
    make([this, &options, &mount, channels, shares, seed = scenario.world.seed,
          model = copy_of(models.in_room)]() mutable {
      camera_ =
          std::make_unique<camera::HeadCamera>(std::move(model), options, seed, channels, mount, shares);
    });
  }

  // Draws; the encoding worker applies lens and shutter and encodes.
  Encoded image(nanoseconds t, const camera::RecentMotion& motion) {
    double draw_ms = 0;
    camera::Exposure exposure;
    {
      const result::StageClock clock(draw_ms);
      exposure = camera_->expose(motion, t, world_, depth_.has_value());
    }
    return encoder_.do_next([this, t, draw_ms, exposure = std::move(exposure)] {
      std::vector<Reading> frames;
      const auto add = [&](SensorIndex sensor, const auto& develop) {
        Reading& frame = frames.emplace_back(Reading{sensor});
        frame.reading.t = t;
        {
          const result::StageClock clock(frame.render_ms);
          frame.reading.image = develop();
        }
        const result::StageClock clock(frame.encode_ms);
        frame.png = recording::encode_png(frame.reading.image);
      };
      add(index_, [&] { return camera_->image(exposure); });
      if (exposure.depth) add(depth_, [&] { return camera_->depth_mm(exposure); });
      frames[0].render_ms += draw_ms;
      return frames;
    });
  }

  Encoded sweep(nanoseconds t, nanoseconds until, const camera::RecentMotion& motion) {
    std::vector<Reading> frames{{index_}};
    const result::StageClock clock(frames[0].render_ms);
    frames[0].reading.t = t;
    frames[0].reading.points = lidar_->scan(motion, t, until);
    return encoder_.do_next([frames = std::move(frames)]() mutable { return std::move(frames); });
  }

  SensorIndex index_, depth_;  // index of this sensor; of the depth camera aligned with it
  physics::WorldOptions world_;
  double rate_hz_ = 30;
  nanoseconds lead_{0};
  int next_ = 0;
  std::unique_ptr<camera::HeadCamera> camera_;
  std::unique_ptr<camera::Lidar> lidar_;
  OrderedWorker encoder_, worker_;  // last: they use the members above, and worker_ uses encoder_
};

FramePipeline::FramePipeline(const scenario::Scenario& scenario, const physics::Models& models, bool beside)
    : options_(scenario.camera.value_or(camera::CameraOptions{})),
      lead_(options_.lead()),
      motion_(nanoseconds(0)),
      in_flight_(beside && scenario.camera ? kInFlight : 0) {
  if (!scenario.camera) return;
  nanoseconds reach{0};  // how far back positions are needed
  const nanoseconds frame = lead_ + milliseconds(std::llround(std::ceil(1e3 / options_.rate_hz)));
  const auto add = [&](SensorIndex index) {
    sensors_.push_back(std::make_unique<Sensor>(scenario, models, index, beside,
                                                sensors_.empty() ? nullptr : sensors_.front().get()));
    reach = std::max(reach, 2 * sensors_.back()->lead() + frame);
  };
  add(std::nullopt);
  for (std::size_t i = 0; i < scenario.rig.size(); ++i)
    if (!is_read_elsewhere(scenario.rig[i])) add(i);
  motion_ = camera::RecentMotion(reach);
  surfaces_ = camera::room_surfaces(*models.in_room);
}

FramePipeline::~FramePipeline() = default;

void FramePipeline::close_cameras() { sensors_.clear(); }

nanoseconds FramePipeline::next_due() const {
  return milliseconds(std::llround(1e3 * next_ / options_.rate_hz));
}

nanoseconds FramePipeline::next_event() const {
  return frames_.empty() ? next_due() : std::min(next_due(), frames_.front().observation.t + lead_);
}

void FramePipeline::draw_complete(nanoseconds t) {
  for (; !frames_.empty() && t >= frames_.front().observation.t + lead_; frames_.pop_front()) {
    const nanoseconds end = frames_.front().observation.t + lead_;
    Drawn& drawn = drawn_.emplace_back(Drawn{std::move(frames_.front()), {}});
    const auto motion = std::make_shared<const camera::RecentMotion>(motion_);
    for (const auto& sensor : sensors_) sensor->start(end, motion, drawn.readings);
  }
}

// Returns the readings sensor by sensor, each in chronological order.
Frame FramePipeline::pop() {
  Drawn drawn = std::move(drawn_.front());
  drawn_.pop_front();
  Frame& frame = drawn.frame;
  std::vector<Reading> all;
  for (slam::RigReading& imu : std::exchange(frame.observation.rig, {}))
    all.push_back({static_cast<std::size_t>(imu.sensor), std::move(imu)});
  for (auto& readings : drawn.readings) std::ranges::move(readings.get().get(), std::back_inserter(all));
  std::ranges::stable_sort(all, {},
                           [](const Reading& each) { return std::pair(each.sensor, each.reading.t); });
  for (Reading& each : all) {
    frame.render_ms += each.render_ms, frame.encode_ms += each.encode_ms;
    if (!each.sensor) {
      frame.observation.image = each.reading.image, frame.png = std::move(each.png);
    } else {
      each.reading.sensor = static_cast<int>(*each.sensor);
      frame.observation.rig.push_back(std::move(each.reading));
      frame.rig_pngs.push_back(std::move(each.png));
    }
  }
  return std::move(frame);
}

}  // namespace sim::live
