// Loads models into MuJoCo, catches its warnings, and reads poses and sizes from its arrays.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim/physics/robot_file.h"

struct mjModel_;
struct mjData_;

namespace sim::model_file {
struct Element;
}

namespace sim::physics {

struct Free {
  void operator()(mjModel_* model) const;
  void operator()(mjData_* data) const;
};
using Model = std::unique_ptr<mjModel_, Free>;
using Data = std::unique_ptr<mjData_, Free>;

/// Files by the names that a model gives them.
using NamedFiles = std::vector<std::pair<std::string, fs::path>>;

/// Loads MJCF or URDF. Throws FileError with the library's message and the file and line of the element in
/// question, or std::runtime_error "<from> does not load: " with the message. After the first call, an error
/// inside MuJoCo prints one line on stderr and ends the process with code 3, and warnings are stored.
Model load_mjcf(const model_file::Element& root, const std::string& from, const NamedFiles& files = {});

/// Returns the pose from MuJoCo's arrays of positions and of row-major rotations.
inline Eigen::Isometry3d pose_in(const double* p, const double* R) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(p);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R);
  return X;
}
/// The pose in its arrays of positions and of quaternions.
inline Eigen::Isometry3d turned_pose_in(const double* p, const double* q) {
  return Eigen::Translation3d(p[0], p[1], p[2]) * Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
}

/// Computes the poses of the robot's bodies from the positions in `data`, and the poses of actors from its
/// time.
void pose_bodies(const mjModel_& model, mjData_& data);
/// Returns whether a geom belongs to an actor.
bool is_actor(const mjModel_& model, int geom);

/// Returns X_WG of a geom. Positions must have been computed.
Eigen::Isometry3d geom_pose(const mjData_& data, int geom);
/// Returns half the size of a geom along its own axes (m), or slightly more.
Eigen::Vector3d half_extents(const mjModel_& model, int geom);
/// Returns a box around a geom with the axes of W. Positions must have been computed.
Eigen::AlignedBox3d box_around(const mjModel_& model, const mjData_& data, int geom);
/// Returns the distance along a ray from a point to a geom (m, both in W), or a negative number.
double ray_distance(const mjModel_& model, const mjData_& data, int geom, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& along);
/// Returns the vertices of a mesh, or the corners of a box around another shape, moved from W by X. Bits 0 to
/// 2 of a corner's index select the side along x, y, z. The box around a sphere has the axes of the result.
std::vector<Eigen::Vector3d> corners(const mjModel_& model, const mjData_& data, int geom,
                                     const Eigen::Isometry3d& X);
/// The geoms of a foot that touch the floor.
std::vector<int> contacts(const mjModel_& model, int foot);
/// Returns the index of a named part (mjtObj). Throws std::invalid_argument if the model has no such part.
int part(const mjModel_& model, int type, const std::string& name);
/// Returns the name of a part, or "" without one and for a negative index.
std::string name_of(const mjModel_& model, int type, int id);

/// Returns an independent copy. Opens no file.
Model copy_of(const Model& model);

/// A place on the robot: a body of the model, and a sensor's axes (forward, left, up) in the body's frame.
struct Place {
  int body = 0;
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
};

/// Returns the pose of a mount. Without a link it is relative to the model's head camera. Throws
/// std::invalid_argument if the robot has no such link, or if the link is part of a leg, which moves relative
/// to the head.
Place place_of(const mjModel_& model, const rig::Mount& mount);

/// Moves the model's head camera to the place of the mount. Throws std::invalid_argument as place_of().
void mount_camera(mjModel_& model, const rig::Mount& mount);

/// Moves the model's IMU in the same way.
void mount_imu(mjModel_& model, const rig::Mount& mount);

/// Returns MuJoCo's last warning since the previous call, if any.
std::optional<std::string> latest_warning();

}  // namespace sim::physics
