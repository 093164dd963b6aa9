#include "armtrue/io/path_io.h"

#include <gtest/gtest.h>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "kinematics/six_axes.h"
#include "support/temporary_file.h"

namespace armtrue::path_io_test {
namespace {

PathFile read(const std::string& text, KeepRows keep = KeepRows::no) {
  return read_path(TemporaryFile(text).path, keep);
}

void expect_error(const std::string& text, const std::string& expected,
                  KeepRows keep = KeepRows::no) {
  try {
    read(text, keep);
    FAIL() << "no error; expected: " << expected;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
  }
}

TEST(PathIo, ReadsWhatIsThereInSi) {
  const PathFile file = read(
      "fx_n,fy_n,fz_n,t_s,x_mm,y_mm,z_m,a_deg,b_deg,c_deg,tool\n"
      "1,2,3,0,10,20,0.03,90,0,0,1\n"
      "1,2,4,0.016,11,20,0.03,90,0,0,1\n");
  EXPECT_EQ(file.path.samples(), 2);
  EXPECT_NEAR(file.path.position(0, 1), 0.011, 1e-15);
  EXPECT_NEAR(file.path.position(2, 1), 0.03, 1e-15);
  EXPECT_NEAR(file.path.orientation(0, 0), 90 * kDegree, 1e-15);
  EXPECT_EQ(file.path.force(2, 1), 4);
  EXPECT_FALSE(file.path.has_joints());
  EXPECT_EQ(file.unknown_columns, std::vector<std::string>{"tool"});
}

TEST(PathIo, AnEmptyPositionIsALostSample) {
  const std::string text = "t_s,x_mm,y_mm,z_mm\n0,1,2,3\n0.1,,,\n0.2,1,2,4\n";
  const PathFile file = read(text);
  EXPECT_EQ(file.path.samples(), 2);
  EXPECT_EQ(file.lost, 1);
  EXPECT_EQ(file.line, (std::vector<int>{2, 4}));
  expect_error(text, ":3: column 'x_mm': is empty; a programmed path", KeepRows::yes);
  expect_error("t_s,x_mm,y_mm,z_mm\n0,1,2,3\n0.1,1,,3\n", ":3: column 'y_mm': is empty while");
}

TEST(PathIo, RefusesTimeThatDoesNotIncrease) {
  expect_error("t_s,x_mm,y_mm,z_mm\n0,1,2,3\n0.1,1,2,3\n0.1,1,2,3\n", ":4: column 't_s': '0.1'");
  expect_error("t_s,x_mm,y_mm,z_mm\n0,1,2,3\n", "a path needs at least two");
}

TEST(PathIo, NamesMissingColumns) {
  expect_error("t,x_mm,y_mm,z_mm\n0,1,2,3\n", "missing column 't_s'");
  expect_error("t_s,x_mm,y_mm,z_mm,q1_deg\n0,1,2,3,4\n", "'q2_deg', 'q3_deg'");
  for (const std::string written : {"xmm", "x mm", "X [mm]", "x-mm"})
    expect_error("t_s," + written + ",y_mm,z_mm\n0,1,2,3\n",
                 "is '" + written + "' meant to be 'x_mm'?");
}

// A correction of a column that does not hold the position is none.
TEST(PathIo, RefusesAQuantityInTwoUnits) {
  expect_error("t_s,x_mm,y_mm,z_mm,y_m\n0,1,2,3,0.002\n0.1,1,2,3,0.002\n",
               ":1: column 'y_m': stands beside 'y_mm'; keep one of them");
  expect_error("t_s,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,c_rad\n0,1,2,3,0,0,0,0\n",
               ":1: column 'c_rad': stands beside 'c_deg'; keep one of them");
}

TEST(PathIo, RefusesAnOrientationUnderAnotherName) {
  const std::string rows = "0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n";
  expect_error("t_s,x_mm,y_mm,z_mm,A_deg,B_deg,C_deg\n" + rows, "is 'A_deg' meant to be 'a_deg'?");
  expect_error("t_s,x_mm,y_mm,z_mm,roll,pitch,yaw\n" + rows, "'roll' looks like an orientation");
  read("t_s,x_mm,y_mm,z_mm,roll,pitch,yaw\n" + rows, KeepRows::yes);  // stays in the product
}

TEST(PathIo, OnlyMovedPositionsAreWrittenAnew) {
  const PathFile file =
      read("note,t_s,x_mm,y_mm,z_mm,speed\nab,0.000,1.50,2.0,3,7.0\n,0.016,1.50,2.0,3,8.10\n",
           KeepRows::yes);
  Eigen::Matrix3Xd position = file.path.position;
  EXPECT_EQ(write_path_like(file, position),
            "note,t_s,x_mm,y_mm,z_mm,speed\nab,0.000,1.50,2.0,3,7.0\n,0.016,1.50,2.0,3,8.10\n");
  // The last digits and the micrometre are check digits.
  position(1, 1) += 0.1234567891e-3;
  EXPECT_EQ(
      write_path_like(file, position),
      "note,t_s,x_mm,y_mm,z_mm,speed\nab,0.000,1.50,2.0,3,7.0\n,0.016,1.50,2.12366667,3,8.10\n");
}

TEST(PathIo, WrittenPathsReadBackToANanometre) {
  Path path;
  path.time = Eigen::Vector2d(0, 0.1);
  path.position = Eigen::Matrix3Xd::Random(3, 2);
  path.q = Eigen::Matrix<double, 6, Eigen::Dynamic>::Random(6, 2);
  const Path back = read(write_path(path)).path;
  EXPECT_EQ(back.time, path.time);
  EXPECT_LT((back.position - path.position).cwiseAbs().maxCoeff(), 0.51e-9);
  EXPECT_LT((back.q - path.q).cwiseAbs().maxCoeff(), 1e-11);
  path.position.col(0) << 0.1, 1. / 3, -1e-12;
  path.q.resize(kJoints, 0);
  EXPECT_EQ(write_path(path).substr(0, 42), "t_s,x_mm,y_mm,z_mm\n0,100,333.333333,0\n0.1,");
}

}  // namespace
}  // namespace armtrue::path_io_test
