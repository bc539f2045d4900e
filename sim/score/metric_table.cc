#include "sim/score/metric_table.h"

#include <string>

namespace sim::score {
namespace {

using Rows = std::vector<MetricRow>;
using enum Worst;
constexpr bool kHeadline = true;

const std::string kNotAligned =
    ", without alignment: both in W, the plan's world at t = 0; frames from the first planned motion on";

void add_absolute(Rows& rows) {
  rows.push_back(
      {{"ate_se3_rmse_m", "m",
        "absolute trajectory error: root mean square distance between estimated and true camera positions "
        "after the turn and shift (SE(3), no scale) that brings them nearest; frames from the first planned "
        "motion on",
        largest, kHeadline},
       [](const Scored& s) { return ate(s, Alignment::se3); }});
  rows.push_back({{"rmse_m", "m",
                   "root mean square distance between estimated and true camera positions" + kNotAligned +
                       " (planned waist more than 1 mm from its start)",
                   largest, kHeadline},
                  [](const Scored& s) { return ate(s, Alignment::none); }});
  const std::vector<std::tuple<std::string, std::string, Alignment>> others{
      {"yaw", "a turn about the vertical alone and a shift", Alignment::yaw_position},
      {"sim3", "a scale besides", Alignment::sim3},
      {"origin", "the first estimated pose moved onto the first true one instead", Alignment::origin},
      {"scale", "the scale of ate_sim3_rmse_m alone, without its turn and shift", Alignment::scale}};
  for (const auto& [name, words, alignment] : others)
    rows.push_back({{"ate_" + name + "_rmse_m", "m", "as ate_se3_rmse_m, with " + words, largest},
                    [alignment](const Scored& s) { return ate(s, alignment); }});
  rows.push_back({{"scale_error_percent", "%",
                   "by how much the estimated path is too large, by the scale of the alignment of "
                   "ate_sim3_rmse_m",
                   largest_magnitude, kHeadline},
                  scale_error});
  rows.push_back(
      {{"poses_matched", "1",
        "estimated poses that have the stamp of a true one, from the first planned motion on: what "
        "the errors are taken over",
        smallest},
       poses_matched});
  for (int axis = 0; axis < 3; ++axis)
    rows.push_back({{std::string("rmse_") + "xyz"[axis] + "_m", "m",
                     std::string("the part of rmse_m along ") + "xyz"[axis] + " of W", largest},
                    [axis](const Scored& s) { return rmse_along(s, axis); }});
  rows.push_back(
      {{"rotation_rmse_deg", "deg",
        "root mean square angle between estimated and true camera orientation" + kNotAligned, largest},
       rotation_rmse});
  rows.push_back({{"yaw_rmse_deg", "deg",
                   "root mean square turn about the vertical that brings the estimated camera orientation "
                   "nearest to the true one" +
                       kNotAligned,
                   largest},
                  yaw_rmse});
}

void add_relative(Rows& rows) {
  struct Length {
    std::string name, words;
    Spans spans;
  };
  std::vector<Length> lengths;
  for (const auto& [name, metres] :
       {std::pair{"25cm", 0.25}, {"50cm", 0.5}, {"1m", 1.0}, {"2m", 2.0}, {"4m", 4.0}})
    lengths.push_back(
        {name,
         "over " + (metres < 1 ? name : std::string(name).insert(1, " ")) +
             " of the true path (from each frame to the one nearest to that much further, within 10 %)",
         {Spans::Unit::metres, metres, true, 0.1, true}});
  lengths.push_back({"1s", "over 1 s (from each frame)", {Spans::Unit::seconds, 1, true}});
  for (const auto& [name, words, spans] : lengths) {
    const bool headline = name == "1m";
    rows.push_back({{"rpe_" + name + "_m", "m",
                     "relative pose error: root mean square translation error of the motion " + words,
                     largest, headline},
                    [spans = spans](const Scored& s) { return relative_translation(s, spans); }});
    rows.push_back(
        {{"rpe_" + name + "_deg", "deg",
          "relative pose error: root mean square rotation error of the motion " + words, largest, headline},
         [spans = spans](const Scored& s) { return relative_rotation(s, spans); }});
  }
  rows.push_back(
      {{"rpe_step_m", "m",
        "relative pose error: root mean square translation error from one planned landing of a foot "
        "to the next",
        largest},
       step_translation});
  rows.push_back({{"rpe_step_deg", "deg", "root mean square rotation error over the same footsteps", largest},
                  step_rotation});
}

void add_end(Rows& rows) {
  rows.push_back({{"end_position_error_m", "m",
                   "distance between estimated and true camera position at the last frame, without alignment",
                   largest, kHeadline},
                  end_position_error});
  for (int axis = 0; axis < 3; ++axis)
    rows.push_back({{std::string("end_error_") + "xyz"[axis] + "_m", "m",
                     std::string("estimated minus true camera position at the last frame along ") +
                         "xyz"[axis] + " of W, without alignment",
                     largest_magnitude},
                    [axis](const Scored& s) { return end_error_along(s, axis); }});
  rows.push_back(
      {{"drift_percent", "%", "end_position_error_m in percent of path_length_m", largest, kHeadline},
       drift_percent});
  rows.push_back(
      {{"end_yaw_error_deg", "deg",
        "size of the turn about the vertical that brings the estimated camera orientation nearest to "
        "the true one at the last frame, without alignment",
        largest, kHeadline},
       end_yaw_error});
}

void add_walk(Rows& rows) {
  rows.push_back(
      {{"height_range_m", "m",
        "greatest minus least estimated camera height from the first planned motion on", largest, kHeadline},
       estimated_height_range});
  rows.push_back(
      {{"true_height_range_m", "m",
        "greatest minus least true camera height from the first planned motion on", largest, kHeadline},
       true_height_range});
  rows.push_back({{"plan_rmse_m", "m", "what rmse_m would be if the planned camera pose were the estimate",
                   largest, kHeadline},
                  plan_rmse});
  rows.push_back({{"plan_drift_x_m", "m",
                   "true minus planned waist position at the last frame, ahead in axes of the planned start",
                   largest_magnitude, kHeadline},
                  plan_drift_x});
  rows.push_back(
      {{"plan_drift_y_m", "m",
        "true minus planned waist position at the last frame, to the left in axes of the planned start",
        largest_magnitude, kHeadline},
       plan_drift_y});
  rows.push_back(
      {{"plan_drift_yaw_deg", "deg", "true minus planned waist yaw at the last frame, left positive",
        largest_magnitude, kHeadline},
       plan_drift_yaw});
}

void add_feet(Rows& rows) {
  rows.push_back(
      {{"slip_landing_m", "m",
        "way of the soles on the ground, end minus begin, summed over all landings: from the first touch "
        "until a foot first carries 40 % of the weight",
        largest},
       foot_slip_landing});
  rows.push_back(
      {{"slip_support_m", "m", "likewise while a foot carries the robot", largest}, foot_slip_support});
  rows.push_back(
      {{"slip_lift_off_m", "m",
        "likewise from when a foot last carries 40 % of the weight until it leaves the ground", largest},
       foot_slip_lift_off});
  rows.push_back(
      {{"slip_landing_deg", "deg",
        "turns of the soles on the ground, end minus begin, sizes summed over all landings", largest},
       foot_turn_landing});
  rows.push_back(
      {{"slip_support_deg", "deg", "likewise while a foot carries the robot", largest}, foot_turn_support});
  rows.push_back({{"slip_lift_off_deg", "deg", "likewise of feet about to leave the ground", largest},
                  foot_turn_lift_off});
  rows.push_back(
      {{"contact_creep_m", "m",
        "how much of slip_..._m the contact model could not hold although below the friction cone: a "
        "numerical artefact",
        largest},
       foot_creep});
  rows.push_back({{"contact_creep_deg", "deg", "likewise of slip_..._deg", largest}, foot_creep_turn});
  rows.push_back({{"slip_drift_x_m", "m", "share of plan_drift_x_m that comes from feet moving on the ground",
                   largest_magnitude},
                  slip_drift_x});
  rows.push_back(
      {{"slip_drift_y_m", "m", "share of plan_drift_y_m likewise", largest_magnitude}, slip_drift_y});
  rows.push_back({{"slip_drift_yaw_deg", "deg", "share of plan_drift_yaw_deg likewise", largest_magnitude},
                  slip_drift_yaw});
  rows.push_back(
      {{"put_down_drift_x_m", "m",
        "share of plan_drift_x_m that comes from feet put down elsewhere than planned, seen from the other "
        "foot",
        largest_magnitude},
       put_down_drift_x});
  rows.push_back(
      {{"put_down_drift_y_m", "m", "share of plan_drift_y_m likewise", largest_magnitude}, put_down_drift_y});
  rows.push_back(
      {{"put_down_drift_yaw_deg", "deg", "share of plan_drift_yaw_deg likewise", largest_magnitude},
       put_down_drift_yaw});
}

void add_loop(Rows& rows) {
  rows.push_back(
      {{"loop_landmarks", "1",
        "landmarks begun before the plan has turned a quarter of its total turn, whose surface point by "
        "truth was out of the field of view for at least 5 s in one stretch, and of which after three "
        "quarters of the turn a match was accepted within 3 px of where truth puts that surface point; for "
        "plans that turn by at least 350 degrees",
        smallest, kHeadline},
       loop_landmark_count});
  rows.push_back(
      {{"loop_closed", "1", "1 if loop_landmarks is at least 3, else 0", smallest, kHeadline}, loop_closed});
  rows.push_back(
      {{"loop_time_s", "s", "when the first of the loop_landmarks was found again", largest, kHeadline},
       loop_time});
  const std::string before = " in the frame before loop_time_s",
                    after = " 1 s after loop_time_s, or at the last frame if that is earlier";
  rows.push_back(
      {{"loop_error_before_m", "m", "camera position error, without alignment," + before, largest, kHeadline},
       loop_error_before});
  rows.push_back(
      {{"loop_error_after_m", "m", "camera position error, without alignment," + after, largest, kHeadline},
       loop_error_after});
  const std::string sigma =
      "what the filter thinks that error is: root of the trace of the position's covariance";
  rows.push_back({{"loop_sigma_before_m", "m", sigma + before, largest}, loop_sigma_before});
  rows.push_back({{"loop_sigma_after_m", "m", sigma + after, largest}, loop_sigma_after});
  rows.push_back(
      {{"loop_logdet_drop", "1",
        "log determinant of the pose's 6x6 covariance before the closure (see loop_error_before_m) "
        "minus after it: what the closure told the filter, in nats times two",
        smallest},
       loop_logdet_drop});
  const std::string correction =
      "size of the correction: by how much the estimated motion from the frame before the closure to 1 s "
      "after it "
      "differs from the true motion, ";
  rows.push_back({{"loop_correction_m", "m", correction + "translation", largest}, loop_correction});
  rows.push_back({{"loop_correction_deg", "deg", correction + "rotation", largest}, loop_correction_turn});
}

void add_nees(Rows& rows) {
  for (const auto& [name, part] :
       {std::pair<std::string, double PoseNees::*>{"position", &PoseNees::position},
        {"orientation", &PoseNees::orientation}}) {
    rows.push_back(
        {{"nees_" + name + "_mean", "1",
          "mean of the camera " + name +
              " error squared, normalised by its covariance, from the first planned motion on; 3 is "
              "expected",
          largest, kHeadline},
         [part = part](const Scored& s) { return nees_mean(s, part); }});
    rows.push_back({{"nees_" + name + "_variance", "1",
                     "variance of that normalised square over the frames; 6 is expected", largest},
                    [part = part](const Scored& s) { return nees_variance(s, part); }});
    rows.push_back({{"nees_" + name + "_within_95", "1",
                     "part of the frames whose normalised square is within the 95 % of a chi-square of 3 "
                     "degrees of freedom, 7.81; 0.95 is expected",
                     smallest},
                    [part = part](const Scored& s) { return nees_within(s, part); }});
  }
}

void add_nis(Rows& rows) {
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) {
    const std::string name(kSensors[sensor]), of = " of the " + name + " innovations";
    const auto add = [&](const std::string& what, const std::string& words, auto part, Worst worst) {
      rows.push_back({{"nis_" + name + "_" + what, "1", words, worst},
                      [sensor, part](const Scored& s) { return innovations(s, sensor, part); }});
    };
    using S = const InnovationSummary&;
    add(
        "mean",
        "mean normalised square" + of +
            " by their degrees of freedom, from the first planned motion on; "
            "1 is expected",
        [](S s) { return s.ratio; }, largest);
    add(
        "band_low", "lower end of where the mean" + of + " is with 95 % confidence if they are as expected",
        [](S s) { return s.band.low; }, smallest);
    add(
        "band_high", "upper end of that band", [](S s) { return s.band.high; }, largest);
    add(
        "variance", "variance" + of + "' normalised squares by that of their chi-square; 1 is expected",
        [](S s) { return s.variance_ratio; }, largest);
    add(
        "whiteness", "correlation" + of + "' normalised squares from one frame to the next; 0 is expected",
        [](S s) { return s.whiteness; }, largest_magnitude);
  }
}

void add_map(Rows& rows) {
  const std::string error =
      " distance of the final map's landmarks from where the ray through their first pixel, from the true "
      "camera, meets the room";
  rows.push_back({{"landmark_rmse_m", "m", "root mean square" + error, largest}, landmark_rmse});
  rows.push_back({{"landmark_median_m", "m", "median" + error, largest}, landmark_median});
  rows.push_back(
      {{"landmark_nees_mean", "1",
        "mean of those errors squared, normalised by the landmarks' covariances; 3 is expected", largest},
       landmark_nees});
  rows.push_back(
      {{"landmarks_scored", "1", "landmarks of the final map that those errors are taken over", smallest},
       landmarks_scored});
}

void add_completion(Rows& rows) {
  rows.push_back({{"path_length_m", "m",
                   "length of the true camera's path, from frame to frame, from the first planned motion on",
                   smallest, kHeadline},
                  true_path_length});
  rows.push_back(
      {{"walk_completion", "1", "part of the plan's time that was walked, up to the last frame", smallest},
       walk_completion});
  rows.push_back(
      {{"track_completion", "1",
        "part of the plan's time up to the last estimate; a filter that diverged gives none after that",
        smallest, kHeadline},
       track_completion});
}

}  // namespace

const std::vector<MetricRow>& metric_rows() {
  static const Rows rows = [] {
    Rows all;
    for (const auto add : {add_absolute, add_relative, add_end, add_walk, add_feet, add_loop, add_nees,
                           add_nis, add_map, add_completion})
      add(all);
    return all;
  }();
  return rows;
}

}  // namespace sim::score
