#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "armtrue/import/import_io.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "import/column_names.h"
#include "import/plain_cell.h"
#include "support/temporary_file.h"

namespace armtrue::import_test {
namespace {

using ::testing::HasSubstr;

ImportedReadings import_text(const std::string& text, const ImportOptions& options = {}) {
  return import_readings(TemporaryFile(text).path, options);
}

ImportedReadings import_two(const std::string& points, const std::string& joints,
                            const ImportOptions& options = {}) {
  return import_readings(TemporaryFile(points).path, TemporaryFile(joints).path, options);
}

template <typename Import>
std::string error_of(const Import& import) {
  try {
    import();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of_text(const std::string& text, const ImportOptions& options = {}) {
  return error_of([&] { import_text(text, options); });
}

// ---- cells

TEST(ImportCell, TheDecimalSignIsToldOnlyWhereOneReadingIsPossible) {
  for (const char* cell : {"1.5", "0.123", "1234.567", "1,260.8967", "1,260,300", "-.25", "1.5e-3"})
    EXPECT_EQ(decimal_evidence(cell), DecimalEvidence::point) << cell;
  for (const char* cell : {"1,5", "0,123", "1234,567", "1.260,8967", "1.260.300", "-,25", "1,5E+3"})
    EXPECT_EQ(decimal_evidence(cell), DecimalEvidence::comma) << cell;
  for (const char* cell : {"1,260", "1.260", "-12.345", "999,000"})
    EXPECT_EQ(decimal_evidence(cell), DecimalEvidence::ambiguous) << cell;
  for (const char* cell : {"12", "-7", "+3e2", "1 260"})
    EXPECT_EQ(decimal_evidence(cell), DecimalEvidence::none) << cell;
  for (const char* cell : {"", "-", "n/a", "nan", "inf", "1.2.3", "1,26.5", "12 5", "1,2,3", "0x1F",
                           "1.5 mm", "1e", "1e999", "--1", "1,260.89,67"})
    EXPECT_EQ(decimal_evidence(cell), DecimalEvidence::no_number) << cell;
}

TEST(ImportCell, ThousandsAreReadInGroupsOfThree) {
  EXPECT_EQ(plain_number("1.260,8967", ',')->value, 1260.8967);
  EXPECT_EQ(plain_number("-1,260,300.5", '.')->value, -1260300.5);
  EXPECT_EQ(plain_number("1'260.5", '.')->value, 1260.5);
  EXPECT_EQ(plain_number("1\xC2\xA0"
                         "260,5",
                         ',')
                ->value,
            1260.5);
  EXPECT_EQ(plain_number("\xE2\x88\x92"
                         "3.5",
                         '.')
                ->value,
            -3.5);
  EXPECT_FALSE(plain_number("1.260,8967", ',')->ambiguous);
  EXPECT_TRUE(plain_number("1,260", '.')->ambiguous);
  EXPECT_FALSE(plain_number("12,60.5", '.'));
  EXPECT_FALSE(plain_number("0,260.5", '.'));
}

TEST(ImportCell, TimesAreIso) {
  const auto first = plain_time("2024-02-28T23:59:59.75");
  const auto second = plain_time("2024-03-01 00:00:00");
  ASSERT_TRUE(first && second);
  EXPECT_EQ(seconds_between(*second, *first), 86400.25);  // 2024 has a 29th of February
  EXPECT_EQ(seconds_between(*plain_time("2024-05-03T12:00:00+02:00"),
                            *plain_time("2024-05-03T10:00:00Z")),
            0);
  EXPECT_EQ(plain_time("12:30:01.5")->seconds, 45001.5);
  EXPECT_EQ(plain_time("12:30:01.5 PM")->seconds, 45001.5);
  EXPECT_EQ(plain_time("12:30:01 AM")->seconds, 1801);
  EXPECT_EQ(plain_time("1:05:06\u202fp.m.")->seconds, 47106);
  EXPECT_EQ(seconds_between(*plain_time("5/3/2024 1:00:00 PM", DateOrder::month_first),
                            *plain_time("5/3/2024 11:59:00 am", DateOrder::month_first)),
            3660);
  for (const char* text :
       {"2023-02-29T00:00:00", "12:30", "24:00:00", "12:60:00", "12:00:60", "13:00:00 PM",
        "0:30:00 AM", "12:00:00 P", "12.5", "2024-05-03T12:00:00+2", "12:00:00Z",
        "03.05.24 12:00:00", "30.2.2024 12:00:00", "3.5/2024 12:00:00", "2024-13-01 12:00:00"})
    EXPECT_FALSE(plain_time(text)) << text;
}

TEST(ImportCell, DatesHaveTheDayFirstBehindPointsAndInTheStatedOrderBehindSlashes) {
  const auto day = plain_date("2024-05-03");
  ASSERT_TRUE(day);
  for (const char* text : {"3.5.2024", "03.05.2024", "2024/05/03", "2024.5.3", "3-May-2024",
                           "03 may 2024", "2024-May-03", "03.MAY.2024"})
    for (const DateOrder order : {DateOrder::day_first, DateOrder::month_first})
      EXPECT_EQ(plain_date(text, order), day) << text;
  EXPECT_EQ(plain_date("3/5/2024", DateOrder::day_first), day);
  EXPECT_EQ(plain_date("05-03-2024", DateOrder::month_first), day);
  EXPECT_FALSE(plain_date("13/5/2024", DateOrder::month_first));
  for (const char* text : {"3-Mai-2024", "3-ayj-2024", "3 5 2024", "May-03-2024", "3-May-24"})
    EXPECT_FALSE(plain_date(text)) << text;
  EXPECT_EQ(day_of("3.5.2024, 9:00:00", DateOrder::month_first), day);
  EXPECT_FALSE(day_of("9:00:00", DateOrder::day_first));
}

TEST(ImportCell, AUnitIsFoundInTheUsualWritings) {
  for (const char* header :
       {"A1 [rad]", "A1 (rad)", "A1_rad", "a1 rad", "A1/rad", "A1, rad", "A1[RAD]", "A1_[rad]",
        "A1 in rad", "Joint 1 (rad)", "axis_1.rad", "Achse 1 [rad]", "Axe 1 (rad)"}) {
    EXPECT_EQ(column_name(header).unit.size(), 3u) << header;
    ASSERT_TRUE(known_quantity(header)) << header;
    EXPECT_EQ(known_quantity(header)->name, "q1") << header;
  }
  EXPECT_EQ(known_quantity("Zeit [ms]")->name, "t");
  EXPECT_EQ(known_quantity("Punktname")->name, "pose");
  EXPECT_EQ(column_name("X").unit, "");
  EXPECT_EQ(column_name("x_m").unit, "m");
  EXPECT_EQ(known_quantity("X Pos"), std::nullopt);
  EXPECT_EQ(known_quantity("Delta X [mm]"), std::nullopt);
  EXPECT_TRUE(looks_like_angle("Azimuth", ""));
  EXPECT_TRUE(looks_like_angle("value", "deg"));
  EXPECT_FALSE(looks_like_angle("Comment", ""));
}

// ---- tables

const std::string kJoints = "A1,A2,A3,A4,A5,A6";
const ImportOptions kMmDeg = [] {
  ImportOptions options;
  options.length_unit = "mm";
  options.angle_unit = "deg";
  return options;
}();

TEST(ImportReadings, ATableOfASpreadsheetIsRead) {
  const ImportedReadings readings = import_text(
      "\xEF\xBB\xBFReport of the cell;;;;;;;;;\r\n# by hand\r\n"
      "Point;X (mm);Y_m;Z [in];J1;J2;J3;J4;J5;J6\r\n;;;;rad;\xC2\xB0;deg;deg;deg;deg\r\n"
      "P1;1.260,8967;0,5;2;0,5;90;0,5;0;0;0\r\n% a pause\r\n;;;;;;;;;\r\n");
  const Campaign& campaign = readings.campaign;
  ASSERT_EQ(campaign.rows(), 1);
  EXPECT_EQ(campaign.pose_ids[0], "P1");
  EXPECT_NEAR(campaign.position[0].x(), 1.2608967, 1e-15);
  EXPECT_NEAR(campaign.position[0].y(), 0.5, 1e-15);
  EXPECT_NEAR(campaign.position[0].z(), 0.0508, 1e-15);
  EXPECT_NEAR(campaign.q[0][0], 0.5, 1e-15);
  EXPECT_NEAR(campaign.q[0][1], std::acos(0.0), 1e-15);
  EXPECT_THAT(readings.mapping, HasSubstr("decimal comma"));
}

TEST(ImportReadings, WhatCanBeReadInTwoWaysIsRefused) {
  const std::string header = "X,Y,Z," + kJoints + "\n";
  EXPECT_THAT(error_of_text("X;Y;Z;A1;A2;A3;A4;A5;A6\n1,260;2;3;0;0;0;0;0;0\n", kMmDeg),
              HasSubstr("--decimal comma or --decimal point"));
  EXPECT_THAT(error_of_text("X;Y;Z;A1;A2;A3;A4;A5;A6\n1,5;2.5;3;0;0;0;0;0;0\n", kMmDeg),
              HasSubstr("write all numbers in one way"));
  EXPECT_THAT(error_of_text(header + "\"1,260\",2.5,3,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr(":2: column 'X': '1,260' can be read with"));
  EXPECT_THAT(error_of_text(header + "1,5,2,5,3,0,0,0,0,0,0\n", kMmDeg), HasSubstr("need quotes"));
  EXPECT_THAT(
      error_of_text(header + "1,2,3,0,0,0,0,0,0\n"),
      HasSubstr("--unit 'X=mm', or --length-unit mm; --unit 'A1=deg', or --angle-unit deg"));
  EXPECT_THAT(error_of_text("Point,ID,X,Y,Z," + kJoints + "\na,b,1,2,3,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr("could both be pose"));
  EXPECT_THAT(error_of_text("Target,X,Y,Z," + kJoints + "\na,1,2,3,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr("--column pose='Target' or --column target='Target'"));
  EXPECT_THAT(error_of_text("X,Y,Z,Azimuth," + kJoints + "\n1,2,3,4,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr("--ignore 'Azimuth'"));
  EXPECT_THAT(error_of_text("X,Y,Z,q0,q1,q2,q3,q4,q5\n1,2,3,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr("'q0' looks like an angle"));
  EXPECT_THAT(error_of_text("X [mm],Y,Z," + kJoints + "\nm,m,m,,,,,,\n1,2,3,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr("two units"));
}

TEST(ImportReadings, AnArmMayHaveAsManyJointsAsItsTableOrItsRobot) {
  const ImportedReadings seven =
      import_text("X,Y,Z," + kJoints + ",A7,E1 [mm]\n1,2,3,0,0,0,0,0,0,90,1250\n", kMmDeg);
  EXPECT_THAT(write_campaign(seven.campaign, seven.joints),
              HasSubstr("q6_deg,q7_deg,e1_mm,x_mm,y_mm,z_mm\n1,0,0,0,0,0,0,90,1250,1,2,3"));
  EXPECT_THAT(error_of_text("X,Y,Z,A1,A2,A3,A4,A5\n1,2,3,0,0,0,0,0\n", kMmDeg),
              HasSubstr("no column is known for q6_deg"));
  EXPECT_THAT(error_of_text("X,Y,Z," + kJoints + ",E1\n1,2,3,0,0,0,0,0,0,5\n", kMmDeg),
              HasSubstr("--unit 'E1=mm'"));
  ImportOptions rail = kMmDeg;
  rail.robot = read_robot(std::string(ARMTRUE_CONFIG) + "/robots/kr360-rail.yaml").robot;
  const ImportedReadings on_rail =
      import_text("X,Y,Z," + kJoints + ",E1,E2\n1,2,3,10,0,0,0,0,0,1250,0\n", rail);
  EXPECT_NEAR(on_rail.campaign.q[0][0], 1.25, 1e-15);
  EXPECT_NEAR(on_rail.campaign.q[0][1], 10 * kDegree, 1e-15);
  EXPECT_THAT(on_rail.mapping, HasSubstr("no axis of the robot, and it stands still"));
  EXPECT_THAT(
      error_of_text("X,Y,Z," + kJoints + ",E1,E2\n1,2,3,1,0,0,0,0,0,5,0\n1,2,3,2,0,0,0,0,0,5,1\n",
                    rail),
      HasSubstr(":3: column 'E2': '1' moves an axis that the robot does not have"));
  EXPECT_THAT(error_of_text("X,Y,Z," + kJoints + ",E1 [deg]\n1,2,3,1,0,0,0,0,0,5\n", rail),
              HasSubstr("which is none of e1_mm"));
  rail.columns = {"e1_mm=Rail"};
  EXPECT_NEAR(
      import_text("X,Y,Z," + kJoints + ",Rail\n1,2,3,10,0,0,0,0,0,1250\n", rail).campaign.q[0][0],
      1.25, 1e-15);
}

TEST(ImportReadings, NamesAboveTheHeaderAreNoHeader) {
  const std::string text =
      "Name,Date,Time\nstation,2024-05-03,12:00:00\nX,Y,Z," + kJoints + "\n1,2,3,0,0,0,0,0,0\n";
  EXPECT_THAT(import_text(text, kMmDeg).mapping, HasSubstr("header in line 3"));
}

// As many programs of instruments write points.
TEST(ImportReadings, BlanksSeparateWhereAllNamesAreKnown) {
  ImportOptions options;
  options.length_unit = "mm";
  options.angle_unit = "deg";
  const std::string header = "Name  X Y  Z A1 A2 A3 A4 A5 A6 \n";
  const Campaign campaign =
      import_text("Points of cell 4: X Y Z and A1 A2 A3\n" + header +
                      "P1   1.5 -2.5  3 10 20 30 40 50 60\n P2 1 2 3 11 21 31 41 51 61  \n",
                  options)
          .campaign;
  ASSERT_EQ(campaign.rows(), 2);
  EXPECT_NEAR(campaign.position[0].y(), -2.5e-3, 1e-15);
  EXPECT_NEAR(campaign.q[1][5], 61 * kDegree, 1e-15);
  // Nothing is taken for a blank between thousands.
  EXPECT_THAT(error_of_text(header + "P1 1 260 2.5 3 10 20 30 40 50 60\n", options),
              HasSubstr(":2: has 11 cells where the header in line 1 has 10"));
  EXPECT_THAT(
      error_of_text("Name X Y Z Weather A1 A2 A3 A4 A5 A6\nP1 1 2 3 4 5 6 7 8 9 10\n", options),
      HasSubstr("no header row with known names"));
}

TEST(ImportReadings, RowsWithoutAHeaderAreToldToHaveOne) {
  EXPECT_THAT(error_of_text("P1;-148.743;-3153.918;104.440;;;;\nP2;1032.733;-2673.7;97.282;;;;\n"),
              HasSubstr("put a line of names above them"));
  EXPECT_THAT(error_of_text("Report;of;cell;4\n"), Not(HasSubstr("put a line of names")));
}

TEST(ImportReadings, WhatTheWriterIsGivenItWrites) {
  const std::string text =
      "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,session,payload_kg,temp_arm_"
      "c\n"
      "a,1,2,3,4,5,6,7,8,9,day 1,120,31.5\nb,2,2,3,4,5,6,7,8,9.5,day 2,0,32\n";
  EXPECT_EQ(write_campaign(import_text(text).campaign), text);
}

TEST(ImportReadings, OptionsWithoutTheirColumnsAreRefused) {
  const std::string text = "X,Y,Z," + kJoints + "\n1,2,3,0,0,0,0,0,0\n";
  ImportOptions options = kMmDeg;
  options.angles = "rpy";
  EXPECT_THAT(error_of_text(text, options), HasSubstr("leave out --angles"));
  EXPECT_THAT(error_of_text("X,X,Y,Z," + kJoints + "\n1,1,2,3,0,0,0,0,0,0\n", kMmDeg),
              HasSubstr("'X' stands twice; rename"));
}

TEST(ImportReadings, AWordInThePlaceOfANumberIsALostReading) {
  const std::string rows = "Point,X,Y,Z," + kJoints + "\nNA,1,2,3,0,0,0,0,0,0\nb,";
  for (const std::string word : {"NaN", "---", "#N/A", "null", "n/a", "None", ""}) {
    const std::string text = rows + word + "," + word + "," + word + ",9,9,9,9,9,9\n";
    const Campaign campaign = import_text(text, kMmDeg).campaign;
    EXPECT_THAT(campaign.pose_ids, testing::ElementsAre("NA")) << word;
    EXPECT_EQ(campaign.skipped_rows, 1) << word;
  }
  EXPECT_THAT(error_of_text(rows + "NaN,2,3,9,9,9,9,9,9\n", kMmDeg), HasSubstr("empty"));
}

TEST(ImportReadings, ATurnIsNoTime) {
  const std::string row = "\n1,2,3,7,0,0,0,0,0,0\n";
  EXPECT_TRUE(import_text("X,Y,Z,T," + kJoints + row, kMmDeg).campaign.time_s.empty());
  EXPECT_EQ(import_text("X,Y,Z,T [s]," + kJoints + row, kMmDeg).campaign.time_s[0], 7);
}

TEST(ImportReadings, DegreesMayBeLatin1) {
  const ImportedReadings readings = import_text(
      "X [mm],Y [mm],Z [mm],A1 [\xB0],A2,A3,A4,A5,A6,Gr\xF6\xDF"
      "e\n1,2,3,90,0,0,0,0,0,x\n",
      kMmDeg);
  EXPECT_NEAR(readings.campaign.q[0][0], std::acos(0.0), 1e-15);
}

TEST(ImportReadings, RowsMayEndWithASeparatorThatTheHeaderLacks) {
  const std::string header = "Point;X;Y;Z;A1;A2;A3;A4;A5;A6\n";
  const Campaign campaign =
      import_text(header + "a;1;2;3;10;0;0;0;0;0;\nb;1;2;3;20;0;0;0;0;0;;\n", kMmDeg).campaign;
  EXPECT_EQ(campaign.pose_ids, (std::vector<std::string>{"a", "b"}));
  EXPECT_THAT(error_of_text(header + "a;1;2;3;10;0;0;0;0;0;7\n", kMmDeg),
              HasSubstr("has 11 cells where the header in line 1 has 10"));
}

TEST(ImportReadings, AConventionOfAnglesMustBeStated) {
  const auto table = [](const std::string& names) {
    return names + ",X,Y,Z," + kJoints + "\n0.1,0.2,0.3,1,2,3,0,0,0,0,0,0\n";
  };
  EXPECT_THAT(error_of_text(table("A,B,C"), kMmDeg), HasSubstr("--angles abc"));
  EXPECT_THAT(error_of_text(table("roll,pitch,yaw"), kMmDeg), HasSubstr("--angles rpy"));
  EXPECT_THAT(error_of_text(table("Rx,Ry,Rz"), kMmDeg), HasSubstr("--angles rotvec"));
  EXPECT_THAT(error_of_text(table("quat1,quat2,quat3") /* no fourth */, kMmDeg),
              HasSubstr("an orientation needs all"));
  ImportOptions wrong = kMmDeg;
  wrong.angles = "rotvec";
  EXPECT_THAT(error_of_text(table("A,B,C"), wrong), HasSubstr("does not fit"));
}

TEST(ImportReadings, OrientationsAgreeWithRotationsAboutAxes) {
  const double a = 0.7, b = -0.4, c = 1.9;
  using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector3d;
  const auto about = [](double angle, int axis) { return AngleAxisd(angle, Vector3d::Unit(axis)); };
  const Vector3d vector(a, b, c);
  const Quaterniond mixed = Quaterniond(about(a, 2) * about(b, 1) * about(c, 0));
  struct Case {
    std::string names, angles, quaternion;
    std::array<double, 4> numbers;
    Quaterniond expected;
  };
  const std::array<double, 4> wxyz{mixed.w(), mixed.x(), mixed.y(), mixed.z()};
  const std::array<double, 4> xyzw{mixed.x(), mixed.y(), mixed.z(), mixed.w()};
  const std::vector<Case> cases{{"A,B,C", "abc", "", {a, b, c, 0}, mixed},
                                {"a_rad,b_rad,c_rad", "", "", {a, b, c, 0}, mixed},
                                {"roll,pitch,yaw", "rpy", "", {c, b, a, 0}, mixed},
                                {"RX,RY,RZ", "rpy", "", {c, b, a, 0}, mixed},
                                {"Rx,Ry,Rz",
                                 "rotvec",
                                 "",
                                 {a, b, c, 0},
                                 Quaterniond(AngleAxisd(vector.norm(), vector.normalized()))},
                                {"qw,qx,qy,qz", "", "", wxyz, mixed},
                                {"QX,QY,QZ,QW", "", "", xyzw, mixed},
                                {"quat1,quat2,quat3,quat4", "", "wxyz", wxyz, mixed},
                                {"quat_0,quat_1,quat_2,quat_3", "", "xyzw", xyzw, mixed}};
  for (const Case& one : cases) {
    ImportOptions options = kMmDeg;
    options.angle_unit = "rad";
    options.angles = one.angles;
    options.quaternion = one.quaternion;
    std::string text = one.names + ",X,Y,Z," + kJoints + "\n";
    const auto count = static_cast<size_t>(std::ranges::count(one.names, ',') + 1);
    char number[40];
    for (size_t k = 0; k < count; ++k) {
      std::snprintf(number, sizeof number, "%.17g,", one.numbers[k]);
      text += number;
    }
    const Campaign campaign = import_text(text + "1,2,3,0,0,0,0,0,0\n", options).campaign;
    ASSERT_TRUE(campaign.has_orientation()) << one.names;
    EXPECT_LT(campaign.orientation[0].angularDistance(one.expected), 1e-12) << one.names;
  }
}

TEST(ImportReadings, AQuaternionWithoutNamedOrderNeedsTheOption) {
  const std::string text =
      "quat1,quat2,quat3,quat4,X,Y,Z," + kJoints + "\n1,0,0,0,1,2,3,0,0,0,0,0,0\n";
  EXPECT_THAT(error_of_text(text, kMmDeg), HasSubstr("--quaternion wxyz or --quaternion xyzw"));
}

// ---- joins

const std::string kPoints = "Point,X,Y,Z\nb,1,1,1\na,2,2,2\n";

TEST(ImportJoin, RowsJoinByIdWhicheverTheirOrder) {
  const Campaign campaign =
      import_two(kPoints,
                 "pose," + kJoints + ",X,Y,Z\na,10,0,0,0,0,0,9,9,9\nb,20,0,0,0,0,0,9,9,9\n", kMmDeg)
          .campaign;
  EXPECT_EQ(campaign.pose_ids, (std::vector<std::string>{"b", "a"}));
  EXPECT_NEAR(campaign.q[0][0], 20 * kDegree, 1e-15);
  EXPECT_NEAR(campaign.q[1][0], 10 * kDegree, 1e-15);
  EXPECT_NEAR(campaign.position[0].x(), 1e-3, 1e-15);  // of the instrument, not of the controller
}

TEST(ImportJoin, AnOptionMayNameTheColumnOfOneTable) {
  ImportOptions options = kMmDeg;
  options.columns = {"pose=Group", "pose=Label"};
  const Campaign campaign = import_two("Group,Point,X,Y,Z\nb,1,1,1,1\na,2,2,2,2\n",
                                       "Label," + kJoints + "\na,10,0,0,0,0,0\nb,20,0,0,0,0,0\n",
                                       [&] {
                                         ImportOptions ignoring = options;
                                         ignoring.ignored = {"Point"};
                                         return ignoring;
                                       }())
                                .campaign;
  EXPECT_EQ(campaign.pose_ids, (std::vector<std::string>{"b", "a"}));
  EXPECT_NEAR(campaign.q[0][0], 20 * kDegree, 1e-15);
}

TEST(ImportJoin, WhatDoesNotBelongTogetherIsRefused) {
  const auto error = [&](const std::string& joints) {
    return error_of([&] { import_two(kPoints, joints, kMmDeg); });
  };
  EXPECT_THAT(error("pose," + kJoints + "\na,1,0,0,0,0,0\nc,2,0,0,0,0,0\n"),
              HasSubstr("the same in part only"));
  EXPECT_THAT(error(kJoints + "\n1,0,0,0,0,0\n"), HasSubstr("--join time"));
  EXPECT_THAT(error("pose," + kJoints + "\na,1,0,0,0,0,0\nb,2,0,0,0,0,0\nb,2,0,0,0,0,0\n"),
              HasSubstr("cannot be told apart"));
}

// Names that differ in writing only are those of the same poses.
TEST(ImportJoin, NamesInAnotherWritingAreNotJoinedInAnotherOrder) {
  const std::string points = "Point,X,Y,Z\nP01,1,1,1\nP10,2,2,2\n";
  const auto joints = [](const std::string& first, const std::string& second) {
    return "pose," + kJoints + "\n" + first + ",10,0,0,0,0,0\n" + second + ",20,0,0,0,0,0\n";
  };
  const ImportedReadings in_order = import_two(points, joints("p1", "p 10"), kMmDeg);
  EXPECT_NEAR(in_order.campaign.q[0][0], 10 * kDegree, 1e-15);
  EXPECT_THAT(
      error_of([&] { import_two(points, joints("p10", "p1"), kMmDeg); }),
      HasSubstr("in another order, only their names are written otherwise, such as 'P01' and "
                "'p1'"));
  EXPECT_NO_THROW(import_two(points, joints("a", "b"), kMmDeg));
}

// As many rows say nothing of two records with clocks of their own; of two tables with a row for
// each visit, they do.
TEST(ImportJoin, RecordsOfTheWayAreNotJoinedByTheOrderOfTheirRows) {
  const auto error = [&](double period, double offset) {
    std::string points = "t_s,X,Y,Z\n", joints = "t_s," + kJoints + "\n";
    for (int k = 0; k < 5; ++k) {
      points += std::to_string(k * period + offset) + ",1,2,3\n";
      joints += std::to_string(k * period) + ",10,0,0,0,0,0\n";
    }
    return error_of([&] { import_two(points, joints, kMmDeg); });
  };
  EXPECT_THAT(error(0.02, 3), HasSubstr("--join stops if they differ"));
  EXPECT_EQ(error(0.02, 0.005), "no error");
  EXPECT_EQ(error(20, 3000), "no error");
}

// Stops of 2 s at q1 = 0, 10, 20, ... with a second of motion between, sampled each 50 ms.
std::string stops_log(bool iso) {
  std::string text = "t_s," + kJoints + "\n";
  for (int k = 0; k < 180; ++k) {
    const double t = 0.05 * k, in_stop = std::fmod(t, 3.0);
    const double q = 10 * (std::floor(t / 3) + std::max(0.0, in_stop - 2));
    char line[100];
    if (iso)
      std::snprintf(line, sizeof line, "2024-05-03T12:00:%06.3fZ,%.6f,0,0,0,0,0\n", t, q);
    else
      std::snprintf(line, sizeof line, "%.3f,%.6f,0,0,0,0,0\n", t, q);
    text += line;
  }
  return text;
}

TEST(ImportJoin, ByTimePointsTakeTheJointsOfTheirStop) {
  ImportOptions options = kMmDeg;
  options.join = "time";
  options.clock_offset_s = -100;
  const ImportedReadings readings = import_two(
      "t_s,X,Y,Z\n101.01,1,1,1\n101.52,1,1,1\n102.5,2,2,2\n104.03,3,3,3\n107.01,4,4,4\n300,5,5,5\n",
      stops_log(false), options);
  const Campaign& campaign = readings.campaign;
  ASSERT_EQ(campaign.rows(), 4);  // the third was taken in motion, the last after the log
  EXPECT_EQ(campaign.pose, (std::vector<int>{0, 0, 1, 2}));
  EXPECT_NEAR(campaign.q[2][0], 10 * kDegree, 1e-12);
  EXPECT_NEAR(campaign.q[3][0], 20 * kDegree, 1e-12);
  EXPECT_NEAR(campaign.position[3].x(), 4e-3, 1e-15);
  EXPECT_THAT(readings.mapping, HasSubstr("4 of 6 points"));
  ASSERT_EQ(readings.warnings.size(), 3u);
  EXPECT_THAT(readings.warnings[1], HasSubstr("the first in line 4"));
}

// A joint stands for 2 s, turns by 1 deg/s for 4 s and stands again: whatever the rate of the log,
// only points at rest are taken.
TEST(ImportJoin, ByTimeASlowMotionIsNoStandstillAtAnyRate) {
  ImportOptions options = kMmDeg;
  options.join = "time";
  std::string points = "t_s,X,Y,Z\n";
  for (int k = 1; k < 80; ++k)
    points += std::to_string(0.1 * k + 0.005) + "," + std::to_string(k) + ",0,0\n";
  for (const int rate : {50, 125, 500, 2000}) {
    std::string log = "t_s,A1,A2,A3,A4,A5,A6\n";
    for (int k = 0; k <= 8 * rate; ++k) {
      const double t = static_cast<double>(k) / rate;
      log += std::to_string(t) + "," + std::to_string(std::clamp(t - 2, 0.0, 4.0)) + ",0,0,0,0,0\n";
    }
    EXPECT_EQ(import_two(points, log, options).campaign.rows(), 19 + 19) << rate;
  }
}

TEST(ImportJoin, ByTimeBothClocksAreOfOneForm) {
  ImportOptions options = kMmDeg;
  options.join = "time";
  const std::string points = "time,X,Y,Z\n2024-05-03T14:00:04.5+02:00,1,2,3\n";
  EXPECT_NEAR(import_two(points, stops_log(true), options).campaign.q[0][0], 10 * kDegree, 1e-12);
  EXPECT_THAT(error_of([&] { import_two(points, stops_log(false), options); }),
              HasSubstr("give both in one form"));
}

// Names and order of the columns after csv_writer.py and serialize.py of the RTDE client library of
// Universal Robots (github.com/UniversalRobots/RTDE_Python_Client_Library): a blank between cells,
// vectors as name_0 to name_5. Units after the RTDE guide: joints in rad, timestamp in s. The pose
// of the TCP is computed by the controller, so it is no measurement.
TEST(ImportPreset, TheRecordOfTheRtdeClientGivesJointsInRadians) {
  std::string log = "timestamp";
  for (const char* vector : {"target_q", "actual_q", "actual_TCP_pose"})
    for (int k = 0; k < 6; ++k) log += std::string(" ") + vector + "_" + std::to_string(k);
  log +=
      " output_int_register_0\r\n"
      "10.002 9 9 9 9 9 9 0.5 -1.5 1.25 -2 1 0.25 0.1 0.2 0.3 0 3.1 0 7\r\n"
      "10.502 9 9 9 9 9 9 0.6 -1.5 1.25 -2 1 0.25 0.1 0.2 0.3 0 3.1 0 7\r\n";
  ImportOptions options = kMmDeg;
  options.presets = {"ur-rtde"};
  const Campaign campaign = import_two(kPoints, log, options).campaign;
  ASSERT_EQ(campaign.rows(), 2);
  EXPECT_EQ(campaign.q[0], (JointVector(6) << 0.5, -1.5, 1.25, -2, 1, 0.25).finished());
  EXPECT_EQ(campaign.q[1][0], 0.6);
  EXPECT_EQ(campaign.position[0].x(), 1e-3);
  EXPECT_EQ(campaign.time_s[1], 10.502);
}

}  // namespace
}  // namespace armtrue::import_test
