#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/files/text.h"
#include "sim/live/run.h"
#include "sim/live/short_walks.h"
#include "sim/physics/adapted.h"
#include "sim/physics/robot.h"
#include "sim/scenario/robot.h"
#include "sim/score/trajectory.h"

namespace sim::live {
namespace {

using Print = std::function<void(const std::string&)>;

constexpr double kStand_s = 5;
constexpr int kSteps = 8;
constexpr std::uint64_t kSeed = 1;   // of the plant on which the robot walks in each direction
constexpr double kLeastShare = 0.5;  // fraction of the workspace; with less, ordinary steps hit a joint limit

const char* word(model_file::Fate fate) {
  return fate == model_file::Fate::kept_aside ? "kept aside"
         : fate == model_file::Fate::dropped  ? "dropped"
         : fate == model_file::Fate::doubtful ? "doubtful"
                                              : "converted";
}

void print_model(const physics::RobotFile& file, const physics::AdaptedRobot& adapted, const Print& print) {
  const std::vector<model_file::Element>& servos = adapted.root.child("actuator")->children;
  const bool limited =
      std::ranges::any_of(servos, [](const auto& servo) { return servo.find("forcerange"); });
  print(fmt::format("{}: {}{}", file.folder.string(), (file.folder / file.model).string(),
                    limited ? "" : ": has no torque limits"));
  for (const model_file::Note& note : adapted.notes)
    print(fmt::format("  {}: {}{}, {}", word(note.fate), note.what,
                      note.count > 1 ? fmt::format(" ({} times)", note.count) : "", note.first));
}

void print_robot(const walking::Robot& robot, const Print& print) {
  const auto limited =
      std::ranges::count_if(robot.joints, [](const auto& j) { return std::isfinite(j.effort); });
  print(fmt::format("  mass {:.3f} kg, {} joints with servos, {} of them with an effort limit", robot.mass,
                    robot.joints.size(), limited));
  print(fmt::format(
      "  in the start posture: base {:.4f} m above the ground, center of mass {:.4f} m and {:.4f} m ahead of "
      "the "
      "soles' points; feet {:.4f} m apart",
      robot.base_height, robot.com_height(), robot.com.x() - robot.sole_ahead, robot.foot_spacing));
  for (const auto& [side, name] : {std::pair(walking::Side::left, "left"), {walking::Side::right, "right"}}) {
    const walking::Leg& leg = robot.leg(side);
    print(fmt::format(
        "  {} sole: {:.3f} to {:.3f} m ahead of its point, {:.3f} to {:.3f} m to the left; ankle {:.3f} m "
        "above",
        name, leg.sole_min.x(), leg.sole_max.x(), leg.sole_min.y(), leg.sole_max.y(), leg.ankle().z()));
    for (const int index : leg.joints) {
      const walking::Joint& joint = robot.joints[std::size_t(index)];
      print(fmt::format("    {}: {:.1f} to {:.1f} deg{}", joint.name, joint.lowest / score::kDegree,
                        joint.highest / score::kDegree,
                        std::isfinite(joint.effort) ? fmt::format(", {:g} N m", joint.effort) : ""));
    }
  }
}

/// Returns the fraction of sole poses around the start posture that a leg reaches: 0.15 of the base's
/// height ahead and back, 0.05 inward, 0.1 outward and 0.1 up, turned by up to 0.2 rad.
double reached_share(const walking::Robot& robot, walking::Side side) {
  const walking::LegVector start = leg_angles(robot.leg(side), robot.posture);
  const Eigen::Isometry3d X_BS = sole_in_base(robot, side, start);
  const double outward = side == walking::Side::left ? 1 : -1;
  int reached = 0, all = 0;
  for (double x = -0.15; x <= 0.151; x += 0.05)
    for (double y = -0.05; y <= 0.101; y += 0.05)
      for (double z = 0; z <= 0.101; z += 0.05)
        for (const double yaw : {-0.2, 0.0, 0.2}) {
          Eigen::Isometry3d X = X_BS;
          X.pretranslate(robot.base_height * Eigen::Vector3d(x, outward * y, z));
          X.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * X.linear();
          const walking::LegSolution solution = leg_inverse_kinematics(robot, side, X, start);
          reached += !leg_obstacle(robot, side, solution);
          ++all;
        }
  return double(reached) / all;
}

}  // namespace

bool check_robot(const std::filesystem::path& folder, const Print& print) {
  const physics::RobotFile file = scenario::read_robot(folder);
  const physics::AdaptedRobot adapted = adapt(file);
  print_model(file, adapted, print);
  const physics::Models models(adapted.root, file, physics::kPhysicalRoom, scenario::standard_models());
  print_robot(models.robot, print);
  bool good = true;
  const auto judge = [&](bool ok, const std::string& what, const std::string& change) {
    print(fmt::format("  {}: {}{}", ok ? "ok" : "FAILED", what, ok ? "" : "; " + change));
    good &= ok;
  };
  if (const std::size_t joints = models.robot.legs[0].joints.size(); joints != 6) {
    judge(false, fmt::format("legs of {}: the built-in controller needs 6", files::counted(joints, "joint")),
          "let a program walk it (walk.controller)");
    return false;
  }
  for (const auto& [side, name] : {std::pair(walking::Side::left, "left"), {walking::Side::right, "right"}}) {
    const double share = reached_share(models.robot, side);
    judge(share >= kLeastShare,
          fmt::format("the {} leg reaches {:.0f} % of the step workspace", name, 100 * share),
          "bend the knees more in posture_deg, and check the joint ranges above");
  }
  const auto read = scenario::read_scenario_text(
      fmt::format("world: {{robot: {}, room: floor}}\nwalk: {{commands: [{{stand: {{}}}}]}}\n",
                  files::quote_if_needed((std::filesystem::absolute(folder) / "").string())),
      "robot_check");
  const auto try_walk = [&](const std::string& what, std::vector<walking::Command> commands, int steps,
                            std::optional<std::uint64_t> seed, const std::string& change) {
    const Walked walk = walked(read.scenario, models, std::move(commands), seed);
    std::string complaint = walk.complaint();
    if (const auto [left, right] = walk.landings; complaint.empty() && left + right < steps)
      complaint = fmt::format(
          "the left foot left the floor and landed {} times, the right one {}, expected {} together", left,
          right, steps);
    judge(complaint.empty(), what + (complaint.empty() ? "" : ": " + complaint), change);
  };
  try_walk(fmt::format("stands {:g} s", kStand_s), {walking::Stand{kStand_s}}, 0, {},
           "raise the gains in servos, and check sole_m and what touches the floor");
  walking::Steps steps;
  for (int i = 0; i < kSteps; ++i) steps.list.push_back({0, (i % 2 ? -1 : 1) * models.robot.foot_spacing, 0});
  const std::string change =
      "try walk.single_support_s: 0.4, a lower walk.step_height_m, a shorter walk.step_length_m, or other "
      "gains";
  try_walk(fmt::format("walks {} steps in place", kSteps), {steps, walking::Stand{1}}, kSteps, {}, change);
  for (const ShortWalk& walk : short_walks(read.scenario.walk))
    try_walk(fmt::format("walks 8 s {}", walk.name), walk.commands, 2, kSeed, change);  // a step of each foot
  return good;
}

}  // namespace sim::live
