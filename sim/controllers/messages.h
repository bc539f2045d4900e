// The messages of gaitslam_walker.h.
#pragma once

#include "sim/controllers/controller.h"
#include "sim/controllers/gaitslam_walker.h"
#include "sim/programs/conversation.h"

namespace sim::controllers {

/// The READY of a program.
struct Ready {
  gaitslam_walk_ready words{};
  std::vector<int> joints;             ///< that it commands, in its order
  std::vector<std::string> names;      ///< of these
  walking::JointVector start;          ///< angles of all joints
  std::chrono::nanoseconds period{0};  ///< of SENSORS
};

/// An answer of a program.
struct Answer {
  gaitslam_walk_answer words{};
  std::vector<gaitslam_joint_command> joints;
};

/// Return a whole message with its header. walk: text of START.
std::string start_message(const programs::Choice& choice, const walking::Robot& robot,
                          const RobotDescription& description, const std::string& walk, std::uint64_t seed);
std::string sensors_message(const gaitslam_walk_sensors& words, const Readings& readings);

/// Most bytes of a READY or ANSWER of this robot.
std::size_t most_bytes(const walking::Robot& robot);

/// Read the payload of a message. Throw InvalidMessage if its format or a value is invalid; for READY also if
/// the program cannot start.
Ready read_ready(std::string_view payload, const walking::Robot& robot);
Answer read_answer(std::string_view payload, const Ready& ready, std::chrono::nanoseconds t, bool settles);

}  // namespace sim::controllers
