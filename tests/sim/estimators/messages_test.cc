#include "sim/estimators/messages.h"

#include "tests/sim/scenario/test_scenarios.h"

namespace sim::estimators {
namespace {

/// The number at a byte offset of a message, read as any language would.
template <class Number>
Number at(const std::string& message, std::size_t byte) {
  Number number;
  std::memcpy(&number, message.data() + byte, sizeof number);
  return number;
}

/// Compares words or numbers starting at byte `begin`.
template <class Number>
void expect_at(const std::string& payload, std::size_t begin, const std::map<std::size_t, Number>& expected) {
  for (const auto& [byte, number] : expected) EXPECT_EQ(at<Number>(payload, begin + byte), number) << byte;
}
const auto expect_words = expect_at<std::uint32_t>;
const auto expect_numbers = expect_at<double>;

TEST(Messages, TheStartHasTheLayoutInTheReadme) {
  Start start;
  start.calibration.camera.lens = slam::Equidistant{0.1, 0.2, 0.3, 0.4};
  start.calibration.X_CG.translation() << 7, 8, 9;
  start.X_WC.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  start.seed = 0x1122334455667788;
  programs::Choice choice;
  choice.options = {{"threads", "2"}, {"map.size", "big"}};
  const std::string message = start_message(choice, start), options = "threads=2\nmap.size=big\n";
  ASSERT_EQ(message.size(), 16 + 288 + 24 + 16 + 360 + 200);  // 24: the options and a zero byte
  EXPECT_EQ(message.substr(0, 4), "GSLM");
  EXPECT_EQ(message[4], 1);
  EXPECT_EQ(at<std::uint64_t>(message, 8), message.size() - 16);
  const std::string payload = message.substr(16);
  const slam::CameraIntrinsics& camera = start.calibration.camera;
  expect_words(payload, 0, {{0, 4}, {4, 2}, {8, 320}, {12, 240}});  // 4: equidistant
  expect_numbers(payload, 0, {{16, camera.fu_px}, {40, camera.v0_px}, {72, 0.4}});
  expect_numbers(payload, 80, {{72, 7}, {96 + 8, -std::sin(0.5)}});  // first row, second column
  EXPECT_EQ(payload[272], '\x88');                                   // least byte first
  EXPECT_EQ(at<std::uint64_t>(payload, 280), options.size());
  EXPECT_EQ(payload.substr(288, 24), options + std::string(1, '\0'));
}

/// The sensors of the preset d435i_mid360, each i / 10 m to the right of the head's camera.
std::vector<rig::RigSensor> rig_sensors() {
  const std::vector<rig::Item> items = *rig::preset("d435i_mid360");
  std::vector<Eigen::Isometry3d> X_CL(items.size(), rig::camera_from_forward_left_up());
  for (std::size_t i = 0; i < items.size(); ++i) X_CL[i].translation().x() = 0.1 * double(i);
  return rig::calibrated(items, slam::CameraIntrinsics{}, 30, 0.01, X_CL);
}

TEST(Messages, TheSensorListsHaveTheLayoutInTheReadme) {
  Start start;
  start.rig = rig_sensors();
  start.calibration.X_CG.translation().z() = -0.4;
  start.camera_readout_s = 0.01;
  start.chest_imu.gyro_sigma_rad_s = 0.02, start.chest_imu.gyro_bias_walk_rad_s2 = 0.003;
  start.chest_imu.time_offset_s = 0.004;
  start.joints = {"HIP", "KNEE"};
  const std::string payload = start_message({}, start).substr(16);
  constexpr std::size_t kCounts = 288 + 8, kCameras = kCounts + 16, kImus = kCameras + 4 * 360,
                        kLidars = kImus + 2 * 200, kBody = kLidars + 192;
  ASSERT_EQ(payload.size(), kBody + 4 * 64);
  EXPECT_EQ(payload.substr(288, 8), std::string(8, '\0'));
  expect_words(payload, kCounts, {{0, 4}, {4, 2}, {8, 1}, {12, 4}});
  expect_words(payload, kBody + 64, {{48, GAITSLAM_ENCODER}, {52, 1}});
  expect_words(payload, kBody + 2 * 64, {{48, GAITSLAM_FORCE_SENSOR}, {52, 6}});
  std::string names;
  for (unsigned i = 0; i < 4; ++i) {
    const std::size_t camera = kCameras + i * 360;
    names += std::string(payload.data() + camera) + " ";
    const auto width = static_cast<unsigned>(i == 2 ? start.rig[1].camera.width_px : 320);
    expect_words(payload, camera,
                 {{48, i < 2 ? 0 : i - 1}, {52, i == 3 ? 0 : i}, {56, width}});  // 3: of cam0
    expect_words(payload, camera,
                 {{64, GAITSLAM_LENS_ONE_PARAMETER_RADIAL}, {136, GAITSLAM_LENS_EQUIDISTANT}});
  }
  EXPECT_EQ(names, "cam0 cam1 rgb0 depth0 ");
  expect_numbers(payload, kCameras, {{72, 197}, {104, 7.37e-6}, {320, 30}, {328, 0.01}});
  expect_numbers(payload, kCameras + 360, {{296, 0.05}});  // the baseline
  expect_numbers(payload, kCameras + 3 * 360, {{344, 0.3}, {352, 10}});
  expect_numbers(payload, kImus, {{48 + 88, -0.4}, {144, 200}, {152, 0.02 / std::sqrt(200)}, {168, 0.003}});
  expect_numbers(payload, kImus, {{184, 9.81}, {192, 0.004}, {200 + 152, 1e-3 / std::sqrt(200)}});
  expect_numbers(payload, kLidars, {{48 + 72, 0.4}, {144, 10}, {168, 40}});
  expect_numbers(payload, kBody, {{3 * 64 + 56, 200}});
  EXPECT_STREQ(payload.data() + kBody + 64, "KNEE");
}

TEST(Messages, AnObservationHasTheLayoutInTheReadme) {
  slam::Observation o;
  o.t = std::chrono::nanoseconds(123456789);
  cv::Mat wide(240, 400, CV_8UC1, cv::Scalar(1));
  wide(cv::Rect(319, 239, 1, 1)) = 99;
  o.image = wide(cv::Rect(0, 0, 320, 240));  // its rows do not adjoin
  o.gyro = {{slam::Stamp(1), slam::Stamp(2), {1, 2, 3}}, {slam::Stamp(2), slam::Stamp(5), {4, 5, 6}}};
  o.accelerometer = {{slam::Stamp(1), slam::Stamp(2), {0, 0, 9.81}}};
  o.plan.emplace();
  o.plan->v_PC_C << 0.1, 0.2, 0.3;
  o.plan->w_PC_C.y() = 0.7, o.plan->p_CF.x() = 0.8;
  o.plan->support = slam::Support::right;
  o.legs.emplace().p_CS << 0.4, 0.5, 0.6;
  o.command = slam::CommandedVelocity{slam::Stamp(77), 0.9, 0, 1.1};
  std::string payload = observation_message(o, {}).substr(16);
  ASSERT_EQ(payload.size(), 368U + 3 * 40 + 320 * 240 + 16 + 40);  // counts, and the image's description
  payload.resize(payload.size() - 56);
  EXPECT_EQ(at<std::int64_t>(payload, 0), 123456789);
  expect_words(payload, 0, {{8, 320}, {16, 2}, {20, 1}, {24, 1}, {28, 1}, {32 + 168, 2}, {328, 1}});
  expect_numbers(payload, 32,
                 {{0, 1}, {96, 0.1}, {120 + 8, 0.7}, {144, 0.8}, {176, 1}});  // 0: of the identity
  EXPECT_EQ(at<std::int64_t>(payload, 336), 77);
  expect_numbers(payload, 304, {{16, 0.6}, {40, 0.9}, {56, 1.1}});
  expect_numbers(payload, 368, {{40 + 16, 4}, {80 + 32, 9.81}});
  EXPECT_EQ(payload.back(), 99);
}

TEST(Messages, MissingDataTakesNoBytes) {
  EXPECT_EQ(observation_message({}, {}).substr(16), std::string(368 + 16, '\0'));
  EXPECT_EQ(programs::message(programs::Message::end, {}), std::string("GSLM\5\0\0\0\0\0\0\0\0\0\0\0", 16));
}

TEST(Messages, AnAnswerIsReadBackBitForBit) {
  gaitslam_answer words{};
  words.t_ns = 33;
  words.status = GAITSLAM_DIVERGED;
  words.has_covariance = 1;
  words.X_WC.rotation[5] = 1.0 / 3;
  words.X_WC.translation_m[2] = 1.0 / 7;
  words.covariance[6] = 0.125;
  words.landmark_count = 2;
  words.cause_bytes = 4;
  gaitslam_landmark landmarks[2]{};
  landmarks[1].id = 9;
  landmarks[1].has_covariance = 1;
  landmarks[1].covariance[5] = 0.25;
  std::string payload(reinterpret_cast<const char*>(&words), sizeof words);
  payload.append(reinterpret_cast<const char*>(landmarks), sizeof landmarks);
  const Answer answer = read_answer(payload + "d\nrk");
  EXPECT_EQ(answer.estimate->t.count(), 33);
  EXPECT_EQ(answer.report.health, slam::Health::diverged);
  EXPECT_EQ(answer.report.cause, "d rk");
  EXPECT_EQ(answer.estimate->X_WC.linear()(1, 2), 1.0 / 3);
  EXPECT_EQ(answer.estimate->X_WC.translation().z(), 1.0 / 7);
  EXPECT_EQ((*answer.estimate->covariance)(1, 0), 0.125);
  ASSERT_EQ(answer.map.value().size(), 2U);
  EXPECT_EQ((*answer.map)[1].id, 9);
  EXPECT_EQ((*answer.map)[1].covariance(1, 2), 0.25);
}

programs::Choice choice_of(const std::string& value) {
  return scenario::read_text(scenario::kAll, {{"estimator=" + value}, {}}).scenario.estimator;
}

TEST(EstimatorKey, NamesAProgramWithItsOptions) {
  const programs::Choice choice = choice_of(
      "{program: [bin/my slam, --stdio], options: {a: {b: 1, c: yes}, d: 'e f'}, answer_within_s: 2.5}");
  EXPECT_EQ(choice.source, programs::Source::program);
  EXPECT_EQ(choice.name, "my_slam");
  EXPECT_EQ(choice.words, (std::vector<std::string>{"bin/my slam", "--stdio"}));
  EXPECT_EQ(options_text(choice), "a.b=1\na.c=yes\nd=e f\n");
  EXPECT_EQ(choice.answer_within_s, 2.5);
  EXPECT_EQ(choice.start_within_s, 60);
  EXPECT_EQ(choice_of("{program: /tmp/my_slam, name: mine}").name, "mine");
  for (const char* program :
       {"./vo.exe", "[/usr/bin/python3, -u, lib/vo.py, x.yaml]", "[env, A=b, python3.11, vo.py]",
        "[python, -m, vo]", "[nice, -n, 10, ./vo, --fast]"})
    EXPECT_EQ(choice_of(fmt::format("{{program: {}}}", program)).name, "vo") << program;
  EXPECT_EQ(choice_of("{command: 'bash -e run/vo.sh {folder} {trajectory}'}").name, "vo");
  EXPECT_EQ(choice_of("{program: [python3, -c, 'import slam']}").name, "python3");
  EXPECT_EQ(choice_of("{program: [./filter]}").name, "filter_external");
  EXPECT_EQ(choice_of("filter").source, programs::Source::built_in);
}

}  // namespace
}  // namespace sim::estimators
