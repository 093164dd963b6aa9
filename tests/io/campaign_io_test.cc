#include "armtrue/io/campaign_io.h"

#include <gmock/gmock.h>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "support/temporary_file.h"

namespace armtrue::campaign_io_test {
namespace {

constexpr const char* kHeader = "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm";

Campaign read(const std::string& text) { return read_campaign(TemporaryFile(text).path).campaign; }

void expect_error(const std::string& text, const std::string& expected) {
  try {
    read(text);
    FAIL() << "no error; expected: " << expected;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
  }
}

TEST(CampaignIo, ColumnsComeInAnyOrderAndUnit) {
  const Campaign a = read(std::string(kHeader) + "\n7,1,2,3,4,5,6,1000,2000,3000\n");
  const Campaign b = read(
      "z_m,y_m,x_m,q6_deg,q5_deg,q4_deg,q3_deg,q2_deg,q1_rad,pose\n"
      "3,2,1,6,5,4,3,2,0.017453292519943295,7\n");
  EXPECT_EQ(a.pose_ids, std::vector<std::string>{"7"});
  EXPECT_LT((a.q[0] - b.q[0]).norm(), 1e-15);
  EXPECT_LT((a.position[0] - b.position[0]).norm(), 1e-15);
}

TEST(CampaignIo, CommentsBlankEndAndDecimalCommaAreAccepted) {
  const Campaign campaign = read(
      "\xEF\xBB\xBF# made by hand\r\npose;q1_deg;q2_deg;q3_deg;q4_deg;q5_deg;q6_deg;"
      "x_mm;y_mm;z_mm\r\n# note\r\n1;1,5;2;3;4;5;6;10,25;20;30\r\n\r\n");
  ASSERT_EQ(campaign.rows(), 1);
  EXPECT_NEAR(campaign.q[0][0], 1.5 * kDegree, 1e-15);
  EXPECT_NEAR(campaign.position[0].x(), 10.25e-3, 1e-15);
}

TEST(CampaignIo, ReplicatesShareTheirPoseAndArrivalComesFromThePreviousRow) {
  const Campaign campaign = read(
      std::string(kHeader) + "\na,0,0,0,0,0,0,1,1,1\nb,10,-5,0,0,0,0,1,1,1\na,0,0,0,0,0,0,1,1,1\n");
  EXPECT_EQ(campaign.pose, (std::vector<int>{0, 1, 0}));
  EXPECT_EQ(campaign.arrival[0][0], 0);
  EXPECT_EQ(campaign.arrival[1][0], 1);
  EXPECT_EQ(campaign.arrival[1][1], -1);
  EXPECT_EQ(campaign.arrival[2][0], -1);
  EXPECT_EQ(campaign.arrival[2][2], 0);
}

TEST(CampaignIo, AJointThatCreepsArrivesFromWhereItCame) {
  std::string text = std::string(kHeader) + "\n";
  for (int i = 0; i <= 10; ++i)  // each step alone is too small to tell from noise
    text += std::to_string(i) + ",0," + std::to_string(5e-5 * i) + ",0,0,0,0,1,1,1\n";
  const Campaign campaign = read(text);
  EXPECT_EQ(campaign.arrival[1][1], 0);
  EXPECT_EQ(campaign.arrival[10][1], 1);
  EXPECT_EQ(campaign.arrival[10][0], 0);
}

TEST(CampaignIo, AnglesAndQuaternionsAreTheSameRotation) {
  const std::string row = "\n1,0,0,0,0,0,0,1,1,1,";
  const Campaign abc = read(std::string(kHeader) + ",a_deg,b_deg,c_deg" + row + "90,0,0\n");
  const Campaign quaternion =
      read(std::string(kHeader) + ",qw,qx,qy,qz" + row + "0.70710678,0,0,0.70710678\n");
  EXPECT_LT(abc.orientation[0].angularDistance(quaternion.orientation[0]), 1e-7);
}

TEST(CampaignIo, ErrorsNameLineColumnAndContent) {
  const std::string header = std::string(kHeader) + "\n", row = "1,0,0,0,0,0,0,1,1,1\n";
  expect_error("", "is empty");
  expect_error(header, "has no measured row");
  expect_error("pose,x_mm\n1,2\n", "missing columns 'q1_deg', 'q2_deg'");
  expect_error(header + row + "2,0,0,0,0,0,0,1,1\n", ":3: has 9 fields where the header has 10");
  expect_error(header + row + "\n" + row, ":3: blank line between rows");
  expect_error(header + "1,0,0,zero,0,0,0,1,1,1\n", ":2: column 'q3_deg': 'zero' is no number");
  expect_error(header + "1,0,0,0,0,0,0,1,inf,1\n", ":2: column 'y_mm': 'inf' is not finite");
  expect_error(header + "1,0,0,0,0,0,0,1,,1\n", ":2: column 'y_mm': '' is no number");
  expect_error(header + ",0,0,0,0,0,0,1,1,1\n", ":2: column 'pose': is empty");
  expect_error(header + row + "1,5,0,0,0,0,0,1,1,1\n", "replicates of one configuration");
  expect_error(std::string(kHeader) + ",a_deg\n1,0,0,0,0,0,0,1,1,1,0\n",
               "an orientation by angles also needs the columns 'b_deg', 'c_deg'");
  expect_error(std::string(kHeader) + ",qw,qx,qy,qz\n1,0,0,0,0,0,0,1,1,1,1,1,0,0\n",
               "has norm 1.414");
  expect_error(
      std::string(kHeader) + ",dir1,dir2,dir3,dir4,dir5,dir6\n1,0,0,0,0,0,0,1,1,1,2,0,0,0,0,0\n",
      "'2' is not -1, 0 or 1");
  expect_error(std::string(kHeader) + ",sigma_mm\n1,0,0,0,0,0,0,1,1,1,0\n", "must be above zero");
}

constexpr const char* kDistances = "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,l_mm,anchor";

TEST(CampaignIo, DistancesAreReadInsteadOfPoints) {
  const Campaign campaign = read(std::string(kDistances) +
                                 "\n1,0,0,0,0,0,0,1500.5,a\n"
                                 "1,0,0,0,0,0,0,2000,b\n2,1,0,0,0,0,0,,b\n");
  EXPECT_TRUE(campaign.position.empty());
  EXPECT_EQ(campaign.distance, (std::vector<double>{1.5005, 2.0}));
  EXPECT_EQ(campaign.anchor, (std::vector<int>{0, 1}));
  EXPECT_EQ(campaign.anchor_names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(campaign.skipped_rows, 1);
  // Empty cells of points do not disturb.
  const Campaign beside =
      read(std::string(kHeader) + ",a_deg,b_deg,c_deg,l_m\n1,0,0,0,0,0,0,,,,,,,1.5\n");
  EXPECT_EQ(beside.distance, std::vector<double>{1.5});
  EXPECT_FALSE(beside.has_orientation());
}

TEST(CampaignIo, PointsBesideDistancesAreThreeCoordinates) {
  const std::string rows =
      "1,0,0,0,0,0,0,,,,5,0.2\n2,1,0,0,0,0,0,1,2,3,,0.1\n3,2,0,0,0,0,0,4,5,6,,0.1\n";
  const Campaign campaign = read(std::string(kHeader) + ",l_m,sigma_mm\n" + rows);
  EXPECT_TRUE(campaign.position.empty());
  EXPECT_TRUE(campaign.anchor.empty());
  ASSERT_EQ(campaign.rows(), 7);
  EXPECT_EQ(campaign.kind(0), ReadingKind::distance);
  EXPECT_EQ(campaign.length(0), 5);
  for (int row = 1; row < 7; ++row) {
    ASSERT_EQ(campaign.kind(row), ReadingKind::coordinate);
    EXPECT_EQ(campaign.coordinate[row]->axis, (row - 1) % 3);
    EXPECT_EQ(campaign.length(row), 1e-3 * row);
  }
  EXPECT_EQ(campaign.pose, (std::vector<int>{0, 1, 1, 1, 2, 2, 2}));
  EXPECT_EQ(campaign.line, (std::vector<int>{2, 3, 3, 3, 4, 4, 4}));
}

TEST(CampaignIo, ErrorsOfDistancesNameLineColumnAndContent) {
  const std::string header = std::string(kDistances) + "\n";
  expect_error(header + "1,0,0,0,0,0,0,0,a\n",
               ":2: column 'l_mm': '0': a distance must be above zero");
  expect_error(header + "1,0,0,0,0,0,0,-20,a\n",
               ":2: column 'l_mm': '-20': a distance must be above zero");
  expect_error(header + "1,0,0,0,0,0,0,x,a\n", ":2: column 'l_mm': 'x' is no number");
  expect_error(header + "1,0,0,0,0,0,0,20,\n", ":2: column 'anchor': is empty");
  const std::string both = std::string(kHeader) + ",l_mm\n";
  expect_error(both + "1,0,0,0,0,0,0,1,,,5\n", ":2: column 'l_mm': '5' stands beside a point");
  const std::string mixed = "1,0,0,0,0,0,0,1,1,1,\n2,1,0,0,0,0,0,,,,5\n";
  expect_error(both + mixed, "points and distances in one file also need the column 'sigma_mm'");
  expect_error(std::string(kHeader) +
                   ",a_deg,b_deg,c_deg,l_mm\n1,0,0,0,0,0,0,1,1,1,0,0,0,\n2,1,0,0,0,0,0,,,,,,,5\n",
               "points and distances in one file are read without orientations; leave out a_deg");
  expect_error(std::string(kDistances) + ",a_deg,b_deg,c_deg\n1,0,0,0,0,0,0,5,a,1,2,3\n",
               ":2: column 'a_deg': '1' stands beside a distance");
  expect_error(std::string(kDistances) + ",x_mm\n1,0,0,0,0,0,0,5,a,1\n",
               "missing columns 'y_mm', 'z_mm'");
  expect_error(std::string(kDistances) +
                   ",repeat\n1,0,0,0,0,0,0,5,a,1\n1,0,0,0,0,0,0,5,b,1\n1,0,0,0,0,0,0,5,a,1\n",
               "already stands in line 2");
}

TEST(CampaignIo, DistancesReadBackTheSame) {
  const std::string text =
      "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,l_mm,anchor,dir1,dir2,dir3,dir4,dir5,"
      "dir6\nA,1.25,2,3,4,5,6,1234.5678,wall,0,1,-1,0,0,1\n";
  EXPECT_EQ(write_campaign(read(text)), text);
}

TEST(CampaignIo, MotorTorquesAreRead) {
  const std::string header = std::string(kHeader) + ",tau1_nm,tau2_nm,tau3_nm,tau4_nm,tau5_nm";
  const Campaign campaign = read(header + ",tau6_nm\n1,0,0,0,0,0,0,1,1,1,10,-20.5,30,0,0,6\n");
  EXPECT_EQ(campaign.motor_torque_nm.front(),
            (std::array<double, kMaxJoints>{10, -20.5, 30, 0, 0, 6}));
  expect_error(header + "\n1,0,0,0,0,0,0,1,1,1,0,0,0,0,0\n",
               "a set of motor torques also needs the column 'tau6_nm'");
}

TEST(CampaignIo, RowsWithoutMeasurementAreCounted) {
  const Campaign campaign =
      read(std::string(kHeader) + "\n1,0,0,0,0,0,0,,,\n2,0,0,0,0,0,0,1,1,1\n");
  EXPECT_EQ(campaign.rows(), 1);
  EXPECT_EQ(campaign.skipped_rows, 1);
}

TEST(CampaignIo, WhatIsWrittenReadsBackTheSame) {
  const std::string text =
      "pose,repeat,t_s,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,dir1,dir2,dir3,"
      "dir4,dir5,dir6\nA,1,0.5,1.25,2,3,4,5,6.125,100.001,2,-3.5,0,1,-1,0,0,1\n";
  EXPECT_EQ(write_campaign(read(text)), text);
}

TEST(CampaignIo, OtherJointsHaveOtherColumns) {
  KinematicChain chain;
  for (const char* name : {"E1", "A1", "A2"}) chain.links.emplace_back().name = name;
  chain.links.front().joint = JointKind::prismatic;
  const std::vector<JointName> joints = joint_names(chain);
  const std::string text =
      "pose,e1_mm,q1_deg,q2_deg,x_mm,y_mm,z_mm,dir1,dir2,dir3\n"
      "A,1250,20,-30,1,2,3,0,0,0\nB,1000,25,-30,1,2,3,-1,1,0\n";
  const Campaign campaign = read_campaign(TemporaryFile(text).path, joints).campaign;
  ASSERT_EQ(campaign.q[0].size(), 3);
  EXPECT_DOUBLE_EQ(campaign.q[0][0], 1.25);
  EXPECT_DOUBLE_EQ(campaign.stroke[1][0], -0.25);
  EXPECT_EQ(write_campaign(campaign, joints), text);
  const TemporaryFile six(std::string(kHeader) + "\n1,0,0,0,0,0,0,1,1,1\n");
  try {
    read_campaign(six.path, joints);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("has 6 joint columns, q1 to q6, and the robot "
                                                 "has 3: e1_mm, q1_deg, q2_deg"));
  }
}

}  // namespace
}  // namespace armtrue::campaign_io_test
