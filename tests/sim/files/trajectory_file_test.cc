#include "sim/files/trajectory_file.h"

#include "sim/files/table.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using std::chrono::nanoseconds, testing::HasSubstr;

class TrajectoryFileTest : public testing::Test {
 protected:
  TrajectoryFile read(const std::string& text, const std::string& name = "poses.txt") const {
    write_text(folder_ / name, text);
    return read_trajectory(folder_ / name);
  }
  void expect_rejected(const std::string& text, const std::string& why) const {
    EXPECT_THAT(error_of([&] { read(text); }), HasSubstr("poses.txt" + why)) << text;
  }
  const TemporaryFolder folder_;
};

// Expects the common error: the first row, the expected formats, and a --columns to start from.
TEST_F(TrajectoryFileTest, WhatIsNotDeclaredIsRejectedWithItsFirstRowAndAStart) {
  const std::string row = "1403715273000000000,1,2,3,1,0,0,0\n";
  EXPECT_THAT(
      error_of([&] { read(row); }),
      testing::MatchesRegex(".*poses.txt:1: no header names the comma-separated columns .*; the first "
                            "row has 8 columns: 1403715273000000000,1,2,3,1,0,0,0; expected TUM .*: "
                            "--columns \"t.ns. x y z qw qx qy qz\""));
  expect_rejected("1 2 3 4\n",
                  ":1: no header names its columns; the first row has 4 columns: 1 2 3 4; expected");
  expect_rejected("1;2;3;4;0;0;0;1\n", ":1: no header names its columns");
  const std::string matrix = "17e17,1,0,0,1.5,0,1,0,2.5,0,0,1,3.5\n",
                    places = "t[ns] - - - x - - - y - - - z";
  EXPECT_THAT(error_of([&] { read(matrix); }), HasSubstr("--columns \"" + places + "\""));
  write_text(folder_ / "m.csv", matrix);
  EXPECT_EQ(read_trajectory(folder_ / "m.csv", places).rows[0].X.translation(),
            Eigen::Vector3d(1.5, 2.5, 3.5));
  expect_rejected("1403636579763555584 1 2 3 0 0 0 1\n",
                  ":1: the time 1403636579763555584 in its unit is more than 9e9 s; the first row");
  for (const auto& [header, why] : std::vector<std::pair<std::string, std::string>>{
           {"# timestamp(s) lat(deg) lon(deg) alt(m)\n1 48 11 500\n", ":2: no column contains the position"},
           {"# timestamp lat lon alt qx qy qz qw\n1 48 11 500 0 0 0 1\n",
            ":2: no column contains the position"},
           {"Saved by my slam\n5 1 2 3 0 0 0 1\n", ":2: its header names 4 columns, its rows have 8"},
           {"# x y z qw qx qy qz\n5 1 2 3 1 0 0 0\n", ":2: its header names 7 columns, its rows have 8"},
           {"x,y,z\n1,2,3\n", ":2: no column contains the stamp"},
           {"timestamp,tx,ty,tz,qx,qy,qz,qw\n5,1,2,3,0,0,0,1\n",
            ":2: column \"timestamp\" has no unit, expected one of s, ms, us, ns"},
           {"t[h],x,y,z\n5,1,2,3\n",
            ":2: column \"t\" has the unknown unit \"h\", expected one of s, ms, us, ns"},
           {"t[s],x[ft],y,z\n5,1,2,3\n",
            ":2: column \"x\" has the unknown unit \"ft\", expected one of m, cm, mm, km"},
           {"t[s],x,y,alt\n5,1,2,3\n", ":2: 2 of 3 columns of the position have a known name"},
           {"t[s],x,y,z,roll,pitch,qz,qw\n5,1,2,3,0,0,0,1\n", ":2: 2 of 4 columns of the orientation"},
           {"t[s],/a/position/x,/a/position/y,/a/position/z,/b/position/x\n5,1,2,3,4\n",
            ":2: two columns are the same part of the position"},
           {"t[s],x,y,z,Pr11\n5,1,2,3,4\n", ":2: 1 of 12 columns of the covariance"}})
    expect_rejected(header, why);
  EXPECT_THAT(error_of([&] { read("time,tx,ty,tz,qx,qy,qz,qw,v\n5,1,2,3,0,0,0,1,9\n"); }),
              testing::EndsWith(": --columns \"time[ns] tx ty tz qx qy qz qw -\""));
  EXPECT_THAT(error_of([&] { read_trajectory(folder_ / "m.csv", "t[s] lat y z"); }),
              HasSubstr("--columns: unknown name \"lat\", expected - for a column that is not used"));
  EXPECT_THAT(error_of([&] { read_trajectory(folder_ / "m.csv", places + " - -"); }),
              HasSubstr("--columns has 15 names"));
}

TEST_F(TrajectoryFileTest, NamedColumnsAreReadInAnyOrder) {
  for (const std::string text :
       {"t[s],tx,ty,tz,qx,qy,qz,qw\n5.0,1,2,3,0.6,0,0,0.8\n5.1,1,2,3,0.6,0,0,0.8\n",
        "Time[ms];qw;qx;qy;qz;px;py;pz\n5000;0,8;0,6;0;0;1;2;3\n5100;0,8;0,6;0;0;1;2;3\n",
        "t[us]\tx[cm]\ty[cm]\tz[cm]\tqx\tqy\tqz\tqw\n5e6\t100\t200\t300\t0,6\t0\t0\t0,8\n"
        "5.1e6\t100\t200\t300\t0,6\t0\t0\t0,8\n",
        "# timestamp tx ty tz qw qx qy qz\n# made by hand, in a day\n5.0 1 2 3 0.8 0.6 0 0\n5.1 1 2 3 0.8 "
        "0.6 0 0\n",
        "\xef\xbb\xbf# time [s] x [mm] y [mm] z [mm] q_x q_y q_z q_w\r\n5.0 1000 2000 3000 0.6 0 0 0.8\r\n"
        "5.1 1000 2000 3000 0.6 0 0 0.8\r\n",
        "\"t[s]\",x[km],y[km],z[km],qw,qx,qy,qz,goal_x\n5,0.001,0.002,0.003,0.8,0.6,0,0,7\n"
        "5.1,\"0.001\",0.002,0.003,0.8,0.6,0,0,7\n",
        "__time,/odom/pose/pose/position/x,/odom/pose/pose/position/y,/odom/pose/pose/position/z,"
        "/odom/pose/pose/orientation/x,/odom/pose/pose/orientation/y,/odom/pose/pose/orientation/z,"
        "/odom/pose/pose/orientation/w\n5,1,2,3,0.6,0,0,0.8\n5.1,1,2,3,0.6,0,0,0.8\n",
        "%time,field.header.stamp,field.pose.position.x,field.pose.position.y,field.pose.position.z,"
        "field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation."
        "w\n"
        "7,5000000000,1,2,3,0.6,0,0,0.8\n8,5100000000,1,2,3,0.6,0,0,0.8\n",
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
        "5000000000,1,2,3,0.8,0.6,0,0\n5100000000,1,2,3,0.8,0.6,0,0"}) {
    const TrajectoryFile file = read(text);
    ASSERT_EQ(file.rows.size(), 2u) << text;
    EXPECT_EQ(file.rows[1].t, std::chrono::milliseconds(5100)) << text;
    EXPECT_LT((file.rows[1].X.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12) << text;
    EXPECT_NEAR(Eigen::Quaterniond(file.rows[1].X.linear()).x(), 0.6, 1e-12) << text;
    write_text(folder_ / "named.txt", text);
    std::string names;
    for (const std::string& name : file.columns) names += name + " ";
    EXPECT_EQ(read_trajectory(folder_ / "named.txt", names).rows[1].t, file.rows[1].t) << names;
  }
  write_text(folder_ / "a.txt", "5000,9,1,2,3\n");
  const TrajectoryFile declared = read_trajectory(folder_ / "a.txt", "t[ms] - x[mm] -y[mm] z[mm]");
  EXPECT_EQ(declared.rows[0].t, std::chrono::seconds(5));
  EXPECT_EQ(declared.rows[0].X.translation(), Eigen::Vector3d(0.001, -0.002, 0.003));
  EXPECT_FALSE(declared.has_orientation);
}

TEST_F(TrajectoryFileTest, AStampMayHaveTwoColumns) {
  for (const char* names : {"secs,nsecs", "header.stamp.sec,header.stamp.nanosec"})
    EXPECT_EQ(read(names + std::string(",x,y,z\n1403636579,9,1,2,3\n")).rows[0].t,
              nanoseconds(1403636579'000'000'009))
        << names;
  expect_rejected("secs,nsecs,x,y,z\n5,1000000000,1,2,3\n", ":2:3: expected whole seconds, and whole nano");
  expect_rejected("secs,nsecs,x,y,z\n5.5,1,1,2,3\n", ":2:5: expected whole seconds");
  expect_rejected("nsecs,x,y,z\n5,1,2,3\n", ":2: 1 of 2 columns of the stamp");
}

TEST_F(TrajectoryFileTest, ProseInACommentIsNotAHeader) {
  for (const char* comment : {"# Time stamps of each pose follow", "# time in s and position in m",
                              "# file: x, seed 1", "# made by hand of 8 words in all today"})
    EXPECT_EQ(read(std::string(comment) + "\n1 2 3 4 0 0 0 1\n2 2 3 4 0 0 0 1\n").rows.size(), 2u) << comment;
}

TEST_F(TrajectoryFileTest, APoseMayLackTheCovarianceThatOthersHave) {
  const std::string without = " 0 0 0 0 0 0 1\n", with = " 0 0 0 0 0 0 1 1 2 3 4 5 6 7 8 9 10 11 12\n";
  for (const std::size_t which : {0u, 1u}) {
    const TrajectoryFile file =
        read("0" + (which == 0 ? with : without) + "1" + (which == 1 ? with : without));
    ASSERT_TRUE(file.rows[which].covariance);
    EXPECT_EQ((*file.rows[which].covariance)(1, 2), 5);
    EXPECT_EQ((*file.rows[which].covariance)(5, 3), 9);
    EXPECT_FALSE(file.rows[1 - which].covariance);
  }
  const TrajectoryFile named =
      read("# timestamp tx ty tz qx qy qz qw Pt11 Pt12 Pt13 Pt22 Pt23 Pt33 Pr11 Pr12 Pr13 Pr22 Pr23 Pr33\n0" +
           with);
  EXPECT_EQ((*named.rows[0].covariance)(4, 5), 5) << "positions come first";
  EXPECT_EQ((*named.rows[0].covariance)(0, 2), 9);
}

TEST_F(TrajectoryFileTest, LinesOfALostProgramAreLeftOutWithAWarning) {
  const TrajectoryFile lost = read("1 1 2 3 0 0 0 1\n2 nan nan nan nan nan nan nan\n3 1 2 3 0 0 0 1\n");
  EXPECT_EQ(lost.rows.size(), 2u);
  EXPECT_EQ(lost.warning, "1 line without a position skipped");
  expect_rejected(std::string("\x1f\x8b\x08\0", 4), ": is compressed, binary, UTF-16 or UTF-32");
}

TEST_F(TrajectoryFileTest, KittiHasTimesInASeparateFileOrNone) {
  const std::string poses = "1 0 0 4 0 1 0 5 0 0 1 6\n0 -1 0 7 1 0 0 8 0 0 1 9\n";
  EXPECT_TRUE(read(poses).counts_frames);
  EXPECT_EQ(read(poses).rows[1].X.translation(), Eigen::Vector3d(7, 8, 9));
  EXPECT_NEAR(read(poses).rows[1].X.linear()(1, 0), 1, 1e-15);
  write_text(folder_ / "times.txt", "0.0\n1.25e-1\n");
  EXPECT_FALSE(read(poses).counts_frames);
  EXPECT_EQ(read(poses).rows[1].t, std::chrono::milliseconds(125));
  write_text(folder_ / "times.txt", "0.0\n");
  EXPECT_THROW(read(poses), FileError);
}

TEST_F(TrajectoryFileTest, OnlyARepeatedLastStampIsDroppedWithAWarning) {
  const std::string two = "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n";
  const TrajectoryFile dropped = read(two + "2 5 0 0 0 0 0 1\n");
  EXPECT_EQ(dropped.rows.size(), 2u);
  EXPECT_EQ(dropped.rows[1].X.translation().x(), 0);
  EXPECT_EQ(dropped.warning, "its last pose repeats the previous stamp and is skipped");
  EXPECT_EQ(read(two).warning, std::nullopt);
  expect_rejected(two + "2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n",
                  ":3:1: the stamp is not after the previous one");
  expect_rejected(two + "1.5 0 0 0 0 0 0 1\n", ":3:1: the stamp is not after the previous one");
}

TEST_F(TrajectoryFileTest, ErrorsNamePlaceAndReason) {
  for (const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
           {"", ": contains no pose"},
           {"# nothing\n\n", ": contains no pose"},
           {"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", ":2: expected 8 numbers, found 7"},
           {"2 0 0 4 0 1 0 5 0 0 1 6\n", ":1:1: the first three columns are not a rotation"},
           {"# c\n0 0 0 x 0 0 0 1\n", ":2:7: expected a finite number, found \"x\""},
           {"0 0 0 nan 0 0 0 1\n", ":1:7: expected a finite number"},
           {"0 0 0 0 0 0 0 1\n1 1 1e308 1 0 0 0 1\n", ":2:5: a position of more than 1e9 m"},
           {"1 0 0 0 0 1 0 0 0 0 1 1e12\n", ":1:23: a position of more than 1e9 m"},
           {"0 0 0 0 0 0 0 0\n",
            ":1:9: the quaternion has length 0, expected 1; to read only positions: "
            "--columns \"t[s] x y z\""},
           {"1 nan nan nan 0 0 0 1\n", ": contains no pose: every position is missing or NaN"}})
    expect_rejected(text, why);
  EXPECT_THROW(read_trajectory(folder_ / "none.txt"), FileError);
}

TEST(Tum, ARowFollowsTheFormat) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  EXPECT_EQ(tum_row(nanoseconds(1'033'000'001), X), "1.033000001 0 0 0 0 0 0 1\n");
  EXPECT_EQ(tum_row(nanoseconds(-5), X).substr(0, 13), "-0.000000005 ");
  EXPECT_EQ(tum_row(nanoseconds(-1'500'000'000), X).substr(0, 13), "-1.500000000 ");
  X.translation() = Eigen::Vector3d(1, -2.5, 0.125);
  X.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_THAT(tum_row(nanoseconds(0), X), HasSubstr("0.000000000 1 -2.5 0.125 0 0 1 "));
}

TEST(Tum, RowsAreReadBackWithExactStampsAndPosesUpToRounding) {
  const TemporaryFolder folder;
  std::vector<TimedPose> poses;
  std::string text = "# a comment\n\n";
  for (int i = 0; i < 50; ++i) {
    Eigen::Isometry3d X(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(0.1, 0.2, 1).normalized()));
    X.translation() = Eigen::Vector3d(std::cos(i), 1e-9 * i, i / 3.0);
    poses.push_back({nanoseconds(1'403'636'579'763'555'584 + 33'333'333 * i), X});
    text += tum_row(poses.back().t, poses.back().X);
  }
  write_text(folder / "a.tum", text);
  const std::vector<TumRow> read = read_tum(folder / "a.tum");
  ASSERT_EQ(read.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(read[i].t, poses[i].t);
    EXPECT_EQ(read[i].X.translation(), poses[i].X.translation());
    EXPECT_TRUE(read[i].X.linear().isApprox(poses[i].X.linear(), 1e-14));  // through a quaternion and back
    EXPECT_FALSE(read[i].covariance);
  }
  write_text(folder / "none.tum", "# no pose\n");
  EXPECT_TRUE(read_tum(folder / "none.tum").empty());
  write_text(folder / "bad.tum", "0 1 2 3 4\n");
  EXPECT_THROW(read_tum(folder / "bad.tum"), FileError);
}

TEST(Tum, TheTwentyColumnFormHoldsTheUpperTrianglesOrientationFirst) {
  const TemporaryFolder folder;
  Matrix6d P = Matrix6d::Zero();
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      P(row, column) = 10 * std::min(row, column) + std::max(row, column) + 11;
  const std::string text = tum_row(nanoseconds(0), Eigen::Isometry3d::Identity(), P);
  EXPECT_EQ(text, "0.000000000 0 0 0 0 0 0 1 11 12 13 22 23 33 44 45 46 55 56 66\n");
  write_text(folder / "c.txt", kTumCovarianceHeader + text);
  P.topRightCorner<3, 3>().setZero();
  P.bottomLeftCorner<3, 3>().setZero();
  EXPECT_EQ(read_tum(folder / "c.txt").at(0).covariance, P);
  write_text(folder / "none.txt",
             kTumCovarianceHeader + tum_row(nanoseconds(0), Eigen::Isometry3d::Identity()));
  EXPECT_FALSE(read_tum(folder / "none.txt").at(0).covariance);
}

TEST(Tum, StampsAreReadWithoutGoingThroughADouble) {
  for (const auto& [text, ns] : {std::pair("-0.5", -500'000'000l),
                                 {"1e-3", 1'000'000},
                                 {"2", 2'000'000'000},
                                 {"43.000000001", 43'000'000'001},
                                 {"-3.000000001", -3'000'000'001},
                                 {"1403636579.763555584", 1403636579763555584},
                                 {"1.403636579763555584e+09", 1403636579763555584}})
    EXPECT_EQ(parse_stamp(text, 1e9), nanoseconds(ns)) << text;
  EXPECT_FALSE(parse_stamp("1403636579763555584", 1e9));
  EXPECT_FALSE(parse_stamp("nan", 1e9));
}

}  // namespace
}  // namespace sim::files
