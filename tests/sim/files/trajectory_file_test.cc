#include "sim/files/trajectory_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using std::chrono::nanoseconds;
using testing::HasSubstr;

class TrajectoryFileTest : public testing::Test {
 protected:
  TrajectoryFile read(const std::string& text, const std::string& name = "poses.txt") const {
    write_text(folder_ / name, text);
    return read_trajectory(folder_ / name);
  }
  void expect_refused(const std::string& text, const std::string& why) const {
    try {
      read(text);
      ADD_FAILURE() << text;
    } catch (const FileError& e) {
      EXPECT_THAT(e.what(), HasSubstr("poses.txt" + why));
    }
  }
  const TemporaryFolder folder_;
};

TEST_F(TrajectoryFileTest, TumInSecondsAndInNanosecondsAreTheSame) {
  const TrajectoryFile s =
      read("# a comment\n1403636579.763555584 1 2 3 0 0 0 1\n1403636580 4 5 6 0 0 1 0\n");
  const TrajectoryFile ns =
      read("1403636579763555584 1 2 3 0 0 0 1\n1403636580000000000.000 4 5 6 0 0 1 0\n");
  EXPECT_EQ(s.stamps, "seconds");
  EXPECT_EQ(ns.stamps, "nanoseconds");
  for (const TrajectoryFile& file : {s, ns}) {
    EXPECT_EQ(file.format, "TUM");
    ASSERT_EQ(file.rows.size(), 2u);
    EXPECT_EQ(file.rows[0].t, nanoseconds(1403636579763555584));
    EXPECT_EQ(file.rows[1].t, nanoseconds(1403636580000000000));
    EXPECT_EQ(file.rows[1].X.translation(), Eigen::Vector3d(4, 5, 6));
    EXPECT_NEAR(file.rows[1].X.linear()(0, 0), -1, 1e-15);  // half a turn about z
  }
}

TEST_F(TrajectoryFileTest, NanosecondsFromZeroOnAreToldByTheirSteps) {
  const TrajectoryFile file = read("0 1 2 3 0 0 0 1\n33000000 1 2 3 0 0 0 1\n67000000 1 2 3 0 0 0 1\n");
  EXPECT_EQ(file.stamps, "nanoseconds");
  EXPECT_EQ(file.rows[2].t, std::chrono::milliseconds(67));
}

TEST_F(TrajectoryFileTest, CovarianceIsReadWhereThereIsOne) {
  const TrajectoryFile file = read("0 0 0 0 0 0 0 1 1 2 3 4 5 6 7 8 9 10 11 12\n1 0 0 0 0 0 0 1\n");
  EXPECT_EQ(file.format, "TUM with covariance");
  ASSERT_TRUE(file.rows[0].covariance);
  EXPECT_EQ((*file.rows[0].covariance)(1, 2), 5);
  EXPECT_EQ((*file.rows[0].covariance)(5, 3), 9);
  EXPECT_FALSE(file.rows[1].covariance);
}

TEST_F(TrajectoryFileTest, TheFirstPoseMayBeWithoutTheCovarianceThatOthersHave) {
  const TrajectoryFile file = read("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1 1 2 3 4 5 6 7 8 9 10 11 12\n");
  EXPECT_EQ(file.format, "TUM with covariance");
  EXPECT_FALSE(file.rows[0].covariance);
  ASSERT_TRUE(file.rows[1].covariance);
  EXPECT_EQ((*file.rows[1].covariance)(1, 2), 5);
}

TEST_F(TrajectoryFileTest, EurocHasTheQuaternionsRealPartFirst) {
  const TrajectoryFile file = read("#timestamp, p_RS_R_x [m]\n1000000000000000000,1,2,3,0,1,0,0,9,9\n");
  EXPECT_EQ(file.format, "EuRoC csv");
  EXPECT_EQ(file.stamps, "nanoseconds");
  EXPECT_EQ(file.rows[0].t, nanoseconds(1000000000000000000));
  EXPECT_NEAR(file.rows[0].X.linear()(1, 1), -1, 1e-15);  // half a turn about x
  EXPECT_EQ(read("0.5, 1, 2, 3, 1, 0, 0, 0\n").rows[0].t, std::chrono::milliseconds(500));
}

TEST_F(TrajectoryFileTest, KittiHasTimesBesideItOrNone) {
  const std::string poses = "1 0 0 4 0 1 0 5 0 0 1 6\n0 -1 0 7 1 0 0 8 0 0 1 9\n";
  EXPECT_EQ(read(poses).stamps, "frame numbers");
  EXPECT_EQ(read(poses).rows[1].X.translation(), Eigen::Vector3d(7, 8, 9));
  EXPECT_NEAR(read(poses).rows[1].X.linear()(1, 0), 1, 1e-15);
  write_text(folder_ / "times.txt", "0.0\n1.25e-1\n");
  EXPECT_EQ(read(poses).stamps, "seconds");
  EXPECT_EQ(read(poses).rows[1].t, std::chrono::milliseconds(125));
  write_text(folder_ / "times.txt", "0.0\n");
  EXPECT_THROW(read(poses), FileError);
}

// As programs leave that lost their way at the end.
TEST_F(TrajectoryFileTest, ARepeatedLastStampIsDroppedWithAWarningAndNoOther) {
  const std::string two = "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n";
  const TrajectoryFile dropped = read(two + "2 5 0 0 0 0 0 1\n");
  EXPECT_EQ(dropped.rows.size(), 2u);
  EXPECT_EQ(dropped.rows[1].X.translation().x(), 0);
  EXPECT_EQ(dropped.warning, "its last pose has the stamp of the one before and is left out");
  EXPECT_EQ(read(two).warning, "");
  EXPECT_EQ(
      read("1000000000,0,0,0,1,0,0,0\n1000000033,0,0,0,1,0,0,0\n1000000033,0,0,0,1,0,0,0\n").rows.size(), 2u);
  expect_refused(two + "2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n", ":3:1: the stamp is not after the one before");
  expect_refused(two + "1.5 0 0 0 0 0 0 1\n", ":3:1: the stamp is not after the one before");
}

TEST_F(TrajectoryFileTest, WhatIsNoTrajectorySaysWhereAndWhy) {
  expect_refused("", ": has no pose in it");
  expect_refused("# nothing\n\n", ": has no pose in it");
  expect_refused("1 2 3\n", ":1: has 3 numbers, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC)");
  expect_refused("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", ":2: expected 8 numbers, found 7");
  expect_refused("0 0 0 x 0 0 0 1\n", ":1:7: expected a finite number, found \"x\"");
  expect_refused("0 0 0 0 0 0 0 2\n", ":1:9: the quaternion is not of length 1");
  expect_refused("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", ":2:1: the stamp is not after the one before");
  expect_refused("2 0 0 4 0 1 0 5 0 0 1 6\n", ":1:1: the first three columns are no rotation");
  expect_refused("1,2,3\n", ":1: expected at least 8 numbers, found 3");
  EXPECT_THROW(read_trajectory(folder_ / "none.txt"), FileError);
  EXPECT_THROW(read_trajectory(folder_.path()), FileError);
}

}  // namespace
}  // namespace sim::files
