#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <sstream>

#include "armtrue/io/program_io.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/programs/displacement.h"
#include "armtrue/text/input_error.h"
#include "support/temporary_file.h"

namespace armtrue::krl_test {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kMm = 1e-3;
const std::string kFolder = ARMTRUE_TESTS "/programs/krl/";

using Texts = std::vector<ProgramText>;

Texts program(const std::string& src, const std::string& dat = "") {
  Texts texts{{"p.src", src}};
  if (!dat.empty()) texts.push_back({"p.dat", dat});
  return texts;
}

Texts program_of_file(const std::string& src) {
  Texts texts;
  for (const TextFile& file : read_program_texts(src, "", true)) texts.push_back(file.text);
  return texts;
}

// As mirror-correct displaces a program along a path.
struct Corrected {
  std::string src, dat;
  int corrected = 0, inserted = 0, left_alone = 0;
  std::vector<std::string> warnings;
};

Corrected correct_krl(const Texts& texts, const Path& path, const Eigen::Matrix3Xd& corrected,
                      const DisplacementOptions& options = {}) {
  const DisplacedProgram displaced =
      displace_program(parse_program(*find_dialect("krl"), texts, {}, TargetParts::position), path,
                       corrected, options);
  const std::vector<std::string>& written = displaced.text.texts;
  return {written[0],           written.size() > 1 ? written[1] : "",
          displaced.corrected,  displaced.text.inserted,
          displaced.left_alone, displaced.warnings};
}

// A path through the corners [mm], with a sample about every `step`.
Path path_through(const std::vector<Vector3d>& corners, double step = 1) {
  std::vector<Vector3d> samples{corners.front()};
  for (size_t i = 1; i < corners.size(); ++i) {
    const int count =
        std::max(1, static_cast<int>(std::ceil((corners[i] - corners[i - 1]).norm() / step)));
    for (int k = 1; k <= count; ++k)
      samples.push_back(corners[i - 1] + k * (corners[i] - corners[i - 1]) / count);
  }
  Path path;
  const auto n = static_cast<Eigen::Index>(samples.size());
  path.time = Eigen::VectorXd::LinSpaced(n, 0, static_cast<double>(n - 1));
  path.position.resize(3, n);
  for (Eigen::Index i = 0; i < n; ++i) path.position.col(i) = kMm * samples[static_cast<size_t>(i)];
  return path;
}

// Displaced by what a function of the position gives, all in mm.
Eigen::Matrix3Xd displaced(const Path& path, const std::function<Vector3d(const Vector3d&)>& by) {
  Eigen::Matrix3Xd position = path.position;
  for (Eigen::Index i = 0; i < position.cols(); ++i)
    position.col(i) += kMm * by(position.col(i) / kMm);
  return position;
}

// A controller of its own: goes through the lines of a program and says where the tool goes [mm].
// It knows frames, names and what is inherited; blends and axes it does not.
class Controller {
 public:
  Controller(const std::string& src, const std::string& dat) {
    const std::regex point(R"((\w+)\s*=\s*(\{[^}]*\}))");
    for (std::sregex_iterator it(dat.begin(), dat.end(), point), end; it != end; ++it)
      names_[(*it)[1]] = (*it)[2];
    std::istringstream lines(src);
    const std::regex move(R"(^\s*(S?LIN|S?PTP|S?CIRC)\s+([^;]*))", std::regex::icase);
    for (std::string line; std::getline(lines, line);) {
      std::smatch match;
      if (std::regex_search(line, match, move))
        go(match[1], match.str(2).substr(0, match.str(2).find("WITH")));
    }
  }
  struct Sample {
    Vector3d position;
    std::array<double, 9> rest;  // A, B, C, E1..E6, at the end of the move
  };
  std::vector<Sample> samples;

 private:
  using Pose = std::array<double, 12>;

  void go(const std::string& keyword, const std::string& text) {
    std::vector<std::string> targets;
    const std::regex target(R"(\{[^}]*\}|\w+)");
    for (std::sregex_iterator it(text.begin(), text.end(), target), end; it != end; ++it) {
      std::string found = it->str();
      if (names_.count(found)) found = names_[found];
      if (found[0] == '{') targets.push_back(found);
    }
    const bool circle = std::toupper(keyword[keyword[0] == 'S' ? 1 : 0]) == 'C';
    if (targets.size() != (circle ? 2u : 1u) || targets[0].find("A1") != std::string::npos) return;
    const Pose start = pose_;
    Pose via = start;
    if (circle) read(targets[0], via);
    read(targets.back(), pose_);
    if (circle)
      arc(xyz(start), xyz(via), xyz(pose_));
    else if (samples.empty())
      add(xyz(pose_));
    else
      for (int k = 1; k <= kSteps; ++k) add(xyz(start) + k * (xyz(pose_) - xyz(start)) / kSteps);
  }
  static void read(const std::string& frame, Pose& pose) {
    static const std::array<std::string, 12> kNames{"X",  "Y",  "Z",  "A",  "B",  "C",
                                                    "E1", "E2", "E3", "E4", "E5", "E6"};
    const std::regex entry(R"(([A-Z]\d?)\s+([-+.\d]+))", std::regex::icase);
    for (std::sregex_iterator it(frame.begin(), frame.end(), entry), end; it != end; ++it)
      for (size_t i = 0; i < 12; ++i)
        if (kNames[i] == (*it)[1]) pose[i] = std::stod((*it)[2]);
  }
  static Vector3d xyz(const Pose& pose) { return {pose[0], pose[1], pose[2]}; }
  void add(const Vector3d& position) {
    Sample sample{position, {}};
    std::copy(pose_.begin() + 3, pose_.end(), sample.rest.begin());
    samples.push_back(sample);
  }
  // The centre is as far from all three and in their plane.
  void arc(const Vector3d& a, const Vector3d& m, const Vector3d& b) {
    Eigen::Matrix3d equations;
    equations << (m - a).transpose(), (b - a).transpose(), (m - a).cross(b - a).transpose();
    const Vector3d right(((m + a) / 2).dot(m - a), ((b + a) / 2).dot(b - a),
                         a.dot((m - a).cross(b - a)));
    const Vector3d centre = equations.fullPivLu().solve(right);
    const Vector3d axis = (m - a).cross(b - a).normalized();
    const auto angle_to = [&](const Vector3d& p) {
      const double angle =
          std::atan2(axis.dot((a - centre).cross(p - centre)), (a - centre).dot(p - centre));
      return angle < 0 ? angle + 2 * M_PI : angle;
    };
    for (int k = 1; k <= kSteps; ++k)
      add(centre + Eigen::AngleAxisd(angle_to(b) * k / kSteps, axis) * (a - centre));
  }

  static constexpr int kSteps = 400;
  std::map<std::string, std::string> names_;
  Pose pose_{};
};

double distance_to(const std::vector<Controller::Sample>& line, const Vector3d& point) {
  double nearest = 1e9;
  for (size_t i = 1; i < line.size(); ++i) {
    const Vector3d from = line[i - 1].position, chord = line[i].position - from;
    const double t = chord.squaredNorm() > 0
                         ? std::clamp(chord.dot(point - from) / chord.squaredNorm(), 0.0, 1.0)
                         : 0.0;
    nearest = std::min(nearest, (from + t * chord - point).norm());
  }
  return nearest;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

void expect_error(const std::function<void()>& run, const std::string& expected) {
  try {
    run();
    FAIL() << "no error; expected: " << expected;
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(expected));
  }
}

// The path that the three example programs describe.
Path contour() {
  std::vector<Vector3d> corners{{0, 0, -5}, {300, 0, -5}};
  for (int k = 1; k <= 360; ++k)
    corners.push_back(
        {300 + 50 * std::sin(k * M_PI / 720), 50 - 50 * std::cos(k * M_PI / 720), -5});
  corners.push_back({350, 200, -5});
  return path_through(corners);
}
Path milling() {
  return path_through(
      {{0, 0, 50}, {0, 0, 0}, {100, 0, 0}, {110, 20, 0}, {100, 20, 0}, {100, 80, 0}});
}
Path spline() {
  return path_through({{0, 0, 0},
                       {10, 1, 0},
                       {60, 1, 0},
                       {67.071, 3.929, 0},
                       {70, 11, 0},
                       {70, 100, 0},
                       {0, 100, 0},
                       {0, 0, 0}});
}

TEST(Krl, WithoutDisplacementEveryByteStands) {
  const std::vector<std::pair<std::string, Path>> cases{
      {"kontur", contour()}, {"milling", milling()}, {"spline", spline()}};
  for (const auto& [name, path] : cases) {
    const Texts read = program_of_file(kFolder + name + ".src");
    std::ifstream file(kFolder + name + ".src", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(read[0].text, bytes);
    const Corrected result = correct_krl(read, path, path.position);
    EXPECT_EQ(result.src, bytes);
    ASSERT_EQ(read.size(), name == "kontur" ? 2u : 1u);
    if (read.size() > 1) EXPECT_EQ(result.dat, read[1].text);
    EXPECT_GT(result.corrected, 3);
    EXPECT_EQ(result.inserted, 0);
  }
}

TEST(Krl, ALongProgramIsReadWhole) {
  std::string text;
  while (text.size() < 40'000'000) text += "LIN {X 0,Y 0,Z 0} C_DIS ; and so on\r\n";
  EXPECT_EQ(program_of_file(TemporaryFile(text).path)[0].text, text);
}

TEST(Krl, OnlyTheNumbersOfCorrectedMovesChange) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d&) { return Vector3d(0, 0.12344, -0.05); };
  const Corrected result =
      correct_krl(program("  PTP {X 0,Y 0.00,Z 0,A 1,B 2,C 3,S 2,T 10}\r\n"
                          "lin  { x 100.0 , y +0.000000, Z 0.000,A 5 } c_dis ; Lücke\r\n"
                          "LIN {X 100,Y 0,Z 50}"),
                  path, displaced(path, by));
  EXPECT_EQ(result.src,
            "  PTP {X 0,Y 0.1234,Z -0.05,A 1,B 2,C 3,S 2,T 10}\r\n"
            "lin  { x 100.0 , y 0.123440, Z -0.050,A 5 } c_dis ; Lücke\r\n"
            "LIN {X 100,Y 0,Z 50}");
  EXPECT_EQ(result.corrected, 2);
  EXPECT_EQ(result.left_alone, 1);
  EXPECT_THAT(result.warnings, ElementsAre("p.src:3: left alone: ends off the path"));
}

// At B = 90 only A - C is defined: C is that of the end.
TEST(Krl, PointsAreInsertedWhereTheCorrectionBends) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d& p) { return Vector3d(0, p.x() < 40 ? p.x() / 400 : 0.1, 0); };
  const Corrected result =
      correct_krl(program("LIN {X 0,Y 0,Z 0,A 0,B 90,C 0,E1 0}\r\n"
                          "\tLIN {X 100,Y 0,Z 0,A 0,B 90,C 50,E1 10,S 2} ;on\r\n"),
                  path, displaced(path, by));
  EXPECT_EQ(result.src,
            "LIN {X 0,Y 0,Z 0,A 0,B 90,C 0,E1 0}\r\n"
            "\tLIN {X 40,Y 0.1,Z 0,A 30,B 90,C 50,E1 4,S 2} C_DIS\r\n"
            "\tLIN {X 100,Y 0.1,Z 0,A 0,B 90,C 50,E1 10,S 2} ;on\r\n");
  EXPECT_EQ(result.inserted, 1);
  EXPECT_THAT(result.warnings, IsEmpty());
}

// A controller cannot read a move for each sample: a step is as long as the least distance.
TEST(Krl, InsertedPointsKeepTheirDistance) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}}, 0.1);
  const auto by = [](const Vector3d& p) {
    return Vector3d(0, p.x() < 40.05 ? 0 : 0.5, 0.05 * std::sin(p.x()));
  };
  const Corrected result = correct_krl(program("LIN {X 0,Y 0,Z 0}\nLIN {X 100,Y 0,Z 0}\n"), path,
                                       displaced(path, by), {.spacing = 2 * kMm});
  double last = -1e9;
  const std::vector<std::string> lines = lines_of(result.src);
  EXPECT_GT(lines.size(), 25U);
  for (const std::string& line : lines) {
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "LIN {X %lf,Y %lf", &x, &y), 2) << line;
    EXPECT_GE(x - last, 1.9999) << line;
    EXPECT_NEAR(y, by({x, 0, 0}).y(), 1e-4) << line;
    last = x;
  }
}

// What the correction moves along a straight move is no bend.
TEST(Krl, AlongTheMoveNothingIsInserted) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const Corrected result = correct_krl(
      program("LIN {X 0,Y 0,Z 0}\nLIN {X 100,Y 0,Z 0}\n"), path,
      displaced(path, [](const Vector3d& p) { return Vector3d(std::max(0.0, p.x() - 91), 1, 0); }));
  EXPECT_EQ(result.src, "LIN {X 0,Y 1,Z 0}\nLIN {X 109,Y 1,Z 0}\n");
}

TEST(Krl, TheOrientationBetweenIsTheRotationBetween) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d& p) { return Vector3d(0, 0, p.x() < 30 ? 0 : 0.1); };
  const auto rotation = [](double a, double b, double c) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(a * M_PI / 180, Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(b * M_PI / 180, Vector3d::UnitY()) *
                              Eigen::AngleAxisd(c * M_PI / 180, Vector3d::UnitX()));
  };
  const Corrected result = correct_krl(program("LIN {X 0,Y 0,Z 0,A 170,B -90,C 20}\n"
                                               "LIN {X 100,Y 0,Z 0,A -130,B 60,C -80}\n"),
                                       path, displaced(path, by));
  ASSERT_EQ(result.inserted, 2);  // at 29 and 30 mm
  const auto samples = Controller(result.src, "").samples;
  const auto& rest = samples[1].rest;
  const Eigen::Quaterniond expected = rotation(170, -90, 20).slerp(0.29, rotation(-130, 60, -80));
  EXPECT_LT(rotation(rest[0], rest[1], rest[2]).angularDistance(expected), 1e-5);
}

TEST(Krl, WithoutOrientationNoneIsInserted) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d& p) {
    return Vector3d(0, p.x() < 50 ? 0 : (p.x() - 50) / 500, 0);
  };
  const Corrected result =
      correct_krl(program("LIN {X 0,Y 0,Z 0}\nSLIN {X 100.000} WITH $VEL.CP=0.1\nLIN {X 0,Y 0}\n"),
                  path, displaced(path, by));
  EXPECT_THAT(lines_of(result.src),
              ElementsAre("LIN {X 0,Y 0,Z 0}", "SLIN {X 50.000} WITH $VEL.CP=0.1 C_SPL",
                          "SLIN {X 100.000,Y 0.1} WITH $VEL.CP=0.1", "LIN {X 0,Y 0}"));
}

TEST(Krl, WhatAFrameLeavesOutIsAddedWhereItNoLongerHolds) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}, {100, 50, 0}});
  const auto by = [](const Vector3d& p) { return Vector3d(p.y() / 100, p.x() / 1000, 0); };
  const Corrected result = correct_krl(
      program("LIN {X 0,Y 0,Z 0}\nLIN {X 100}\nLIN {E6POS: Y 50}\nLIN {Z 30}\nLIN {A 5}\n"), path,
      displaced(path, by));
  EXPECT_THAT(lines_of(result.src),
              ElementsAre("LIN {X 0,Y 0,Z 0}", "LIN {X 100,Y 0.1}", "LIN {E6POS: Y 50.1,X 100.5}",
                          "LIN {Z 30}", "LIN {A 5}"));
  const Corrected turned = correct_krl(program("LIN {X 0,Y 0,Z 0}\nLIN {X 100}\nLIN {A 5}\n"), path,
                                       displaced(path, by));
  EXPECT_THAT(lines_of(turned.src),
              ElementsAre("LIN {X 0,Y 0,Z 0}", "LIN {X 100,Y 0.1}", "LIN {A 5}"));
}

TEST(Krl, ANamedPointIsChangedWhereItIsDeclared) {
  const std::string dat =
      "DECL E6POS XA={X 0,Y 0,Z 0,S 2}\nDECL E6POS XB={X 100.0,Y 0,Z 0}, XC={X 100,Y 50,Z 0}\n";
  const std::string src = "LIN XA\nLIN xb C_DIS\nLIN XC\n";
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}, {100, 50, 0}});
  const Corrected result =
      correct_krl(program(src, dat), path,
                  displaced(path, [](const Vector3d&) { return Vector3d(0, 0, 0.1); }));
  EXPECT_EQ(result.src, src);
  EXPECT_EQ(result.dat,
            "DECL E6POS XA={X 0,Y 0,Z 0.1,S 2}\nDECL E6POS XB={X 100.0,Y 0,Z 0.1}, "
            "XC={X 100,Y 50,Z 0.1}\n");
}

// A closed contour begins and ends at one point; the tool is not off by the same there.
TEST(Krl, APointWithTwoCorrectionsIsWrittenIntoItsMoves) {
  const std::string dat = "DECL E6POS XA={X 0,Y 0,Z 0,S 2,T 1}\n";
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}, {100, 50, 0}, {0, 0, 0}}, 1000);
  Eigen::Matrix3Xd corrected = path.position;
  corrected(2, 3) += 0.1 * kMm;
  const Corrected result = correct_krl(
      program("PTP XA\nLIN {X 100,Y 0,Z 0}\nLIN {X 100,Y 50,Z 0}\nLIN XA ; closed\n", dat), path,
      corrected);
  EXPECT_EQ(result.dat, dat);
  EXPECT_THAT(lines_of(result.src),
              ElementsAre("PTP XA", "LIN {X 100,Y 0,Z 0}", "LIN {X 100,Y 50,Z 0}",
                          "LIN {X 0,Y 0,Z 0.1,S 2,T 1} ; closed"));
}

TEST(Krl, ADeclarationThatLeavesOutCoordinatesIsEachTimeAnotherPoint) {
  const std::string dat = "DECL E6POS XB={X 100}\n";
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}, {0, 50, 0}, {100, 50, 0}}, 1000);
  const auto by = [](const Vector3d& p) { return Vector3d(0, p.x() / 1000, 0); };
  const Corrected result =
      correct_krl(program("LIN {X 0,Y 0,Z 0}\nLIN XB\nLIN {X 0,Y 50,Z 0}\nLIN XB\n", dat), path,
                  displaced(path, by));
  EXPECT_EQ(result.dat, dat);
  EXPECT_THAT(lines_of(result.src), ElementsAre("LIN {X 0,Y 0,Z 0}", "LIN {X 100,Y 0.1}",
                                                "LIN {X 0,Y 50,Z 0}", "LIN {X 100,Y 50.1}"));
}

TEST(Krl, APointOfAMoveThatIsLeftAloneKeepsItsValueThere) {
  const std::string dat = "DECL E6POS XA={X 0,Y 0,Z 0}\n";
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d&) { return Vector3d(0, 0.1, 0); };
  for (const std::string move : {"CIRC XA,XFAR", "CIRC XFAR,XA", "SCIRC XA,{A1 5}"}) {
    const std::string back = move + "\nLIN {X 0,Y 0,Z 50}\n" + move + "\n";
    const Corrected result = correct_krl(program("LIN XA\nLIN {X 100,Y 0,Z 0}\n" + back, dat), path,
                                         displaced(path, by));
    EXPECT_EQ(result.dat, dat);
    EXPECT_EQ(result.src, "LIN {X 0,Y 0.1,Z 0}\nLIN {X 100,Y 0.1,Z 0}\n" + back);
  }
}

// The path shows that the arm comes from the point before, whatever stands between.
TEST(Krl, APointThatOthersOnlyReadStaysWhereItIsDeclaredAndItsMovesAreCorrected) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d&) { return Vector3d(0, 0.1, 0); };
  for (const std::string use : {"XH=XA\n", "XH.X=XA.X+SQRT(2)*5\n", "IF XA.X>5 THEN\nENDIF\n"}) {
    const Corrected read =
        correct_krl(program("LIN XA\n" + use, "DECL POS XA={X 0,Y 0,Z 0}\nDECL POS XH\n"), path,
                    displaced(path, by));
    EXPECT_EQ(read.src, "LIN {X 0,Y 0.1,Z 0}\n" + use);
  }
  for (const std::string use : {"XA=XH\n", "XA.X=XH.X\n", "XH=f(XA)\n", "sub(XA)\n",
                                "TRIGGER WHEN DISTANCE=0 DELAY=0 DO XA=XH\n"}) {
    const std::string src = "LIN {X 0,Y 0,Z 0}\nLIN XA\n" + use;
    const Corrected changed = correct_krl(
        program(src, "DECL POS XA={X 100,Y 0,Z 0}\nDECL POS XH\n"), path, displaced(path, by));
    EXPECT_THAT(changed.src, HasSubstr("\nLIN XA\n")) << use;
    EXPECT_EQ(changed.left_alone, 1) << use;
  }
}

TEST(Krl, BehindABranchAMoveIsDividedWhereThePathGoesStraight) {
  const auto by = [](const Vector3d& p) { return Vector3d(0, 0, p.x() < 50 ? 0 : p.x() / 500); };
  const Texts branch = program("LIN {X 0,Y 0,Z 0}\nIF a THEN\nLIN {X 100,Y 0,Z 0}\nENDIF\n");
  const Path straight = path_through({{0, 0, 0}, {100, 0, 0}});
  EXPECT_EQ(correct_krl(branch, straight, displaced(straight, by)).inserted, 2);
  const Path round = path_through({{0, 0, 0}, {0, 40, 0}, {100, 40, 0}, {100, 0, 0}});
  EXPECT_EQ(correct_krl(branch, round, displaced(round, by)).inserted, 0);
}

TEST(Krl, AToolInTheRoomIsCorrectedAndNamed) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d&) { return Vector3d(0, 0.1, 0); };
  const Corrected result =
      correct_krl(program("$IPO_MODE=#TCP\nLIN {X 0,Y 0,Z 0}\n"), path, displaced(path, by));
  EXPECT_EQ(result.src, "$IPO_MODE=#TCP\nLIN {X 0,Y 0.1,Z 0}\n");
  EXPECT_THAT(result.warnings, ElementsAre(HasSubstr("p.src:2: its tool stands in the room")));
}

// Others use it too: the declaration stays.
TEST(Krl, ASharedPointIsWrittenIntoItsMoves) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d&) { return Vector3d(0, 0.1, 0); };
  for (const auto& [declaration, move] : std::vector<std::pair<std::string, std::string>>{
           {"DECL GLOBAL E6POS XA={X 0,Y 0,Z 0}\n", ""},
           {"DECL E6POS XA={X 0,Y 0,Z 0}\n", "LIN XA:{Z 50}\n"}}) {
    const Corrected result = correct_krl(program(move + "LIN XA\nLIN {X 100}\n", declaration), path,
                                         displaced(path, by));
    EXPECT_EQ(result.dat, declaration);
    EXPECT_EQ(result.src, move + "LIN {X 0,Y 0.1,Z 0}\nLIN {X 100}\n");
  }
}

TEST(Krl, WhatCannotBeCorrectedIsLeftAloneAndNamed) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const std::string src =
      "LIN {X 0,Y 0,Z 0}\n"
      "PTP {A1 0,A2 -90}\n"
      "LIN_REL {X 10}\n"
      "LIN XHOME\n"
      "LIN P1\n"
      "LIN {X 100*1,Y 0,Z 0}\n"
      "LIN {X 100}\n"
      "CIRC {X 0,Y 0,Z 0}\n"
      "PTP $POS_ACT\n"
      "PTP XAX\n"
      "LIN {X 100,Y 0,Z 0}\n"
      "P1={X 0,Y 0,Z 0}\n"
      "P1.X=5\n";
  const auto by = [](const Vector3d&) { return Vector3d(0, 0.1, 0); };
  const Corrected result = correct_krl(program(src, "DECL POS P1\nDECL E6AXIS XAX={A1 0,A2 0}\n"),
                                       path, displaced(path, by));
  std::vector<std::string> expected = lines_of(src);
  expected[0] = "LIN {X 0,Y 0.1,Z 0}";
  expected[10] = "LIN {X 100,Y 0.1,Z 0}";
  EXPECT_EQ(lines_of(result.src), expected);
  EXPECT_EQ(result.corrected, 2);
  EXPECT_EQ(result.left_alone, 8);
  EXPECT_THAT(
      result.warnings,
      ElementsAre(
          "p.src:2: left alone: joint angles that are not six plain numbers; also lines 10",
          "p.src:3: left alone: a relative move; it starts from the corrected point before it",
          "p.src:4: left alone: HOME, which $config.dat declares and other programs use; give it: "
          "--with '$config.dat'",
          "p.src:5: left alone: its point is given several values, or changed at run time",
          "p.src:6: left alone: its target is an expression or has no plain numbers; also lines 8",
          "p.src:7: left alone: X, Y, Z are not all stated, and the move before does not state "
          "them"));
}

TEST(Krl, NothingIsInsertedWhereItWouldMeanSomethingElse) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto by = [](const Vector3d& p) { return Vector3d(0, std::sin(p.x() / 10), 0); };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"LIN {X 0,Y 0,Z 0}\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[1]=TRUE\nLIN {X 100,Y 0}\n",
       "p.src:3: the correction bends along this move, but no points are inserted: a TRIGGER "
       "refers to it"},
      {"LIN {X 0,Y 0,Z 0}\nSPLINE\nSLIN {X 100,Y 0}\nENDSPLINE\n",
       "p.src:3: the correction bends along this move, but no points are inserted: it stands in "
       "a spline block"},
      {"LIN {X 0,Y 0,Z 0}\nLIN {X 100,Y 0,A 90}\n",
       "p.src:2: the correction bends along this move, but no points are inserted: the orientation "
       "before it is not known"}};
  for (const auto& [src, warning] : cases) {
    const Corrected result = correct_krl(program(src), path, displaced(path, by));
    EXPECT_EQ(result.inserted, 0);
    EXPECT_THAT(result.warnings, ElementsAre(warning));
  }
}

TEST(Krl, SaysWhatTheControllerOrTheProgramAddsToIt) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const Corrected result = correct_krl(program("$ABS_ACCUR=TRUE\n"
                                               "$BASE=BASE_DATA[1]\n"
                                               "LIN {X 0,Y 0,Z 0}\n"
                                               "LOOP\n"
                                               "$base = base_data[1]\n"
                                               "LIN {X 50,Y 0,Z 0}\n"
                                               "ENDLOOP\n"
                                               "BAS(#BASE,2)\n"
                                               "LIN {X 100,Y 0,Z 0}\n"),
                                       path, path.position);
  ASSERT_EQ(result.warnings.size(), 3u);
  EXPECT_THAT(result.warnings[0], HasSubstr("p.src:1: $ABS_ACCUR"));
  EXPECT_THAT(result.warnings[1], HasSubstr("p.src:6: stands in a loop"));
  EXPECT_THAT(result.warnings[2],
              HasSubstr("p.src:9: $BASE is another one than of the first corrected "
                        "move (line 3)"));
  EXPECT_THAT(correct_krl(program("$ABS_ACCUR=FALSE\n; $ABS_ACCUR\nLIN {X 0,Y 0,Z 0}\n"), path,
                          path.position)
                  .warnings,
              IsEmpty());
}

TEST(Krl, APathThatIsNotTheProgramsIsAnError) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  expect_error(
      [&] { correct_krl(program("LIN {X 0,Y 5,Z 0}\nLIN {X 50,Y 2,Z 0}\n"), path, path.position); },
      "p.src: no point of the program lies on the programmed path; the nearest, in line 2 at "
      "(50.000, 2.000, 0.000) mm, is 2.000 mm off");
  expect_error([&] { correct_krl(program("LIN XP1\nLIN XP2\n"), path, path.position); },
               "p.src: has no move to a point with plain numbers, read as krl: p.src:1: left "
               "alone: its point "
               "is declared neither here nor in the .dat");
  // An array without values is declared, and its elements are set as the program runs.
  expect_error(
      [&] {
        correct_krl(program("DECL POS XCUT[2]\nXCUT[1]=XA:XB\nLIN XCUT[1]\n"), path, path.position);
      },
      "p.src: has no move to a point with plain numbers, read as krl: p.src:3: left alone: its "
      "point is given several values, or changed at run time");
  expect_error([] { program_of_file("/nowhere/p.src"); }, "/nowhere/p.src: No such file");
}

// The record begins and ends within a move: beyond, the correction fades out.
TEST(Krl, FewPointsOnThePathAreDoubted) {
  const Path path = path_through({{0, 0, 0}, {100, 0, 0}});
  const auto doubts = [&](const std::string& src) {
    const auto warnings = correct_krl(program(src), path, path.position).warnings;
    return std::count_if(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("p.src:2: only 1 of the 3 points") == 0;
    });
  };
  EXPECT_EQ(doubts("LIN {X 0,Y 0,Z 0}\nLIN {X 100,Y 5,Z 0}\nLIN {X 200,Y 5,Z 0}\n"), 1);
  EXPECT_EQ(doubts("LIN {X 0,Y 0,Z 0}\nLIN {X 100,Y 0,Z 0}\nLIN {X 200,Y 5,Z 0}\n"), 0);
}

TEST(Krl, AMoveThatThePathCoversInPartIsCorrectedThere) {
  const Path path = path_through({{60, 0, 0}, {100, 0, 0}, {100, 30, 0}});
  const auto by = [](const Vector3d&) { return Vector3d(0, 0, 0.1); };
  const Corrected result =
      correct_krl(program("LIN {X 0,Y 0,Z 0}\nLIN {X 100,Y 0,Z 0}\nLIN {X 100,Y 90,Z 0}\n"), path,
                  displaced(path, by));
  EXPECT_THAT(
      lines_of(result.src),
      ElementsAre("LIN {X 0,Y 0,Z 0}", "LIN {X 60,Y 0,Z 0.1} C_DIS", "LIN {X 100,Y 0,Z 0.1}",
                  "LIN {X 100,Y 30,Z 0.1} C_DIS", "LIN {X 100,Y 90,Z 0}"));
}

// A controller that shares nothing with the reader runs the corrected program: it goes where the
// path was corrected to, and what it says of orientation and external axes at the program's own
// points is what it said before.
void expect_follows(const Texts& before, const Path& path, const Eigen::Matrix3Xd& corrected) {
  const Corrected after = correct_krl(before, path, corrected);
  const auto samples = Controller(after.src, after.dat).samples;
  double worst = 0;
  for (Eigen::Index i = 0; i < corrected.cols(); i += 11)
    worst = std::max(worst, distance_to(samples, corrected.col(i) / kMm));
  const double tolerance = DisplacementOptions{}.tolerance / kMm;
  const double rounding = 1e-4, chord_of_oracle = 1e-3;
  EXPECT_LT(worst, tolerance + rounding + chord_of_oracle);
}

// A step of the correction is passed on a piece too short for a circle.
TEST(Krl, PiecesOfACircleThatAreStraightAreLines) {
  std::vector<Vector3d> corners;
  for (int k = 0; k <= 400; ++k)
    corners.push_back({100 * std::cos(k * M_PI / 400), 100 * std::sin(k * M_PI / 400), 0});
  const Path path = path_through(corners);
  const auto stepped = [&](Eigen::Index from) {
    Eigen::Matrix3Xd corrected = path.position;
    for (Eigen::Index i = from; i < corrected.cols(); ++i) corrected(2, i) += 0.1 * kMm;
    return corrected;
  };
  const Texts half =
      program("LIN {X 100,Y 0,Z 0}\n scirc  {X 0,Y 100,Z 0} , {X -100,Y 0,Z 0} ; half\n");
  const DisplacementOptions anywhere{.spacing = 0};
  EXPECT_THAT(lines_of(correct_krl(half, path, stepped(200), anywhere).src),
              ElementsAre("LIN {X 100,Y 0,Z 0}",
                          " scirc  {X 70.9878,Y 70.4325,Z 0} , {X 0.7854,Y 99.9969,Z 0} C_SPL",
                          " SLIN  {X 0,Y 100,Z 0.1} C_SPL",
                          " scirc  {X -70.7107,Y 70.7107,Z 0.1} , {X -100,Y 0,Z 0.1} ; half"));
  EXPECT_THAT(lines_of(correct_krl(half, path, stepped(400), anywhere).src),
              ElementsAre("LIN {X 100,Y 0,Z 0}",
                          " scirc  {X 0.3927,Y 99.9992,Z 0} , {X -99.9969,Y 0.7854,Z 0} C_SPL",
                          " SLIN  {X -100,Y 0,Z 0.1} ; half"));
}

TEST(Krl, ATaughtProgramFollowsTheCorrectedPath) {
  const Path path = contour();
  expect_follows(program_of_file(kFolder + "kontur.src"), path,
                 displaced(path, [](const Vector3d& p) {
                   return Vector3d(0.2 * std::sin(p.y() / 30), 0.3 * std::cos(p.x() / 40),
                                   0.1 * std::sin((p.x() + p.y()) / 50));
                 }));
}

RC_GTEST_PROP(Krl, AnyProgramOfLinesAndArcsFollowsTheCorrectedPath, ()) {
  const auto number = [](int low, int high) { return *rc::gen::inRange(low, high) / 10.0; };
  std::vector<Vector3d> corners{{number(-900, 900), number(-900, 900), 0}};
  const auto frame = [](const Vector3d& p) {
    std::ostringstream text;
    text << "{X " << p.x() << ",Y " << p.y() << ",Z " << p.z() << "}";
    return text.str();
  };
  std::string src = "LIN " + frame(corners.back()) + "\n";
  const int moves = *rc::gen::inRange(1, 6);
  for (int i = 0; i < moves; ++i) {
    const Vector3d start = corners.back();
    if (*rc::gen::arbitrary<bool>()) {
      // What stays as it was is left out.
      Vector3d end = start;
      src += "LIN {";
      for (const int axis :
           *rc::gen::elementOf(std::vector<std::vector<int>>{{0}, {1, 2}, {0, 1, 2}})) {
        end[axis] = number(-900, 900);
        std::ostringstream entry;
        entry << (src.back() == '{' ? "" : ",") << "XYZ"[axis] << ' ' << end[axis];
        src += entry.str();
      }
      src += "} C_DIS\n";
      corners.push_back(end);
    } else {  // half a circle about a point beside, level
      const Vector3d radius(number(200, 600), number(200, 600), 0);
      const Vector3d across(-radius.y(), radius.x(), 0);
      for (int k = 1; k <= 720; ++k)
        corners.push_back(start - radius + std::cos(k * M_PI / 720) * radius +
                          std::sin(k * M_PI / 720) * across);
      src += "CIRC " + frame(start - radius + across) + "," + frame(start - 2 * radius) + "\n";
      corners.back() = start - 2 * radius;
    }
  }
  const Path path = path_through(corners);
  const double phase = number(0, 62), wave = 20 + number(0, 500);
  const Eigen::Matrix3Xd corrected = displaced(path, [&](const Vector3d& p) {
    return Vector3d(0.2 * std::sin(p.y() / wave + phase), 0.2 * std::cos(p.x() / wave),
                    0.1 * std::sin((p.x() + p.y()) / wave));
  });
  expect_follows(program(src), path, corrected);
  RC_ASSERT(correct_krl(program(src), path, path.position).src == src);
}

}  // namespace
}  // namespace armtrue::krl_test
