#include "sim/files/trajectory_file.h"

#include "sim/files/columns.h"
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

TEST_F(TrajectoryFileTest, IdenticalOrientationsCauseAWarning) {
  const std::string same = "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n3 2 0 0 ";
  EXPECT_EQ(read(same + "0 0 0 1\n").warning, "all its orientations are the same: are they unknown?");
  EXPECT_EQ(read(same + "0 0 1 0\n").warning, std::nullopt);
}

TEST_F(TrajectoryFileTest, AStampInTwoColumnsIsReadAccordingToItsHeaderOrRejected) {
  for (const auto& [header, begin] : {
           std::pair("secs,nsecs,x,y,z", "1403636579,9"),
           {"field.header.seq,field.header.stamp.secs,field.header.stamp.nsecs,x,y,z", "0,1403636579,9"},
           {"Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,x,y,z",
            "1.5,,1403636579,9,"},
           {"%time,field.header.seq,field.header.stamp,field.header.frame_id,x,y,z",
            "7,0,1403636579000000009,"},
           {"stamp_nanosec,stamp_sec,x,y,z", "9,1403636579"},
       }) {
    const TrajectoryFile file = read(fmt::format("{}\n{},1,2,3\n", header, begin));
    EXPECT_EQ(file.rows[0].t, nanoseconds(1403636579'000'000'009)) << header;
    EXPECT_EQ(file.rows[0].X.translation(), Eigen::Vector3d(1, 2, 3)) << header;
  }
  EXPECT_EQ(read("# sec nanosec tx ty tz qx qy qz qw\n5 250000000 1 2 3 0 0 0 1\n").rows[0].t,
            nanoseconds(5'250'000'000));
  expect_rejected("secs,nsecs,x,y,z\n5,1000000000,1,2,3\n",
                  ":2:3: expected whole seconds and the rest in whole nanoseconds in two columns");
  expect_rejected("secs,nsecs,x,y,z\n5.5,1,1,2,3\n", ":2:5: expected whole seconds and the rest");
  expect_rejected("5,10,1,2,1,0,0,0\n5,20,1,2,1,0,0,0\n",
                  ":2:1: the stamp is not after the previous one: it is the same; if its last");
}

TEST_F(TrajectoryFileTest, APoseMayLackTheCovarianceThatOthersHave) {
  const std::string without = " 0 0 0 0 0 0 1\n", with = " 0 0 0 0 0 0 1 1 2 3 4 5 6 7 8 9 10 11 12\n";
  for (const std::size_t which : {0u, 1u}) {
    const TrajectoryFile file =
        read("0" + (which == 0 ? with : without) + "1" + (which == 1 ? with : without));
    EXPECT_EQ(file.format, "TUM with covariance");
    ASSERT_TRUE(file.rows[which].covariance);
    EXPECT_EQ((*file.rows[which].covariance)(1, 2), 5);
    EXPECT_EQ((*file.rows[which].covariance)(5, 3), 9);
    EXPECT_FALSE(file.rows[1 - which].covariance);
  }
}

constexpr const char* kPose = "timestamp tx ty tz qx qy qz qw";

// The elements of the orientation's block are 10 row + column, starting at 11; those of the position's block
// start at 44.
TEST_F(TrajectoryFileTest, CovarianceColumnsAreReadByTheirNames) {
  std::string ros, ros_values, pairs, pairs_values;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) {
      const auto of = [](int i) { return (i + 3) % 6 + 1; };  // position first
      const int value =
          row / 3 != column / 3 ? 0 : 10 * of(std::min(row, column)) + of(std::max(row, column));
      static constexpr std::array kAxes{"x", "y", "z", "roll", "pitch", "yaw"};
      ros += fmt::format(" pose.covariance[{}]", 6 * row + column);
      ros_values += fmt::format(" {}", value);
      if (column > row || row / 3 != column / 3) continue;
      pairs += fmt::format(" cov_{}_{}", kAxes[static_cast<std::size_t>(row)],
                           kAxes[static_cast<std::size_t>(column)]);
      pairs_values += fmt::format(" {}", value);
    }
  for (const auto& [names, values] : std::vector<std::pair<std::string, std::string>>{
           {" Pt11 Pt12 Pt13 Pt22 Pt23 Pt33 Pr11 Pr12 Pr13 Pr22 Pr23 Pr33",
            " 44 45 46 55 56 66 11 12 13 22 23 33"},
           {" Pr11 Pr21 Pr22 Pr31 Pr32 Pr33 Pt11 Pt21 Pt22 Pt31 Pt32 Pt33",
            " 11 12 22 13 23 33 44 45 55 46 56 66"},
           {" Pr33 Pr23 Pr22 Pr13 Pr12 Pr11 Pt11 Pt12 Pt13 Pt22 Pt23 Pt33",
            " 33 23 22 13 12 11 44 45 46 55 56 66"},
           {" cov_tx_tx cov_tx_ty cov_tx_tz cov_ty_ty cov_ty_tz cov_tz_tz cov_rx_rx cov_rx_ry cov_rx_rz "
            "cov_ry_ry "
            "cov_ry_rz cov_rz_rz",
            " 44 45 46 55 56 66 11 12 13 22 23 33"},
           {" position_covariance_0 position_covariance_1 position_covariance_2 position_covariance_4 "
            "position_covariance_5 position_covariance_8 rot_cov_xx rot_cov_xy rot_cov_xz rot_cov_yy "
            "rot_cov_yz rot_cov_zz",
            " 44 45 46 55 56 66 11 12 13 22 23 33"},
           {" Pt11[mm^2] Pt12[mm^2] Pt13[mm^2] Pt22[m^2] Pt23[m^2] Pt33[m^2] Pr11 Pr12 Pr13 Pr22 Pr23 Pr33",
            " 44e6 45e6 46e6 55 56 66 11 12 13 22 23 33"},
           {pairs, pairs_values},
           {ros, ros_values}})
    for (const char separator : {' ', ',', ';'}) {
      std::string text = kPose + names + "\n1 0 0 0 0 0 0 1" + values + "\n";
      std::ranges::replace(text, ' ', separator);
      const TrajectoryFile file = read(text);
      Matrix6d P = Matrix6d::Zero();
      for (int row = 0; row < 6; ++row)
        for (int column = 0; column < 6; ++column)
          if (row / 3 == column / 3) P(row, column) = 10 * std::min(row, column) + std::max(row, column) + 11;
      ASSERT_TRUE(file.rows[0].covariance) << text;
      EXPECT_LT((*file.rows[0].covariance - P).norm(), 1e-9) << text << *file.rows[0].covariance;
    }
}

TEST_F(TrajectoryFileTest, RotationsAboutFixedAxesAreConvertedToBodyAxes) {
  std::string names = "t,x,y,z,qx,qy,qz,qw", values = "1,0,0,0,0,0,0.7071067811865476,0.7071067811865476";
  for (int k = 0; k < 36; ++k) {
    names += fmt::format(",covariance_{}", k);
    values += fmt::format(",{}", k % 7 == 0 ? k + 1 : 0);
  }
  const Matrix6d P = read(names + "\n" + values + "\n").rows[0].covariance.value();
  const Eigen::Vector<double, 6> expected(29, 22, 36, 1, 8, 15);  // a quarter turn to the left swaps x and y
  EXPECT_TRUE(P.diagonal().isApprox(expected, 1e-12)) << P.diagonal();
}

TEST_F(TrajectoryFileTest, ACovarianceWithUnnamedColumnsIsRejected) {
  const std::string rotation = " Pr11 Pr12 Pr13 Pr22 Pr23 Pr33";
  for (const auto& [names, why] : std::vector<std::pair<std::string, std::string>>{
           {" Pt11 Pt12 Pt13 Pt22 Pt23 Pt99", ":1: column 14, \"Pt99\": unknown name"},
           {" c1 c2 c3 c4 c5 c6", ":1: column 9, \"c1\": unknown name"},
           {" P11 P12 P13 P22 P23 P33", ":1: column 9, \"P11\": unknown covariance name"},
           {" Pt11 Pt12 Pt13 Pt22 Pt23 Pt23", ":1: column 14, \"Pt23\": is repeated"},
           {" Pt11 Pt12 Pt13 Pt22 Pt23 Pt32", ":1: the covariance is incomplete: no column is Pt33"},
           {" Pt11 Pt12 Pt13 Pt22 Pt23 Pt33[h]", ":1: column 14, \"Pt33[h]\": unknown unit"}})
    expect_rejected(kPose + names + rotation + "\n1 0 0 0 0 0 0 1 1 2 3 4 5 6 1 2 3 4 5 6\n", why);
  expect_rejected(
      kPose + (" Pt11 Pt12 Pt13 Pt22 Pt23 Pt33" + rotation) + "\n1 0 0 0 0 0 0 1 1 2 3 4 5 6 1 2 3 4 5\n",
      ":2: expected at least 20 numbers, found 19");
  expect_rejected("t,x,y,z,qx,qy,qz,qw,cov_xx\n1,0,0,0,0,0,0,1,1\n", ":1: the covariance is incomplete");
  expect_rejected(
      "t,x,y,z,qx,qy,qz,qw,c1,c2,c3,c4,c5,c6,c7,c8,c9,ca,cb,cc\n1,0,0,0,0,0,0,1,1,2,3,4,5,6,1,2,3,4,5,6\n",
      ":1: column 9, \"c1\": unknown name, expected a covariance");
  const std::string other = "t,tx,ty,tz,qx,qy,qz,qw,twist.covariance0,vx,Pr\n1,0,0,0,0,0,0,1,2,3,4\n";
  EXPECT_FALSE(read(other).rows[0].covariance) << "not of the pose";
  std::string unnamed = "1 0 0 0 1 0 0 0 1 2 3 4 5 6 1 2 3 4 5 6\n";
  std::ranges::replace(unnamed, ' ', ',');
  EXPECT_THAT(read(unnamed).warning.value_or(""), HasSubstr("a covariance in them is not read"));
}

std::string utf16(const std::string& text, bool little, bool mark) {
  std::string wide = mark ? (little ? "\xff\xfe" : "\xfe\xff") : "";
  for (const char c : text) wide += little ? std::string{c, '\0'} : std::string{'\0', c};
  return wide;
}

// Text as written by tables and shells of Windows, by PlotJuggler, and by programs without orientations.
TEST_F(TrajectoryFileTest, OtherEncodingsAndNotationsOfNumbersAreRead) {
  const std::string plain = "1.5 0.25 1 2 0 0 0.6 0.8\n1.6 0.5 1 2 0 0 0 1\n",
                    comma = "1,5 0,25 1 2 0 0 0,6 0,8\n1,6 0,5 1 2 0 0 0 1\n";
  const auto with = [](std::string text, char separator) {
    std::ranges::replace(text, ' ', separator);
    return text;
  };
  std::string carriage = plain;
  std::ranges::replace(carriage, '\n', '\r');
  for (const std::string& text :
       {plain, utf16(plain, true, true), utf16(plain, true, false), utf16(plain, false, true),
        utf16(plain, false, false), carriage, comma, with(comma, ';'), with(comma, '\t'), with(plain, ';'),
        "t;x;y;z;qx;qy;qz;qw\r\n" + with(comma, ';'),
        std::string("1,5;0,25;1;2;0;0;0,6;0,8;\n1,6;0,5;1;2;0;0;0;1;\n"),
        std::string(
            "t,x,y,z,qx,qy,qz,qw\n\"1,5\",\"0,25\",1,2,0,0,\"0,6\",\"0,8\"\n1.6,\"0,5\",1,2,0,0,0,1\n"),
        "__time,/odom/pose/pose/position/x,/odom/pose/pose/position/y,/odom/pose/pose/position/z,"
        "/odom/pose/pose/orientation/x,/odom/pose/pose/orientation/y,/odom/pose/pose/orientation/z,"
        "/odom/pose/pose/orientation/w\n" +
            with(plain, ',')}) {
    const TrajectoryFile file = read(text);
    ASSERT_EQ(file.rows.size(), 2u) << text;
    EXPECT_EQ(file.rows[0].t, std::chrono::milliseconds(1500)) << text;
    EXPECT_EQ(file.rows[0].X.translation(), Eigen::Vector3d(0.25, 1, 2)) << text;
    EXPECT_NEAR(Eigen::Quaterniond(file.rows[0].X.linear()).z(), 0.6, 1e-12) << text;
  }
  for (const char* text : {"1 0 0 0 0 0 0 0\n2 1 2 3 0 0 0 0\n", "1,0,0,0,nan,nan,nan,nan\n2,1,2,3,,,,\n"}) {
    EXPECT_FALSE(read(text).has_orientation) << text;
    EXPECT_EQ(read(text).rows[1].X.translation(), Eigen::Vector3d(1, 2, 3)) << text;
  }
  const TrajectoryFile lost = read("1 1 2 3 0 0 0 1\n2 nan nan nan nan nan nan nan\n3 1 2 3 0 0 0 1\n");
  EXPECT_EQ(lost.rows.size(), 2u);
  EXPECT_EQ(lost.warning, "1 line without a position left out");
  for (const auto& [start, name] : {std::pair(std::string("\x1f\x8b\x08\0", 4), "compressed (gzip)"),
                                    {"\x28\xb5\x2f\xfd", "compressed (zstd)"},
                                    {"\xfd"
                                     "7zXZ",
                                     "compressed (xz)"},
                                    {"BZh9", "compressed (bzip2)"},
                                    {"PK\3\4", "compressed (zip)"},
                                    {"#ROSBAG V2.0", "a ROS bag"},
                                    {std::string("1\0\0\0 \0\0\0", 8), "UTF-32 or binary"},
                                    {std::string("1 2 3 4\0", 8), "UTF-32 or binary"}})
    expect_rejected(start, std::string(": is ") + name);
}

TEST_F(TrajectoryFileTest, EurocPutsTheQuaternionsRealPartFirst) {
  const TrajectoryFile file = read("#timestamp, p_RS_R_x [m]\n1000000000000000000,1,2,3,0,1,0,0,9,9\n");
  EXPECT_EQ(file.format, "EuRoC csv");
  EXPECT_EQ(file.stamps, "nanoseconds");
  EXPECT_EQ(file.rows[0].t, nanoseconds(1000000000000000000));
  EXPECT_NEAR(file.rows[0].X.linear()(1, 1), -1, 1e-15);  // half a turn about x
  EXPECT_EQ(read("0.5, 1, 2, 3, 1, 0, 0, 0\n").rows[0].t, std::chrono::milliseconds(500));
}

TEST_F(TrajectoryFileTest, AHeaderThatNamesItsColumnsIsObeyed) {
  for (const std::string text :
       {"#timestamp,tx,ty,tz,qx,qy,qz,qw\n5.0,1,2,3,0.6,0,0,0.8\n5.1,1,2,3,0.6,0,0,0.8\n",
        "timestamp,qw,qx,qy,qz,px,py,pz\n5.0,0.8,0.6,0,0,1,2,3\n5.1,0.8,0.6,0,0,1,2,3\n",
        "# timestamp tx ty tz qw qx qy qz\n5.0 1 2 3 0.8 0.6 0 0\n5.1 1 2 3 0.8 0.6 0 0\n",
        "\xef\xbb\xbf# time [s] x [mm] y [mm] z [mm] q_x q_y q_z q_w\n5.0 1000 2000 3000 0.6 0 0 0.8\n"
        "5.1 1000 2000 3000 0.6 0 0 0.8\n",
        "time,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,pose.orientation.y,"
        "pose.orientation.z,pose.orientation.w\n5.0,1,2,3,0.6,0,0,0.8\n5.1,1,2,3,0.6,0,0,0.8\n",
        "t x_mm y_mm z_mm qw qx qy qz\n5.0 1000 2000 3000 0.8 0.6 0 0\n5.1 1000 2000 3000 0.8 0.6 0 0\n",
        "t_ms,px_cm,py_cm,pz_cm,qw,qx,qy,qz\n5000,100,200,300,0.8,0.6,0,0\n5100,100,200,300,0.8,0.6,0,0\n",
        "# x y z qw qx qy qz\n5.0 1 2 3 0.8 0.6 0 0\n5.1 1 2 3 0.8 0.6 0 0\n",
        "# format: t x y z qw qx qy qz\n5.0 1 2 3 0.8 0.6 0 0\n5.1 1 2 3 0.8 0.6 0 0\n",
        "tx,ty,tz,qx,qy,qz,qw,time_ms\n1,2,3,0.6,0,0,0.8,5000\n1,2,3,0.6,0,0,0.8,5100\n",
        "t [ns], vertex index, p_G_Ix [m], p_G_Iy [m], p_G_Iz [m], q_G_Iw, q_G_Ix, q_G_Iy, q_G_Iz\n"
        "5000000000,7,1,2,3,0.8,0.6,0,0\n5100000000,8,1,2,3,0.8,0.6,0,0\n",
        "t,goal_x,goal_y,goal_z,x,y,z,odom_qx,odom_qy,odom_qz,odom_qw\n5,9,9,9,1,2,3,0.6,0,0,0.8\n"
        "5.1,9,9,9,1,2,3,0.6,0,0,0.8\n"}) {
    const TrajectoryFile file = read(text);
    EXPECT_EQ(file.rows[1].t, std::chrono::milliseconds(5100)) << text;
    EXPECT_LT((file.rows[1].X.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12) << text;
    EXPECT_NEAR(Eigen::Quaterniond(file.rows[1].X.linear()).x(), 0.6, 1e-12) << text;
  }
  expect_rejected("#timestamp,tx,ty,tz,roll,pitch,yaw,qw\n5.0,1,2,3,0,0,0,1\n",
                  ":1: column 5, \"roll\": expected the orientation along w here");
  expect_rejected(
      "t,gt_x,gt_y,gt_z,est_x,est_y,est_z\n5,1,2,3,1,2,3\n",
      ":1: column 5, \"est_x\": names the position along x again, after column 2, expected it once");
  expect_rejected("Saved by my slam\n5 1 2 3 0 0 0 1\n", ":1:1: expected a finite number, found \"Saved\"");
  expect_rejected("#timestamp,vx,vy,vz,qw,qx,qy,qz\n5.0,1,2,3,1,0,0,0\n", ":1: column 2, \"vx\": expected");
  expect_rejected("# x y z\n5.0 1 2 3 0.8 0.6 0 0\n",
                  ":1: the header names 3 columns and no stamp, the rows have 8: expected ");
  expect_rejected(
      "t,/a/position/x,/a/position/y,/a/position/z,/b/position/x,/b/position/y,/b/position/"
      "z\n5,1,2,3,4,5,6\n",
      ":1: column 5, \"/b/position/x\": names the position along x again, after column 2");
  expect_rejected("t,x,y,z,qx,qy,qz,qw,var_x\n1,0,0,0,0,0,0,1,1\n",
                  ":1: column 9, \"var_x\": unknown covariance name");
  expect_rejected("t,lat,lon,alt,qw,qx,qy,qz\n5.0,1,2,3,1,0,0,0\n", ":1: column 2, \"lat\": expected");
  expect_rejected("#t [h],tx,ty,tz,qw,qx,qy,qz\n5.0,1,2,3,1,0,0,0\n",
                  ":1: column 1, \"t [h]\": unknown unit");
  expect_rejected("#t [ns],tx,ty,tz,qw,qx,qy,qz\n5.0,1,2,3,1,0,0,0\n5.1,1,2,3,1,0,0,0\n",
                  ": the header states nanoseconds, but the stamps, ");
}

TEST_F(TrajectoryFileTest, AHeaderIsDistinguishedFromOtherComments) {
  for (const char* comment :
       {"# Time stamps of each pose follow", "# time in s, position in m, quaternion, end",
        "# file: x, seed 1", "# axes x y z of the world",
        "# timestamp tx ty tz qx qy qz qw\n# made by hand, in a day"})
    EXPECT_EQ(read(std::string(comment) + "\n1 2 3 4 0 0 0 1\n2 2 3 4 0 0 0 1\n").rows.size(), 2u) << comment;
  const TrajectoryFile counted = read("frame,tx,ty,tz,qx,qy,qz,qw\n0,1,2,3,1,0,0,0\n1,1,2,3,1,0,0,0\n");
  EXPECT_NEAR(counted.rows[0].X.linear()(1, 1), -1, 1e-15) << "half a turn about x";
}

TEST_F(TrajectoryFileTest, PositionsMayComeWithoutOrientations) {
  for (const char* text :
       {"# t x y z\n5.0 1 2 3\n5.1 1 2 3\n", "x y z\n5.0 1 2 3\n5.1 1 2 3\n",
        "t,x,y,z\n5.0,1,2,3\n5.1,1,2,3\n", "5.0,1,2,3\n5.1,1,2,3\n", "5.0 1 2 3\n5.1 1 2 3\n",
        "#timestamp [s], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n5.0,1,2,3\n5.1,1,2,3\n"}) {
    const TrajectoryFile file = read(text);
    EXPECT_FALSE(file.has_orientation) << text;
    EXPECT_EQ(file.rows[1].X.translation(), Eigen::Vector3d(1, 2, 3)) << text;
  }
}

TEST_F(TrajectoryFileTest, AllStampsTogetherDecideTheirUnit) {
  for (const auto& [stamps, unit, last_ns] :
       std::vector<std::tuple<std::vector<const char*>, const char*, std::int64_t>>{
           {{"1.403715273000000000e+18", "1.403715273049999872e+18"}, "nanoseconds", 1403715273049999872},
           {{"# a comment\n1403715273000000000.0", "1403715273049999872.0"},
            "nanoseconds",
            1403715273049999872},
           {{"1403715273000000", "1403715273050000"}, "microseconds", 1403715273050000000},
           {{"1403715273000", "1403715273050"}, "milliseconds", 1403715273050000000},
           {{"1403715273", "1403715273.05", "1403715273.1"}, "seconds", 1403715273100000000},
           {{"0", "0.05", "0.1"}, "seconds", 100000000},
           {{"0", "0.05", "1"}, "seconds", 1000000000},
           {{"1403715273", "1403715274", "1403715275"}, "seconds", 1403715275000000000},
           {{"0", "50000000", "6000000000"}, "nanoseconds", 6000000000},
           {{"0", "50000", "100000"}, "microseconds", 100000000},
           {{"7", "8", "9"}, "seconds", 9000000000}}) {
    std::string csv, tum;
    for (const char* stamp : stamps) {
      csv += std::string(stamp) + ",1,2,3,1,0,0,0\n";
      tum += std::string(stamp) + " 1 2 3 0 0 0 1\n";
    }
    for (const std::string& text : {csv, tum}) {
      const TrajectoryFile file = read(text);
      EXPECT_EQ(file.stamps, unit) << text;
      EXPECT_EQ(file.format, text == csv ? "EuRoC csv" : "TUM") << text;
      EXPECT_EQ(file.rows.back().t.count(), last_ns) << text;
    }
  }
}

TEST_F(TrajectoryFileTest, KittiHasTimesInASeparateFileOrNone) {
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

TEST_F(TrajectoryFileTest, OnlyARepeatedLastStampIsDroppedWithAWarning) {
  const std::string two = "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n";
  const TrajectoryFile dropped = read(two + "2 5 0 0 0 0 0 1\n");
  EXPECT_EQ(dropped.rows.size(), 2u);
  EXPECT_EQ(dropped.rows[1].X.translation().x(), 0);
  EXPECT_EQ(dropped.warning, "its last pose repeats the previous stamp and is left out");
  EXPECT_EQ(read(two).warning, std::nullopt);
  EXPECT_EQ(
      read("1000000000,0,0,0,1,0,0,0\n1000000033,0,0,0,1,0,0,0\n1000000033,0,0,0,1,0,0,0\n").rows.size(), 2u);
  expect_rejected(two + "2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n",
                  ":3:1: the stamp is not after the previous one");
  expect_rejected(two + "1.5 0 0 0 0 0 0 1\n", ":3:1: the stamp is not after the previous one");
}

TEST_F(TrajectoryFileTest, ErrorsNamePlaceAndReason) {
  for (const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
           {"", ": contains no pose"},
           {"# nothing\n\n", ": contains no pose"},
           {"1 2 3\n", ":1: has 3 numbers, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC)"},
           {"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", ":2: expected 8 numbers, found 7"},
           {"2 0 0 4 0 1 0 5 0 0 1 6\n", ":1:1: the first three columns are not a rotation"},
           {"1,2,3\n", ":1: expected at least 8 numbers, found 3"},
           {"#t,px,py,pz,qx,qy,qz,qw\n22000\n", ":2: expected at least 8 numbers, found 1"},
           {"# c\n0 0 0 x 0 0 0 1\n", ":2:7: expected a finite number, found \"x\""},
           {"0 0 0 nan 0 0 0 1\n", ":1:7: expected a finite number"},
           {"0 0 0 0 0 0 0 1\n1 1 1e308 1 0 0 0 1\n", ":2:5: a position of more than 1e9 m"},
           {"0,1,2,3,1,0,0,0\n1,-1e200,2,3,1,0,0,0\n", ":2:3: a position of more than 1e9 m"},
           {"1 0 0 0 0 1 0 0 0 0 1 1e12\n", ":1:23: a position of more than 1e9 m"},
           {"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 0\n", ":2:9: the quaternion does not have length 1"},
           {"1 nan nan nan 0 0 0 1\n", ": contains no pose: every position is missing or NaN"},
           {"1,5,0,25,1,25,2,5,0,5,0,5,0,5,0,5\n1,6,0,25,1,25,2,5,0,5,0,5,0,5,0,5\n",
            ": has commas and no decimal point: if the commas are decimal, other characters must separate"}})
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
}

TEST(Tum, StampsAreReadWithoutGoingThroughADouble) {
  for (const auto& [text, ns] : {std::pair("-0.5", -500'000'000l),
                                 {"1e-3", 1'000'000},
                                 {"2", 2'000'000'000},
                                 {"1403636579.763555584", 1403636579763555584},
                                 {"1.403636579763555584e+09", 1403636579763555584}})
    EXPECT_EQ(parse_stamp(text, kSeconds), nanoseconds(ns)) << text;
  EXPECT_FALSE(parse_stamp("1403636579763555584", kSeconds));
  EXPECT_FALSE(parse_stamp("nan", kSeconds));
}

}  // namespace
}  // namespace sim::files
