// One small file for each preset, in the structure of a real one, which the test names.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <iomanip>
#include <random>
#include <sstream>

#include "armtrue/campaign/stated_covariance.h"
#include "armtrue/import/import_io.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "import/presets.h"
#include "support/temporary_file.h"

namespace armtrue::import_preset_test {
namespace {

using ::testing::HasSubstr;

ImportOptions with(const std::vector<std::string>& presets) {
  ImportOptions options;
  options.presets = presets;
  return options;
}

ImportedReadings import_two(const std::string& points, const std::string& joints,
                            const ImportOptions& options) {
  return import_readings(TemporaryFile(points).path, TemporaryFile(joints).path, options);
}

std::string error_of(const std::string& points, const std::string& joints,
                     const ImportOptions& options) {
  try {
    import_two(points, joints, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

const std::string kTwoJointRows =
    "A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg]\n10,0,0,0,0,0\n20,0,0,0,0,0\n";
const Eigen::Quaterniond kTurned(0.5, 0.5, 0.5, -0.5);
const std::string kTwoPoints = "X [mm],Y [mm],Z [mm]\n1,2,3\n4,5,6\n";

// Structure after a point export of SpatialAnalyzer 2024.2, github.com/20korvin01/IVR_Ue3,
// data/Tracker/Pose1Stationaer.txt (with collection, group and time) and data/tracker/pose1.txt
// (point names alone, no comments); the options of the export after the user's manual of New River
// Kinematics, "Exporting ASCII Formatted Points".
const std::string kSpatialAnalyzer =
    "// SpatialAnalyzer SA 2024.2.0923.4 ( x64 )  \n"
    "// Points Relative to Coordinate Frame 'A::WORLD'\n"
    "// AXES = CARTESIAN: X,  Y,  Z (mm)\n"
    "Cell,  Pose1,  1,  2296.337348,  -2416.230526,  -442.575667,  02/12/25 16:38:29\n"
    "Cell,  Pose2,  1,  1296.336406,  -1416.231477,  442.575360,  02/12/25 16:39:31\n";

TEST(ImportPreset, PointsOfSpatialAnalyzerHaveTheUnitOfTheirAxes) {
  ImportOptions options = with({"spatialanalyzer"});
  options.join = "order";
  options.columns = {"pose=Group", "target=Point"};
  const Campaign campaign = import_two(kSpatialAnalyzer, kTwoJointRows, options).campaign;
  ASSERT_EQ(campaign.rows(), 2);
  EXPECT_EQ(campaign.pose_ids, (std::vector<std::string>{"Pose1", "Pose2"}));
  EXPECT_EQ(campaign.target_names, (std::vector<std::string>{"1"}));
  EXPECT_NEAR(campaign.position[1].x(), 1.296336406, 1e-12);
  EXPECT_NEAR(campaign.position[0].z(), -0.442575667, 1e-12);
  EXPECT_EQ(campaign.time_s[1] - campaign.time_s[0], 62);
}

TEST(ImportPreset, PointsOfSpatialAnalyzerOfTwoDaysAreADayApart) {
  std::string points = kSpatialAnalyzer;
  const size_t second = points.rfind("02/12/25 16:39:31");
  points.replace(second, 8, "03/12/25");
  ImportOptions options = with({"spatialanalyzer"});
  options.join = "order";
  options.columns = {"pose=Group", "target=Point"};
  EXPECT_THAT(error_of(points, kTwoJointRows, options), HasSubstr("--dates"));
  options.dates = "day-first";
  const Campaign campaign = import_two(points, kTwoJointRows, options).campaign;
  EXPECT_EQ(campaign.time_s[1] - campaign.time_s[0], 86400 + 62);
}

TEST(ImportPreset, DatesOfSpatialAnalyzerHaveTheFormsOfOtherTables) {
  ImportOptions options = with({"spatialanalyzer"});
  options.join = "order";
  options.columns = {"pose=Group", "target=Point"};
  const auto with_times = [](const std::string& first, const std::string& second) {
    std::string points = kSpatialAnalyzer;
    for (const auto& [old, now] :
         {std::pair("02/12/25 16:38:29", first), std::pair("02/12/25 16:39:31", second)})
      points.replace(points.find(old), std::string_view(old).size(), now);
    return points;
  };
  const std::vector<std::pair<std::string, std::string>> alike{
      {"12/2/2025 4:38:29 PM", "12/2/2025 4:39:31 PM"},
      {"12/2/2025 11:59:29 AM", "12/2/2025 12:00:31 PM"},
      {"12/02/25 04:38:29 p.m.", "12/02/25 04:39:31 p.m."},
      {"2025-12-02T16:38:29", "2025-12-02T16:39:31"},
      {"2025-12-02 16:38:29.500", "2025-12-02 16:39:31.500"},
      {"2025-12-02T16:38:29+01:00", "2025-12-02T16:39:31+01:00"},
      {"02.12.2025 23:59:29", "03.12.2025 00:00:31"},
      {"12/31/2025 11:59:29 PM", "1/1/2026 12:00:31 AM"},
      {"2025/12/02 16:38:29", "2025/12/02 16:39:31"}};
  for (const auto& [first, second] : alike) {
    const Campaign campaign =
        import_two(with_times(first, second), kTwoJointRows, options).campaign;
    EXPECT_EQ(campaign.time_s[1] - campaign.time_s[0], 62) << first;
  }
  EXPECT_THAT(
      error_of(with_times("2/3/2025 4:38:29 PM", "3/3/2025 4:38:29 PM"), kTwoJointRows, options),
      HasSubstr("--dates day-first or --dates month-first"));
  EXPECT_THAT(
      error_of(with_times("Tue Dec 2 2025", "Tue Dec 2 2025"), kTwoJointRows, options),
      HasSubstr(":4: ends with 'Tue Dec 2 2025', which is neither a coordinate nor a date"));
}

// An instrument writes dates where a controller writes times of day alone.
TEST(ImportPreset, DatesOfOneDayJoinTimesOfDay) {
  ImportOptions options;
  options.join = "time";
  const std::string joints =
      "Time,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg]\n16:38:29,10,0,0,0,0,0\n"
      "16:38:29.02,10,0,0,0,0,0\n";
  const auto points = [](const std::string& second) {
    return "Time,X [mm],Y [mm],Z [mm]\n2025-12-02 16:38:29.01,1,2,3\n" + second + ",4,5,6\n";
  };
  for (const char* join : {"time", "stops"}) {
    options.join = join;
    if (options.join == "stops") options.clock_offset_s = 0;
    EXPECT_THAT(error_of(points("2025-12-03 16:38:29.01"), joints, options),
                HasSubstr("its times are dates without a time zone"))
        << join;
  }
  options.join = "time";
  EXPECT_EQ(import_two(points("2025-12-02 16:38:29.02"), joints, options).campaign.rows(), 2);
}

// Nothing but zeros says that the body was never seen, not that it stands at the origin.
TEST(ImportPreset, ABodyThatIsNeverSeenIsNamed) {
  const std::string vicon =
      "Objects\n100\n,,tool:tool,,,,,\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ\n,,deg,deg,deg,mm,mm,mm\n"
      "1,0,0,0,0,0,0,0\n2,0,0,0,0,0,0,0\n";
  ImportOptions options = with({"vicon"});
  options.join = "order";
  options.angles = "rotvec";
  EXPECT_THAT(error_of(vicon, kTwoJointRows, options),
              HasSubstr("'tool:tool' is seen in none of the frames"));
}

TEST(ImportPreset, PointsOfSpatialAnalyzerMayHaveFewerNames) {
  ImportOptions options = with({"spatialanalyzer"});
  options.length_unit = "mm";
  options.join = "order";
  const Campaign campaign =
      import_two("1,  2296.5,  -2416.25,  -442.5\n2,  2331.5,  -2328.5,  -547.75\n", kTwoJointRows,
                 options)
          .campaign;
  EXPECT_EQ(campaign.pose_ids, (std::vector<std::string>{"1", "2"}));
  EXPECT_NEAR(campaign.position[1].z(), -0.54775, 1e-12);
}

TEST(ImportPreset, WhatElseSpatialAnalyzerCanExportIsRefused) {
  const auto error = [&](const std::string& text) {
    ImportOptions options = with({"spatialanalyzer"});
    options.length_unit = "mm";
    return error_of(text, kTwoJointRows, options);
  };
  EXPECT_THAT(error("// AXES = SPHERICAL: R, T, P (mm)\nP1, 1.5, 2.5, 3.5\nP2, 1.5, 2.5, 3.5\n"),
              HasSubstr(":1: the coordinates are not Cartesian"));
  // Point, X, Y, Z and two offsets; they must not be taken for names and coordinates.
  EXPECT_THAT(error("P1, 1.5, 2.5, 3.5, 0.0, 19.05\nP2, 1.5, 2.5, 3.5, 0.0, 19.05\n"),
              HasSubstr("looks like a coordinate where a name should stand"));
  EXPECT_THAT(error("P1 1.5 2.5 3.5\nP2 1.5 2.5 3.5\n"), HasSubstr("with commas between them"));
  EXPECT_THAT(error("P1, 1.5, 2.5, 3.5\nP2, 1.5, 2.5\n"), HasSubstr(":2: has 3 cells"));
  EXPECT_THAT(error("P1, 1.5, 2.5, 3.5\nP2, 1.5, 25, 3.5\n"), HasSubstr("'25' is no coordinate"));
}

// Structure after a CSV export of Motive, github.com/ropensci/pathviewr,
// inst/extdata/pathviewr_motive_example_data.csv; the options after docs.optitrack.com, "Data
// Export: CSV".
std::string motive(const std::string& rotation, const std::string& units) {
  return "Format Version,1.23,Take Name,t,Rotation Type," + rotation + ",Length Units," + units +
         ",Coordinate Space,Global\n\n"
         ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid "
         "Body,Marker,Marker,Marker\n"
         ",Name,tool,tool,tool,tool,tool,tool,tool,tool,tool:Marker1,tool:Marker1,tool:Marker1\n"
         ",ID,\"9E2\",\"9E2\",\"9E2\",\"9E2\",\"9E2\",\"9E2\",\"9E2\",\"9E2\",\"1\",\"1\",\"1\"\n"
         ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker "
         "Error,Position,Position,Position\n"
         "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n"
         "100,1.0,0.5,0.5,-0.5,0.5,0.25,1.5,-2.125,0.0001,9,9,9\n"
         "101,1.01,,,,,,,,,9,9,9\n"
         "102,1.02,0,0,0,1,0.75,1.5,-2.125,0.0001,8,8,8\n";
}

TEST(ImportPreset, ARigidBodyOfMotiveHasPositionAndQuaternion) {
  ImportOptions options = with({"optitrack"});
  options.join = "order";
  const std::string joints = kTwoJointRows + "30,0,0,0,0,0\n";
  const ImportedReadings readings = import_two(motive("Quaternion", "Meters"), joints, options);
  const Campaign& campaign = readings.campaign;
  ASSERT_EQ(campaign.rows(), 2);  // in the second frame the body is hidden
  EXPECT_EQ(campaign.position[1], Eigen::Vector3d(0.75, 1.5, -2.125));
  EXPECT_LT(campaign.orientation[0].angularDistance(kTurned), 1e-12);
  EXPECT_EQ(campaign.time_s[1], 1.02);
  EXPECT_THAT(readings.mapping, HasSubstr("body 'tool'"));
  EXPECT_THAT(readings.mapping, HasSubstr("not used: tool:Marker1"));
  const Campaign in_mm = import_two(motive("Quaternion", "Millimeters"), joints, options).campaign;
  EXPECT_NEAR(in_mm.position[1].x(), 0.75e-3, 1e-15);
  options.body = "tool:Marker1";
  const Campaign marker = import_two(motive("Quaternion", "Meters"), joints, options).campaign;
  EXPECT_EQ(marker.rows(), 3);
  EXPECT_FALSE(marker.has_orientation());
  EXPECT_EQ(marker.position[2].x(), 8);
}

TEST(ImportPreset, WhatMotiveExportsOtherwiseIsRefused) {
  ImportOptions options = with({"optitrack"});
  options.join = "order";
  EXPECT_THAT(error_of(motive("XYZ", "Meters"), kTwoJointRows, options),
              HasSubstr("export with the rotation type Quaternion"));
  EXPECT_THAT(error_of(motive("Quaternion", "Furlongs"), kTwoJointRows, options),
              HasSubstr("has the unit 'Furlongs'"));
  EXPECT_THAT(error_of("Frame,Time\n", kTwoJointRows, options), HasSubstr("'Format Version'"));
  options.body = "hand";
  EXPECT_THAT(error_of(motive("Quaternion", "Meters"), kTwoJointRows, options),
              HasSubstr("it has tool, tool:Marker1"));
}

// Trajectories after the first frames of an export in "Vicon: Data format documentation" of
// ccu.uni-konstanz.de; objects and segments (RX to TZ, also with RW) after public readers of such
// exports, one of them github.com/AG6GR/Vicon_CSV. Neither says whether RX, RY, RZ are a rotation
// vector: the user does.
TEST(ImportPreset, BodiesOfViconHaveTimesByTheRateOfFrames) {
  ImportOptions options = with({"vicon"});
  options.join = "order";
  const Campaign quaternions =
      import_two(
          "Objects\n100\n,,tool:tool,,,,,,\nFrame,Sub Frame,RX,RY,RZ,RW,TX,TY,TZ\n"
          ",,,,,,mm,mm,mm\n250,0,0.5,0.5,-0.5,0.5,1000,200,3\n260,0,0,0,0,1,1001,200,3\n",
          kTwoJointRows, options)
          .campaign;
  EXPECT_EQ(quaternions.time_s, (std::vector<double>{2.5, 2.6}));
  EXPECT_NEAR(quaternions.position[1].x(), 1.001, 1e-15);
  EXPECT_LT(quaternions.orientation[0].angularDistance(kTurned), 1e-12);
  const std::string segments =
      "Segments\n200\n,,Tool,,,,,,Cart,,,,,\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ,RX,RY,RZ,TX,TY,TZ\n"
      ",,deg,deg,deg,mm,mm,mm,deg,deg,deg,mm,mm,mm\n"
      "1,0,0,0,90,1,2,3,0,0,0,9,9,9\n2,0,0,0,0,4,5,6,0,0,0,9,9,9\n";
  EXPECT_THAT(error_of(segments, kTwoJointRows, options), HasSubstr("--body NAME"));
  options.body = "Tool";
  EXPECT_THAT(error_of(segments, kTwoJointRows, options), HasSubstr("--angles rotvec"));
  options.angles = "rotvec";
  const Campaign turned = import_two(segments, kTwoJointRows, options).campaign;
  EXPECT_NEAR(turned.orientation[0].angularDistance(
                  Eigen::Quaterniond(Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitZ()))),
              0, 1e-9);
  EXPECT_EQ(turned.position[1].x(), 4e-3);
  const ImportOptions plain = [] {
    ImportOptions some = with({"vicon"});
    some.join = "order";
    return some;
  }();
  const Campaign marker =
      import_two(
          "Trajectories;;;;\n100;;;;\n;;1 1936;;\nFrame;Sub Frame;X;Y;Z\n;;mm;mm;mm\n"
          "1;0;-391.888;-6180.01;1734.43\n2;0;-391.978;-6180.03;1734.43\n",
          kTwoJointRows, plain)
          .campaign;
  EXPECT_NEAR(marker.position[1].x(), -0.391978, 1e-12);
  EXPECT_FALSE(marker.has_orientation());
}

TEST(ImportPreset, BodiesThatViconDidNotSeeAreNoReadings) {
  ImportOptions options = with({"vicon"});
  options.join = "order";
  const std::string joints = kTwoJointRows + "30,0,0,0,0,0\n";
  for (const std::string table :
       {"Objects\n100\n,,tool:tool,,,,,,\nFrame,Sub Frame,RX,RY,RZ,RW,TX,TY,TZ\n,,,,,,mm,mm,mm\n"
        "1,0,0,0,0,1,1000,200,3\n2,0,0,0,0,0,0,0,0\n3,0,0,0,0,1,1001,200,3\n",
        "Trajectories\n100\n,,tip,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n"
        "1,0,1000,200,3\n2,0,0,0,0\n3,0,1001,200,3\n",
        "Trajectories;;;;\n100;;;;\n;;tip;;\nFrame;Sub Frame;X;Y;Z\n;;mm;mm;mm\n"
        "1;0;1000,0;200;3\n2;0;0,000;0,000;0,000\n3;0;1001,0;200;3\n"}) {
    const Campaign campaign = import_two(table, joints, options).campaign;
    ASSERT_EQ(campaign.rows(), 2);
    EXPECT_NEAR(campaign.position[1].x(), 1.001, 1e-12);
  }
}

// Header, titles, first row and the order of the matrix after an export of
// github.com/shiplab/dt_cv, data/basin/raw; the facts of 3D files after docs.qualisys.com, "Motion
// data (.tsv)".
std::string qualisys(const std::string& included, const std::string& titles,
                     const std::string& rows) {
  return "NO_OF_FRAMES\t3\nNO_OF_CAMERAS\t4\nFREQUENCY\t100\nDESCRIPTION\t--\n"
         "TIME_STAMP\t2020-01-22, 17:47:17\t22107.99\nDATA_INCLUDED\t" +
         included + "\n" + titles + "\n" + rows;
}

TEST(ImportPreset, RigidBodiesOfQualisysHaveTheirMatrixColumnByColumn) {
  ImportOptions options = with({"qualisys"});
  options.join = "order";
  const std::string of_body =
      "\tY\tZ\tRoll\tPitch\tYaw\tResidual\tRot[0]\tRot[1]\tRot[2]\tRot[3]\t"
      "Rot[4]\tRot[5]\tRot[6]\tRot[7]\tRot[8]";
  const std::string zeros = "\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0";
  const std::string table = qualisys(
      "6D",
      "BODY_NAMES\tPSVH\tcarriage 2\nFrame\tTime\tPSVH X" + of_body + "\tcarriage 2 X" + of_body,
      "1\t0.00000\t-194.91974\t2.24150\t0.99661\t-0.65630\t0.09391\t0.05772\t4.98536\t1.00000\t"
      "0.00099\t-0.00165\t-0.00101\t0.99993\t-0.01145\t0.00164\t0.01145\t0.99993" +
          zeros +
          "\n"
          "2\t0.01000" +
          zeros + zeros +
          "\n"
          "3\t0.02000\t-198.5\t1.5\t0.25\t0\t0\t0\t1\t0\t0\t-1\t1\t0\t0\t0\t-1\t0" +
          zeros + "\n");
  const std::string joints = kTwoJointRows + "30,0,0,0,0,0\n";
  EXPECT_THAT(error_of(table, joints, options), HasSubstr("--body NAME"));
  options.body = "PSVH";
  const Campaign campaign = import_two(table, joints, options).campaign;
  ASSERT_EQ(campaign.rows(), 2);  // in the second frame the body is hidden
  EXPECT_NEAR(campaign.position[0].x(), -0.19491974, 1e-15);
  EXPECT_EQ(campaign.time_s[1], 0.02);
  const auto about = [](double degrees, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(degrees * kDegree, axis);
  };
  const Eigen::Quaterniond by_angles(about(-0.65630, Eigen::Vector3d::UnitX()) *
                                     about(0.09391, Eigen::Vector3d::UnitY()) *
                                     about(0.05772, Eigen::Vector3d::UnitZ()));
  EXPECT_LT(campaign.orientation[0].angularDistance(by_angles), 3e-5);  // of five decimals
  EXPECT_LT(campaign.orientation[1].angularDistance(kTurned), 1e-12);
}

TEST(ImportPreset, MarkersOfQualisysArePoints) {
  ImportOptions options = with({"qualisys"});
  options.join = "order";
  options.body = "ball 1";
  const std::string titles =
      "MARKER_NAMES\tball 1\tfoot\nTRAJECTORY_TYPES\tMeasured\tMixed\n"
      "Frame\tTime\tball 1 X\tball 1 Y\tball 1 Z\tfoot X\tfoot Y\tfoot Z";
  const std::string rows = "1\t0.5\t10\t20\t30\t1\t2\t3\t\n2\t0.6\t11\t21\t31\t1\t2\t3\t\n";
  const Campaign campaign =
      import_two(qualisys("3D", titles, rows), kTwoJointRows, options).campaign;
  EXPECT_NEAR(campaign.position[1].x(), 0.011, 1e-15);
  EXPECT_FALSE(campaign.has_orientation());
  const std::string lost = "3\t0.7\t0.000\t0.000\t0.000\t1\t2\t3\t\n";
  EXPECT_EQ(
      import_two(qualisys("3D", titles, rows + lost), kTwoJointRows + "30,0,0,0,0,0\n", options)
          .campaign.rows(),
      2);
  EXPECT_THAT(error_of(qualisys("3D", "MARKER_NAMES\tball 1\tfoot", rows), kTwoJointRows, options),
              HasSubstr("no line above the data names a column Time"));
  EXPECT_THAT(error_of(qualisys("2D", titles, rows), kTwoJointRows, options),
              HasSubstr("holds '2D' data"));
  EXPECT_THAT(error_of("Frame\tTime\n1\t0\n", kTwoJointRows, options),
              HasSubstr("begins with NO_OF_FRAMES"));
}

// Structure after `rostopic echo -p`: transforms as in a file of the tests of
// github.com/MichaelGrupp/evo, joint states as public readers of such files name their columns
// (%time, field.name0, field.position0). Units after sensor_msgs/JointState and REP 103; the stamps
// count nanoseconds since 1970.
const std::string kRostopicJoints =
    "%time,field.header.seq,field.header.stamp,field.name0,field.name1,field.name2,field.name3,"
    "field.name4,field.name5,field.position0,field.position1,field.position2,field.position3,"
    "field.position4,field.position5,field.velocity0\n"
    "1739641583661579370,0,1739641583660000000,elbow_joint,shoulder_lift_joint,shoulder_pan_joint,"
    "wrist_1_joint,wrist_2_joint,wrist_3_joint,0.3,0.2,0.1,0.4,0.5,0.6,0\n"
    "1739641585661579370,1,1739641585660000000,elbow_joint,shoulder_lift_joint,shoulder_pan_joint,"
    "wrist_1_joint,wrist_2_joint,wrist_3_joint,1.3,1.2,1.1,1.4,1.5,1.6,0\n";

TEST(ImportPreset, JointsOfRosAreFoundByTheirNames) {
  ImportOptions options = with({"rostopic-joints"});
  options.join = "order";
  EXPECT_THAT(error_of(kTwoPoints, kRostopicJoints, options), HasSubstr("give --robot"));
  options.robot = read_robot(std::string(ARMTRUE_CONFIG) + "/robots/ur5e.yaml").robot;
  const Campaign campaign = import_two(kTwoPoints, kRostopicJoints, options).campaign;
  EXPECT_EQ(campaign.q[0], (JointVector(6) << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6).finished());
  EXPECT_EQ(campaign.time_s[0], 0);
  EXPECT_NEAR(campaign.time_s[1], 2, 1e-6);
  std::string another = kRostopicJoints;
  another.replace(another.rfind("elbow_joint"), 11, "grip_finger");
  EXPECT_THAT(error_of(kTwoPoints, another, options), HasSubstr(":3: column 'field.name0'"));
  options.robot.reset();
  options.columns = {"q1_deg=field.position2", "q2_deg=field.position1", "q3_deg=field.position0",
                     "q4_deg=field.position3", "q5_deg=field.position4", "q6_deg=field.position5"};
  options.angle_unit = "rad";
  EXPECT_EQ(import_two(kTwoPoints, kRostopicJoints, options).campaign.q[1],
            (JointVector(6) << 1.1, 1.2, 1.3, 1.4, 1.5, 1.6).finished());
}

TEST(ImportPreset, TransformsOfRosAreMetres) {
  ImportOptions options = with({"rostopic-poses"});
  options.join = "order";
  const std::string transforms =
      "%time,field.transforms0.header.seq,field.transforms0.header.stamp,"
      "field.transforms0.header.frame_id,field.transforms0.child_frame_id,"
      "field.transforms0.transform.translation.x,field.transforms0.transform.translation.y,"
      "field.transforms0.transform.translation.z,field.transforms0.transform.rotation.x,"
      "field.transforms0.transform.rotation.y,field.transforms0.transform.rotation.z,"
      "field.transforms0.transform.rotation.w\n"
      "1739641583661579370,0,1739641583660682927,world,tool,-0.5,0.25,3.5,0.5,0.5,-0.5,0.5\n"
      "1739641584661579370,0,1739641584660682927,world,tool,-0.5,0.25,2.5,0,0,0,1\n";
  const Campaign campaign = import_two(transforms, kTwoJointRows, options).campaign;
  EXPECT_EQ(campaign.position[0], Eigen::Vector3d(-0.5, 0.25, 3.5));
  EXPECT_LT(campaign.orientation[0].angularDistance(kTurned), 1e-12);
  EXPECT_NEAR(campaign.time_s[1], 1, 1e-6);
}

// Names after the parsers of PlotJuggler (TOPIC/JOINT/position, __time) and an export of its CSV,
// in which a row has the values of one message alone, quoted in the comments of orca3's tools.
TEST(ImportPreset, OneExportOfPlotJugglerHasJointsAndPoses) {
  std::string text = "__time,/joint_states/header/stamp";
  for (int joint = 1; joint <= 7; ++joint)
    text += ",/joint_states/panda_joint" + std::to_string(joint) + "/position";
  text +=
      ",/joint_states/panda_joint1/velocity,/tool/pose/position/x,/tool/pose/position/y,"
      "/tool/pose/position/z,/tool/pose/orientation/x,/tool/pose/orientation/y,"
      "/tool/pose/orientation/z,/tool/pose/orientation/w\n";
  for (int k = 0; k < 40; ++k) {
    const std::string t = std::to_string(1624114603 + 0.05 * k);
    text += t + ",1,0.1,0.2,0.3,0.4,0.5,0.6,0.7,0,,,,,,,\n";
    if (k == 20) text += t + ",,,,,,,,,,1.5,2.5,3.5,0.5,0.5,-0.5,0.5\n";  // the same time
  }
  ImportOptions options = with({"plotjuggler-joints", "plotjuggler-poses"});
  options.join = "time";
  const TemporaryFile file(text);
  const ImportedReadings readings = import_readings(file.path, file.path, options);
  ASSERT_EQ(readings.campaign.rows(), 1);
  EXPECT_EQ(readings.joints.size(), 7u);
  EXPECT_NEAR(readings.campaign.q[0][6], 0.7, 1e-12);
  EXPECT_EQ(readings.campaign.position[0], Eigen::Vector3d(1.5, 2.5, 3.5));
}

// A record that went through a spreadsheet: its preset knows the names, the table says the rest.
TEST(ImportPreset, APresetWithAHeaderIsAPlainTable) {
  ImportOptions options = with({"ur-rtde"});
  options.join = "order";
  const std::string log =
      "Recorded on 2024-05-03\n# by hand\nTIMESTAMP ACTUAL_Q_0 actual_q_1 actual_q_2 actual_q_3 "
      "actual_q_4 actual_q_5\n10,002 0,5 -1,5 1,25 -2 1 0,25\n"
      "10,502 \"1.000,5\" -1,5 1,25 -2 1 0,25\n";
  const Campaign campaign = import_two(kTwoPoints, log, options).campaign;
  EXPECT_EQ(campaign.q[0], (JointVector(6) << 0.5, -1.5, 1.25, -2, 1, 0.25).finished());
  EXPECT_EQ(campaign.q[1][0], 1000.5);
  EXPECT_EQ(campaign.time_s[1], 10.502);
}

// Structure after the traces of a KUKA controller as CSV,
// github.com/anjan211/kuka_controller_project, Backlash/WINDOWS-V37DJA1 -
// 8101392_A2_PTP_aut_KRCIpo.csv, of which the first row is here: its axis 2 stands at -110 deg,
// which the file writes in rad below the unit deg. Tabs, blanks in the header and AxisPos_CmdIpo
// after public readers of such files.
const std::string kKukaTrace =
    "Zeit[sec];X_Act[mm];Y_Act[mm];Z_Act[mm];A_Act[\xC2\xB0];B_Act[\xC2\xB0];C_Act[\xC2\xB0];"
    "AxisPos_Act1[\xC2\xB0];AxisPos_Act2[\xC2\xB0];AxisPos_Act3[\xC2\xB0];AxisPos_Act4[\xC2\xB0];"
    "AxisPos_Act5[\xC2\xB0];AxisPos_Act6[\xC2\xB0];GearTorq_Act2[Nm];CartVel_Act[m/s]\n"
    "0.0;383.12554991352874;-26.74086675679162;577.7125677208195;-0.029374189262690992;"
    "0.5029123929378598;-0.018953585358498146;-0.0004927185988644372;-1.9202374293316917;"
    "1.9200003929949983;-0.00018695399715356362;4.780999350807995e-05;-7.707510865375742e-05;"
    "11.39288023009814;15453.021192816394\n"
    "0.012;383.1;-26.7;577.7;-0.02;0.5;-0.01;-0.0005;-1.92;1.92;-0.0002;0.00005;-0.00008;11.4;0\n";

TEST(ImportPreset, TheUnitOfAKukaTraceIsNotBelieved) {
  ImportOptions options = with({"kuka-trace"});
  options.join = "order";
  EXPECT_THAT(error_of(kTwoPoints, kKukaTrace, options),
              HasSubstr(":1: the unit of the column 'AxisPos_Act1[\xC2\xB0]' is not certain"));
  options.angle_unit = "rad";
  const ImportedReadings readings = import_two(kTwoPoints, kKukaTrace, options);
  const Campaign& campaign = readings.campaign;
  EXPECT_NEAR(campaign.q[0][1] / kDegree, -110.02, 0.01);
  EXPECT_NEAR(campaign.q[0][4], 4.780999350807995e-05, 1e-18);
  EXPECT_EQ(campaign.time_s[1], 0.012);
  EXPECT_EQ(campaign.position[1], Eigen::Vector3d(4e-3, 5e-3, 6e-3));  // not that of the controller
  EXPECT_THAT(readings.mapping, HasSubstr("X_Act[mm]                        not in the preset"));
  options.angle_unit = "deg";
  EXPECT_NEAR(import_two(kTwoPoints, kKukaTrace, options).campaign.q[0][1] / kDegree, -1.92, 0.01);
}

TEST(ImportPreset, AKukaTraceMayHoldCommandedAngles) {
  ImportOptions options = with({"kuka-trace"});
  options.join = "order";
  options.angle_unit = "deg";
  std::string trace = "Zeit [s]";
  for (int joint = 1; joint <= 6; ++joint)
    trace += "\tAxisPos_CmdIpo" + std::to_string(joint) + " [\xC2\xB0]";
  trace += "\n0.012\t1\t2\t3\t4\t5\t6\n0.024\t1\t2\t3\t4\t5\t7\n";
  const Campaign campaign = import_two(kTwoPoints, trace, options).campaign;
  EXPECT_NEAR(campaign.q[1][5], 7 * kDegree, 1e-15);
  // Where both are recorded, those that were measured count.
  std::string both = trace;
  for (int joint = 1; joint <= 6; ++joint)
    both.insert(both.find('\n'), "\tAxisPos_Act" + std::to_string(joint));
  for (size_t at = both.find("0.0"); at != std::string::npos; at = both.find("0.0", at + 1))
    both.insert(both.find('\n', at), "\t10\t20\t30\t40\t50\t60");
  EXPECT_NEAR(import_two(kTwoPoints, both, options).campaign.q[1][5], 60 * kDegree, 1e-14);
}

// Columns of geometry_msgs/PoseWithCovariance as `rostopic echo -p` and the CSV of PlotJuggler name
// them (field.pose.covariance0 to 35, /TOPIC/pose/covariance[0] to [35]), after the headers that
// public readers of such files quote. Order and meaning after the comments of the message: rows of
// 6, m and rad about fixed axes.
struct CovarianceTable {
  bool is_rostopic = true;
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;

  std::string text() const {
    const std::string topic = is_rostopic ? "field." : "/camera/";
    const std::string sign = is_rostopic ? "." : "/";
    std::string text = is_rostopic ? "%time" : "__time";
    for (const char axis : std::string("xyz"))
      text += "," + topic + "pose" + sign + "pose" + sign + "position" + sign + axis;
    for (const char axis : std::string("xyzw"))
      text += "," + topic + "pose" + sign + "pose" + sign + "orientation" + sign + axis;
    for (int k = 0; k < 36; ++k)
      text += "," + topic + "pose" + sign + "covariance" +
              (is_rostopic ? std::to_string(k) : "[" + std::to_string(k) + "]");
    for (size_t row = 0; row < covariances.size(); ++row) {
      text += "\n" + std::to_string(row + 1) + ",1,2,3,0.5,0.5,-0.5,0.5";
      for (int k = 0; k < 36; ++k) {
        std::ostringstream number;
        number << ',' << std::setprecision(17) << covariances[row](k / 6, k % 6);
        text += number.str();
      }
    }
    return text + "\n";
  }
};

Eigen::Matrix<double, 6, 6> some_covariance(double size) {
  std::mt19937 random(5);
  Eigen::Matrix<double, 6, 6> root;
  for (double& entry : root.reshaped()) entry = static_cast<double>(random() % 1000) / 1000 - 0.5;
  return size * (root * root.transpose());
}

TEST(ImportPreset, CovariancesOfRosAreThoseOfCampaigns) {
  for (const bool is_rostopic : {true, false}) {
    const CovarianceTable table{is_rostopic, {some_covariance(1e-6), some_covariance(4e-6)}};
    ImportOptions options = with({is_rostopic ? "rostopic-poses" : "plotjuggler-poses"});
    options.join = "order";
    const ImportedReadings readings = import_two(table.text(), kTwoJointRows, options);
    EXPECT_THAT(readings.mapping, HasSubstr("cov_xrx_mm_deg"));
    // To the file and back.
    const Campaign written =
        read_campaign(TemporaryFile(write_campaign(readings.campaign)).path).campaign;
    for (const Campaign& campaign : {readings.campaign, written})
      for (int row = 0; row < 2; ++row) {
        const auto& truth = table.covariances[static_cast<size_t>(row)];
        EXPECT_LT((stated_covariance(campaign, row) - truth).norm(), 1e-9 * truth.norm());
      }
  }
}

TEST(ImportPreset, AColumnBehindTheLastOfACovarianceIsNotOfIt) {
  ImportOptions options = with({"plotjuggler-poses"});
  options.join = "order";
  for (const char* number : {"36", "99999999999999"}) {
    std::string text =
        CovarianceTable{false, {some_covariance(1e-6), some_covariance(4e-6)}}.text();
    std::string cell = std::string(",/camera/pose/covariance[") + number + "]";
    for (size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1)) {
      text.insert(at, cell);
      at += cell.size();
      cell = ",0";
    }
    const ImportedReadings readings = import_two(text, kTwoJointRows, options);
    EXPECT_THAT(readings.mapping, HasSubstr("not in the preset")) << number;
    EXPECT_TRUE(stated_blocks(readings.campaign).rotation) << number;
  }
}

TEST(ImportPreset, WhatRosDoesNotKnowIsNoCovariance) {
  ImportOptions options = with({"rostopic-poses"});
  options.join = "order";
  const Eigen::Matrix<double, 6, 6> zero = Eigen::Matrix<double, 6, 6>::Zero();
  const ImportedReadings unknown =
      import_two(CovarianceTable{true, {zero, zero}}.text(), kTwoJointRows, options);
  EXPECT_FALSE(stated_blocks(unknown.campaign).any());
  EXPECT_THAT(unknown.warnings.front(), HasSubstr("all covariances are zero"));
  Eigen::Matrix<double, 6, 6> points = zero;
  points.diagonal().head<3>().setConstant(1e-6);
  const Campaign of_points =
      import_two(CovarianceTable{true, {points, points}}.text(), kTwoJointRows, options).campaign;
  EXPECT_TRUE(stated_blocks(of_points).position);
  EXPECT_FALSE(stated_blocks(of_points).rotation);
  EXPECT_EQ(write_campaign(of_points).find("cov_rx"), std::string::npos);

  const auto error = [&](const Eigen::Matrix<double, 6, 6>& second) {
    return error_of(CovarianceTable{true, {some_covariance(1e-6), second}}.text(), kTwoJointRows,
                    options);
  };
  Eigen::Matrix<double, 6, 6> askew = some_covariance(1e-6);
  askew(0, 1) *= 2;
  EXPECT_THAT(error(askew), HasSubstr(":3: column 'field.pose.covariance6'"));
  EXPECT_THAT(error(zero), HasSubstr("column 'field.pose.covariance0': '0' begins a covariance"));
  std::string cut = CovarianceTable{true, {points, points}}.text();
  cut.replace(cut.find("covariance35"), 12, "other");
  EXPECT_THAT(error_of(cut, kTwoJointRows, options),
              HasSubstr("35 of the 36 columns of a covariance"));
  EXPECT_THAT(error_of(cut, kTwoJointRows, options), HasSubstr("'field.pose.covariance*'"));
  options.ignored = {"field.pose.covariance*"};
  EXPECT_FALSE(stated_blocks(import_two(cut, kTwoJointRows, options).campaign).any());
}

TEST(ImportPreset, EachIsForOneTable) {
  EXPECT_THAT(error_of(kTwoPoints, kTwoJointRows, with({"optitrack", "vicon"})),
              HasSubstr("are both for the table of points"));
  for (const Preset& preset : presets()) EXPECT_EQ(find_preset(preset.name), &preset);
}

// The recorder of a cell, which nobody here has seen, in a file of its user.
const std::string kOwnPreset =
    "format: armtrue-preset/1\nname: our recorder\nof: joints\nseparators: \"|\"\n"
    "columns:\n  - {header: Stamp, is: t, unit: ms}\n  - {header: \"Axis-{n}\", is: q, unit: "
    "rad}\n";

TEST(ImportPreset, MayBeAFileOfTheUser) {
  const TemporaryFile preset(kOwnPreset);
  ImportOptions options = with({preset.path});
  options.join = "order";
  const std::string joints =
      "Stamp|Axis-2|Axis-1|Axis-3|Axis-4|Axis-5|Axis-6|Load\n500|0.2|0.1|0.3|0.4|0.5|0.6|7\n"
      "1500|1.2|1.1|1.3|1.4|1.5|1.6|7\n";
  const Campaign campaign = import_two(kTwoPoints, joints, options).campaign;
  EXPECT_EQ(campaign.q[0], (JointVector(6) << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6).finished());
  EXPECT_EQ(campaign.q[1], (JointVector(6) << 1.1, 1.2, 1.3, 1.4, 1.5, 1.6).finished());
}

TEST(ImportPreset, WhatIsWrongInAFileIsNamedByLine) {
  const auto error = [](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    try {
      parse_preset(text, "own.yaml");
    } catch (const InputError& thrown) {
      return std::string(thrown.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error(kOwnPreset, "of: joints", "of: robots"),
              HasSubstr("neither points nor joints"));
  EXPECT_THAT(error(kOwnPreset, "unit: rad", "unit: grad"), HasSubstr("own.yaml:7"));
  EXPECT_THAT(error(kOwnPreset, "unit: ms", "unit: mm"), HasSubstr("'mm' is no unit of 't'"));
  EXPECT_THAT(error(kOwnPreset, "Axis-{n}", "Axis"), HasSubstr("does not say which joint"));
  EXPECT_THAT(error(kOwnPreset, "is: t", "is: torque"), HasSubstr("nothing that a reading has"));
  EXPECT_THAT(error(kOwnPreset, "is: t", "iss: t"), HasSubstr("iss"));
  EXPECT_THAT(error(kOwnPreset, "Axis-{n}", "*a*a{n}"), HasSubstr("at most 200 characters"));
  EXPECT_THAT(error(kOwnPreset, "Stamp", std::string(201, 's')),
              HasSubstr("at most 200 characters"));
}

}  // namespace
}  // namespace armtrue::import_preset_test
