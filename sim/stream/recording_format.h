// The names and column titles of a recording's files: one place for what is written and what is read.
#pragma once

#include <array>
#include <string>

#include "sim/stream/csv.h"
#include "slam/observation.h"

namespace sim::stream::recording_format {

inline const std::string kBody = "mav0/body.yaml";
inline const std::string kCameraFolder = "mav0/cam0/data/";
inline const std::string kCameraSensor = "mav0/cam0/sensor.yaml";
inline const std::string kCameraRows = "mav0/cam0/data.csv";
inline const std::string kImuSensor = "mav0/imu0/sensor.yaml";
inline const std::string kImuRows = "mav0/imu0/data.csv";
inline const std::string kPlanSensor = "mav0/plan0/sensor.yaml";
inline const std::string kPlanRows = "mav0/plan0/data.csv";
inline const std::string kMotionSensor = "mav0/state_groundtruth_estimate0/sensor.yaml";
inline const std::string kMotionRows = "mav0/state_groundtruth_estimate0/data.csv";
inline const std::string kEncodersSensor = "mav0/encoders0/sensor.yaml";
inline const std::string kEncoderRows = "mav0/encoders0/data.csv";
inline const std::string kForcesSensor = "mav0/forces0/sensor.yaml";
inline const std::string kForceRows = "mav0/forces0/data.csv";
inline const std::string kFrames = "frames.csv";
inline const std::string kTrueCamera = "truth/camera.csv";
inline const std::string kTrueWaist = "truth/waist.csv";
inline const std::string kPlannedWaist = "truth/waist_plan.csv";
inline const std::string kFeet = "truth/feet.csv";
inline const std::string kSurfaces = "truth/surfaces.csv";

/// What nothing here reads: checked all the same.
inline const std::array<std::string, 7> kForOthers{kBody,      kEncodersSensor, kEncoderRows, kForcesSensor,
                                                   kForceRows, kMotionSensor,   kMotionRows};

inline const std::string kStampColumn = "#timestamp [ns]";
inline const std::string kCameraHeader = kStampColumn + ",filename";
inline const std::string kGyroHeader =
    kStampColumn + ",w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]";
inline const std::string kImuHeader = kGyroHeader + ",a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";
inline const std::string kPlanHeader = kStampColumn + "," + pose_columns("PC") +
                                       ",v_PC_C_x [m s^-1],v_PC_C_y [m s^-1],v_PC_C_z [m s^-1]"
                                       ",w_PC_C_x [rad s^-1],w_PC_C_y [rad s^-1],w_PC_C_z [rad s^-1]"
                                       ",support [],p_CF_x [m],p_CF_y [m],p_CF_z [m]";
inline const std::string kMotionHeader =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
    "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
    "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]";
inline const std::string kForcesHeader = kStampColumn +
                                         ",f_L_x [N],f_L_y [N],f_L_z [N],m_L_x [N m],m_L_y [N m],m_L_z [N m]"
                                         ",f_R_x [N],f_R_y [N],f_R_z [N],m_R_x [N m],m_R_y [N m],m_R_z [N m]";
inline const std::string kTrueCameraHeader = kStampColumn + "," + pose_columns("WC");
inline const std::string kTrueWaistHeader = kStampColumn + "," + pose_columns("WB");
inline const std::string kPlannedWaistHeader = kStampColumn + "," + pose_columns("PB");
inline const std::string kFootColumns =
    ",x [m],y [m],yaw [rad],plan_x [m],plan_y [m],plan_yaw [rad],planned_down,load [N]"
    ",creep_x [m],creep_y [m],creep_yaw [rad]";
inline const std::string kFeetHeader = kStampColumn + kFootColumns + kFootColumns;
inline const std::string kSurfacesHeader =
    "#kind," + pose_columns("WS") + ",size_1 [m],size_2 [m],size_3 [m]";

/// The words of slam::Support, by its values.
inline const std::array<std::string, 3> kSupport{"both", "left", "right"};

/// The kinds of RecordedSurface.
inline const std::array<std::string, 6> kSurfaceKinds{"plane",    "box",       "sphere",
                                                      "cylinder", "ellipsoid", "capsule"};

}  // namespace sim::stream::recording_format
