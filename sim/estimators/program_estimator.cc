#include "sim/estimators/program_estimator.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "sim/estimators/child_program.h"
#include "sim/estimators/messages.h"

namespace sim::estimators {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kEndWithin_s = 2;  // after END; the result does not wait for a program that stays

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// The conversation with the program, from START to END.
class Conversation {
 public:
  Conversation(const OutsideProgram& program, const EstimatorChoice& choice, const Start& start)
      : called_(program.called), answer_within_s_(choice.answer_within_s), program_(program.words) {
    guarded("at its start", choice.start_within_s, [&](ChildProgram::Deadline deadline) {
      program_.send(start_message(choice, start), deadline);
      read_ready(receive(GAITSLAM_MESSAGE_READY, deadline));
    });
  }

  Answer step(const slam::Observation& observation) {
    Answer answer;
    const double before_ms = program_.cpu_ms();
    guarded(fmt::format("at t = {:.3f} s", slam::seconds(observation.t)), answer_within_s_,
            [&](ChildProgram::Deadline deadline) {
              program_.send(observation_message(observation), deadline);
              answer = read_answer(receive(GAITSLAM_MESSAGE_ANSWER, deadline));
            });
    answer.outside_cpu_ms = std::max(0.0, program_.cpu_ms() - before_ms);
    return answer;
  }

  std::string finish() {
    try {
      program_.send(end_message(), after(kEndWithin_s));
    } catch (const EstimatorFailed&) {
      // It has ended: nothing is asked of it any more.
    }
    program_.end(after(kEndWithin_s));
    return program_.log();
  }

 private:
  std::string receive(std::uint32_t type, ChildProgram::Deadline deadline) {
    const std::size_t bytes = payload_bytes(program_.receive(kHeaderBytes, deadline), type);
    return program_.receive(bytes, deadline);
  }

  /// Exchanges messages within a time, and says of a failure when it was and what the program had to say.
  template <class Exchange>
  void guarded(const std::string& when, double within_s, const Exchange& exchange) {
    try {
      exchange(after(within_s));
    } catch (const EstimatorFailed& failure) {
      const std::string lines = program_.last_lines();
      throw EstimatorFailed(fmt::format("{} failed {} (limit {} s): {}{}", called_, when, within_s,
                                        failure.what(), lines.empty() ? "" : "; its last lines: " + lines),
                            program_.log());
    }
  }

  std::string called_;
  double answer_within_s_;
  ChildProgram program_;
};

}  // namespace

Estimator outside_estimator(const OutsideProgram& program, const EstimatorChoice& choice,
                            const Start& start) {
  const auto conversation = std::make_shared<Conversation>(program, choice, start);
  return {.step = [conversation](
                      const slam::Observation& observation) { return conversation->step(observation); },
          .finish = [conversation] { return conversation->finish(); }};
}

Estimator program_estimator(const EstimatorChoice& choice, const Start& start) {
  return outside_estimator({"the program " + choice.words.front(), choice.words}, choice, start);
}

}  // namespace sim::estimators
