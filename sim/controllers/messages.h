// The messages of gaitslam_walker.h.
#pragma once

#include "sim/controllers/controller.h"
#include "sim/controllers/gaitslam_walker.h"
#include "sim/programs/conversation.h"

namespace sim::controllers {

/// A program's READY.
struct Ready {
  gaitslam_walk_ready words{};
  std::vector<int> joints;             ///< joints that it commands, in its order
  std::vector<std::string> names;      ///< their names
  walking::JointVector start;          ///< angles of all joints
  std::chrono::nanoseconds period{0};  ///< period of SENSORS
};

/// A program's answer.
struct Answer {
  gaitslam_walk_answer words{};
  std::vector<gaitslam_joint_command> joints;
};

/// Return a whole message with its header. walk: the walk text of START; rig: messages of
/// gaitslam_estimator.h.
std::string start_message(const programs::Choice& choice, const walking::Robot& robot,
                          const RobotDescription& description, const std::string& walk, std::uint64_t seed);
std::string sensors_message(const gaitslam_walk_sensors& words, const Readings& readings,
                            std::string_view rig);

/// The maximum length in bytes of a READY or ANSWER for this robot.
std::size_t most_bytes(const walking::Robot& robot);

/// Read a message's payload. Throw InvalidMessage if its format or a value is invalid. read_ready() also
/// throws it if the program states that it cannot start.
Ready read_ready(std::string_view payload, const walking::Robot& robot);
Answer read_answer(std::string_view payload, const Ready& ready, std::chrono::nanoseconds t, bool settles);

}  // namespace sim::controllers
