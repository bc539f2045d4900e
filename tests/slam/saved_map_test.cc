#include "slam/filter.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

/// A walk that turns by 65 degrees, and the map of a filter that walked it.
const synthetic::Recording& walk() {
  static const synthetic::Recording recording = synthetic::recorded(5, 0.18, 15);
  return recording;
}

Filter filter_at(const Eigen::Isometry3d& X_WC) { return {Options{}, synthetic::calibration(), X_WC, 1}; }

const SavedMap& first_map() {
  static const SavedMap map = [] {
    Filter filter = filter_at(walk().walk().X_WC(0));
    for (int k = 0; k < walk().walk().frames(); ++k) filter.step(walk().observation(k));
    return filter.saved_map().value();
  }();
  return map;
}

struct Session {
  std::optional<int> found, refused;  ///< first frame
  double largest_error_m = 0;         ///< while the map is found
  int reused = 0, accepted = 0;       ///< matches
  int lost = 0;                       ///< frames, after the map was found
  std::optional<SavedMap> map;
};

/// A second session with other noise. told_by: moves the told start away from the true one.
Session second_session(
    const SavedMap& map, MapStart start, const Eigen::Isometry3d& told_by,
    const std::function<void(Observation&)>& change = [](Observation&) {}) {
  Session session;
  Filter filter = filter_at(told_by * walk().walk().X_WC(0));
  filter.start_from(map, start);
  for (int k = 0; k < walk().walk().frames(); ++k) {
    Observation o = walk().observation(k);
    change(o);
    const FrameReport& report = filter.step(o);
    if (!o.image.empty()) EXPECT_EQ(report.health == Health::lost, report.map == MapUse::searching) << k;
    EXPECT_EQ(filter.saved_map().has_value(), report.map != MapUse::searching) << k;
    if (report.map == MapUse::refused && !session.refused) session.refused = k;
    if (report.map != MapUse::found) continue;
    if (!session.found) session.found = k;
    if (report.health == Health::lost) ++session.lost;
    const Eigen::Isometry3d X_WC = walk().walk().X_WC(seconds(o.t));
    session.largest_error_m =
        std::max(session.largest_error_m, (filter.estimate().X_WC.translation() - X_WC.translation()).norm());
    for (const Sighting& match : report.matched) {
      session.reused += match.landmark <= map.landmarks.back().id ? 1 : 0;
      ++session.accepted;
    }
  }
  session.map = filter.saved_map();
  return session;
}

Eigen::Isometry3d turned(double yaw, double x) { return pose(yaw, {0, 0, 1}, {x, 0, 0}); }

TEST(SavedMap, HasEachLandmarkWithItsCovarianceAndLoadsWithMoreOfIt) {
  const SavedMap& map = first_map();
  ASSERT_GT(map.landmarks.size(), 10U);
  Map loaded(Options{}, Camera(map.camera), 1);
  Kalman kalman({looking_ahead(), RobotMatrix::Identity()}, true);
  loaded.load(map, kalman);
  const SavedMap again = loaded.saved(kalman.state());
  EXPECT_EQ(again.sessions, 2);
  EXPECT_EQ(again.x, map.x);
  const Eigen::MatrixXd added = again.P - map.P;
  EXPECT_GE(added.diagonal().minCoeff(), 0);
  EXPECT_EQ((added.array() != 0).rowwise().any().count(), (added.diagonal().array() > 0).count());
  for (const Landmark& l : again.landmarks) {
    EXPECT_GT(added.diagonal().segment(l.at, l.size()).maxCoeff(), 0) << "0.2 px at its distance";
    EXPECT_EQ(l.initialized, kEarlierSession);
  }
  // the yaw of the whole map is not observable
  const auto null_yaw = kalman.state().null_yaw();
  const Landmark& last = loaded.landmarks().back();
  EXPECT_EQ(null_yaw.segment<2>(last.at), Eigen::Vector2d(-again.x(again.x.size() - last.size() + 1),
                                                          again.x(again.x.size() - last.size())));
  EXPECT_TRUE(kalman.is_valid(kalman.state().size));
}

TEST(SavedMap, IsUpdatedInTheSecondSessionAndConsideredFromTheThirdOn) {
  for (const int sessions : {1, 2}) {
    SavedMap map = first_map();
    map.sessions = sessions;
    Map loaded(Options{}, Camera(map.camera), 1);
    Kalman kalman({looking_ahead(), RobotMatrix::Identity()}, true);
    loaded.load(map, kalman);
    loaded.consider_known(Stamp(0), kalman);
    EXPECT_EQ(kalman.considers(loaded.landmarks().front().at), sessions == 2);
    EXPECT_EQ(kalman.considers(loaded.landmarks().back().at), sessions == 2);
  }
}

TEST(SavedMap, ASecondSessionFindsItselfFromAKnownARoughAndAnUnknownStart) {
  const Eigen::Isometry3d away = turned(2.2, 3);
  for (const auto& [start, told_by, latest] : {std::tuple{MapStart::known, turned(0.04, 0.04), 2},
                                               {MapStart::rough, turned(0.3, 0.4), 8},
                                               {MapStart::unknown, away, 40}}) {
    const Session session = second_session(first_map(), start, told_by);
    ASSERT_TRUE(session.found) << static_cast<int>(start);
    EXPECT_LE(*session.found, latest) << static_cast<int>(start);
    EXPECT_LT(session.largest_error_m, 0.06);  // the map's error is 2 cm, and the first pose's as much
    EXPECT_GT(session.reused, session.accepted / 2);
    EXPECT_EQ(session.map->sessions, 2);
  }
  EXPECT_FALSE(second_session(first_map(), MapStart::rough, away).found) << "contradicts the told start";
}

TEST(SavedMap, LandmarksThatMovedTogetherDoNotMoveThePose) {
  for (const Eigen::Vector3d& moved : {Eigen::Vector3d(0, 0.15, 0), Eigen::Vector3d(0, 0, 0.15)}) {
    SavedMap map = first_map();
    for (std::size_t i = 0; i < map.landmarks.size(); i += 3) map.x.segment<3>(map.landmarks[i].at) += moved;
    const Session session = second_session(map, MapStart::known, turned(0, 0));
    ASSERT_TRUE(session.found);
    EXPECT_LT(session.largest_error_m, 0.06) << "0.17 if they count in the first update";
  }
}

TEST(SavedMap, IsRefusedInAnotherPlaceOnceTheCameraHasTurnedBy60DegreesAndANewMapStarts) {
  const Session session = second_session(first_map(), MapStart::unknown, turned(0, 0), [](Observation& o) {
    cv::flip(o.image, o.image, 1);  // a mirrored room
  });
  EXPECT_FALSE(session.found);
  ASSERT_TRUE(session.refused);
  EXPECT_NEAR(*session.refused, 68, 5);  // of 75 frames, in which the walk turns by 65 degrees
  EXPECT_EQ(session.map->sessions, 1);
}

/// The map of a room that looks the same after half a turn.
SavedMap point_symmetric_map() {
  SavedMap map;
  map.sessions = 1, map.camera = first_map().camera;
  const Eigen::Isometry3d half_turn = turned(std::numbers::pi, 1);
  std::vector<Eigen::Vector3d> p_W;
  for (const Landmark& original : first_map().landmarks) {
    const Eigen::Vector3d p = position(original.kind, first_map().x.segment(original.at, original.size()));
    for (const Eigen::Isometry3d& X : {Eigen::Isometry3d::Identity(), half_turn}) {
      Landmark& landmark = map.landmarks.emplace_back(original);
      landmark.kind = Point{}, landmark.id = static_cast<int>(p_W.size()), landmark.at = 3 * landmark.id;
      landmark.X_WC_first = X * original.X_WC_first;
      p_W.push_back(X * p);
    }
  }
  map.x = Eigen::Map<const Eigen::VectorXd>(p_W[0].data(), 3 * std::ssize(p_W));
  map.P = 1e-4 * Eigen::MatrixXd::Identity(map.x.size(), map.x.size());
  return map;
}

TEST(SavedMap, InAPointSymmetricRoomOnlyAToldStartDecides) {
  const SavedMap map = point_symmetric_map();
  EXPECT_TRUE(second_session(map, MapStart::known, turned(0, 0)).found);
  EXPECT_FALSE(second_session(map, MapStart::unknown, turned(0, 0)).found);
}

TEST(SavedMap, InAPointSymmetricRoomAFilterThatTrackedKnowsItsPoseAfterALoss) {
  const Session session =
      second_session(point_symmetric_map(), MapStart::known, turned(0, 0), [&](Observation& o) {
        if (seconds(o.t) > 1 && seconds(o.t) < 3.5) o.image.release();
      });
  EXPECT_GT(session.lost, 0);
  EXPECT_GT(session.accepted, 400) << "also after the loss";
  EXPECT_LT(session.largest_error_m, 0.15) << "the other pose is 1 m or more away";
}

}  // namespace
}  // namespace slam
