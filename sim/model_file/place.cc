#include "sim/model_file/place.h"

#include <numbers>

namespace sim::model_file {
namespace {

Eigen::Vector3d vector(const std::vector<double>& values, std::size_t from = 0) {
  return {values[from], values[from + 1], values[from + 2]};
}

Eigen::Vector3d direction(const Element& element, std::string_view attribute, const Eigen::Vector3d& v) {
  if (v.norm() < 1e-9) reject(element, attribute, "has a direction of length 0");
  return v.normalized();
}

Eigen::Quaterniond turn_of(const Element& element, const Angles& angles) {
  using Turn = Eigen::AngleAxisd;
  const double unit = angles.degrees ? std::numbers::pi / 180 : 1;
  if (const auto q = numbers(element, "quat", 4, 4); !q.empty()) {
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (turn.norm() < 1e-9) reject(element, "quat", "has length 0");
    return turn.normalized();
  }
  if (const auto a = numbers(element, "axisangle", 4, 4); !a.empty())
    return Eigen::Quaterniond(Turn(unit * a[3], direction(element, "axisangle", vector(a))));
  if (const auto e = numbers(element, "euler", 3, 3); !e.empty()) {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    for (std::size_t i = 0; i < 3; ++i) {
      const int axis = (angles.sequence[i] | 0x20) - 'x';
      const Eigen::Quaterniond turn(Turn(unit * e[i], Eigen::Vector3d::Unit(axis)));
      q = angles.sequence[i] < 'a' ? turn * q : q * turn;
    }
    return q;
  }
  if (const auto xy = numbers(element, "xyaxes", 6, 6); !xy.empty()) {
    Eigen::Matrix3d R;
    R.col(0) = direction(element, "xyaxes", vector(xy));
    R.col(1) = direction(element, "xyaxes", vector(xy, 3) - vector(xy, 3).dot(R.col(0)) * R.col(0));
    R.col(2) = R.col(0).cross(R.col(1));
    return Eigen::Quaterniond(R);
  }
  if (const auto z = numbers(element, "zaxis", 3, 3); !z.empty())
    return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(),
                                              direction(element, "zaxis", vector(z)));
  return Eigen::Quaterniond::Identity();
}

}  // namespace

Eigen::Isometry3d place_of(const Element& element, const Angles& angles) {
  const auto p = numbers(element, "pos", 3, 3);
  return Eigen::Translation3d(p.empty() ? Eigen::Vector3d::Zero() : vector(p)) * turn_of(element, angles);
}

void set_place(Element& element, const Eigen::Isometry3d& X) {
  for (const char* attribute : {"pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"})
    element.erase(attribute);
  element.set("pos", text_of(X.translation()));
  const Eigen::Quaterniond q(X.linear());
  element.set("quat", text_of(std::array{q.w(), q.x(), q.y(), q.z()}));
}

}  // namespace sim::model_file
