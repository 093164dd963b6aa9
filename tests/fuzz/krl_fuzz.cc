// KUKA programs that are damaged in any way: read, corrected and written without a crash, and
// without displacement byte for byte. Built by clang with -fsanitize=fuzzer this is a libFuzzer
// target; else main() runs a fixed number of random changes of the programs it is given.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "armtrue/programs/krl.h"
#include "armtrue/text/input_error.h"
#include "fuzz/mutation.h"

namespace {

using armtrue::CorrectedKrl;
using armtrue::KrlProgram;
using armtrue::Path;

// Through the points of the programs in tests/programs/krl.
Path path() {
  const std::vector<Eigen::Vector3d> corners{
      {0, 0, -5},  {300, 0, -5}, {350, 50, -5}, {350, 200, -5}, {0, 0, 50}, {0, 0, 0},
      {100, 0, 0}, {110, 20, 0}, {100, 20, 0},  {100, 80, 0},   {0, 0, 0}};
  constexpr Eigen::Index kPerSide = 5;
  const auto sides = static_cast<Eigen::Index>(corners.size()) - 1;
  Path result;
  result.position.resize(3, sides * kPerSide + 1);
  for (Eigen::Index i = 0; i <= sides * kPerSide; ++i) {
    const auto side = static_cast<size_t>(std::min(i / kPerSide, sides - 1));
    const double t = static_cast<double>(i) / kPerSide - static_cast<double>(side);
    result.position.col(i) = 1e-3 * (corners[side] + t * (corners[side + 1] - corners[side]));
  }
  result.time = Eigen::VectorXd::LinSpaced(result.position.cols(), 0, 1);
  return result;
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << what << "\n";
  std::abort();
}

auto lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

}  // namespace

// The .src, and behind a zero byte the .dat.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  const size_t zero = input.find('\0');
  KrlProgram program{{"p.src", input.substr(0, zero)}, std::nullopt};
  if (zero != std::string::npos) program.dat = {"p.dat", input.substr(zero + 1)};
  static const Path programmed = path();
  try {
    const CorrectedKrl same = correct_krl(program, programmed, programmed.position);
    require(same.src == program.src.text, "the .src changed without displacement");
    require(!program.dat || *same.dat == program.dat->text,
            "the .dat changed without displacement");
    Eigen::Matrix3Xd corrected = programmed.position;
    for (Eigen::Index i = 0; i < corrected.cols(); ++i)
      corrected(i % 3, i) += 1e-4 * std::sin(static_cast<double>(i));
    const CorrectedKrl moved = correct_krl(program, programmed, corrected);
    require(lines(moved.src) == lines(program.src.text) + moved.inserted, "lines are lost");
  } catch (const armtrue::InputError&) {
  }
  return 0;
}

#ifndef ARMTRUE_LIBFUZZER

namespace {

const std::vector<std::string> kWords{"{",
                                      "}",
                                      ",",
                                      ":",
                                      "=",
                                      "[1]",
                                      ";",
                                      "\"",
                                      "\n",
                                      "\r\n",
                                      "X ",
                                      "Y -1e",
                                      "A1 0",
                                      "E6 ",
                                      "LIN ",
                                      "CIRC ",
                                      "PTP ",
                                      "SPLINE",
                                      "SPL ",
                                      "CA 90",
                                      "1e999",
                                      "-",
                                      "100",
                                      "0.0001",
                                      "nan",
                                      "LIN_REL",
                                      "DECL E6POS XP1={",
                                      "{E6POS: ",
                                      "XP1",
                                      "$BASE=",
                                      "TRIGGER",
                                      "ENDLOOP",
                                      "DEF x()",
                                      "&",
                                      std::string(1, '\0'),
                                      "\xFC"};

std::string read(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

// krl_fuzz COUNT PROGRAM...; a .dat beside a program is its second half
int main(int argc, char** argv) {
  std::vector<std::string> programs;
  for (int i = 2; i < argc; ++i) {
    const std::string name = argv[i], dat = read(name.substr(0, name.rfind('.')) + ".dat");
    programs.push_back(read(name) + (dat.empty() ? "" : '\0' + dat));
    require(programs.back().size() > 1, "no such program");
  }
  require(!programs.empty(), "usage: krl_fuzz COUNT PROGRAM...");
  armtrue::Mutation mutate(1, kWords);
  for (int i = 0; i < std::atoi(argv[1]); ++i) {
    const std::string input = mutate(programs[static_cast<size_t>(i) % programs.size()]);
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(input.data()), input.size());
  }
}

#endif
