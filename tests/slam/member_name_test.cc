#include "slam/member_name.h"

#include <gtest/gtest.h>

#include <vector>

namespace slam {
namespace {

struct Sensor {
  double sigma_rad_s = 1;
  std::vector<int> k1_px2;
};

struct Outer {
  Sensor sensor;
};

TEST(MemberName, IsTheNameInTheDeclaration) {
  EXPECT_EQ(member_name<&Sensor::sigma_rad_s>(), "sigma_rad_s");
  EXPECT_EQ(member_name<&Sensor::k1_px2>(), "k1_px2");
  EXPECT_EQ(member_name<&Outer::sensor>(), "sensor");
}

TEST(MemberName, StandsBesideThePointerToTheMember) {
  const Sensor sensor{.sigma_rad_s = 2, .k1_px2 = {}};
  EXPECT_EQ(sensor.*(member<&Sensor::sigma_rad_s>.pointer), 2);
  EXPECT_EQ(member<&Sensor::sigma_rad_s>.name, "sigma_rad_s");
}

}  // namespace
}  // namespace slam
