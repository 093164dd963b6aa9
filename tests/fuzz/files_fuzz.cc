// Damaged files of one kind: each is read, or refused by an InputError, without a crash or an
// endless loop. ARMTRUE_READER is the reader. Built by clang with -fsanitize=fuzzer this is a
// libFuzzer target; else main() runs a fixed number of random changes of the files it is given.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "armtrue/diagnosis/log_check.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/compensation_io.h"
#include "armtrue/io/import/import_io.h"
#include "armtrue/io/path_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/io/urdf/urdf_io.h"
#include "armtrue/text/input_error.h"
#include "fuzz/mutation.h"

namespace {

void read_robot(const std::string& text) {
  const armtrue::Robot robot = armtrue::parse_robot(text, "robot.yaml");
  const std::string written = armtrue::write_robot(robot);
  if (armtrue::write_robot(armtrue::parse_robot(written, "written.yaml")) != written) std::abort();
}

// What is read can be written, as a robot file and into its document.
void read_urdf(const std::string& text) {
  const armtrue::Robot robot = armtrue::parse_urdf(text, "robot.urdf");
  try {
    armtrue::parse_robot(armtrue::write_robot(robot), "robot.yaml");
    armtrue::write_into_urdf(robot, text, "robot.urdf", {}, {});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    std::abort();
  }
}

void read_catalogue(const std::string& text) { armtrue::parse_catalogue(text, "catalogue.yaml"); }

// As a file in memory.
template <typename Reader>
void through_file(const std::string& text, const Reader& reader) {
  const int file = memfd_create("fuzz", 0);
  if (file < 0 || write(file, text.data(), text.size()) < 0) std::abort();
  try {
    reader("/proc/self/fd/" + std::to_string(file));
  } catch (...) {
    close(file);
    throw;
  }
  close(file);
}

void read_campaign(const std::string& text) {
  through_file(text, [](const std::string& name) {
    armtrue::check_log(armtrue::read_campaign(name).campaign);
  });
}

void read_path(const std::string& text) {
  through_file(text, [](const std::string& name) { armtrue::read_path(name); });
}

void read_import(const std::string& text) {
  through_file(text, [](const std::string& name) {
    armtrue::write_campaign(armtrue::import_readings(name, {}).campaign);
  });
}

void read_program(const std::string& text) {
  through_file(text, [](const std::string& name) { armtrue::read_program(name); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    ARMTRUE_READER(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const armtrue::InputError&) {
  }
  return 0;
}

#ifndef ARMTRUE_LIBFUZZER

namespace {

const std::vector<std::string> kWords{",",
                                      ";",
                                      ":",
                                      "\n",
                                      "\r\n",
                                      "- ",
                                      "? ",
                                      "[",
                                      "]",
                                      "{",
                                      "}",
                                      "&a ",
                                      "*a",
                                      "---\n",
                                      "'",
                                      "\"",
                                      "#",
                                      "|",
                                      "nan",
                                      "inf",
                                      "1e308",
                                      "-1e-320",
                                      "0",
                                      "-1",
                                      "1e999",
                                      "<a>",
                                      "</a>",
                                      "/>",
                                      "<!--",
                                      "<![CDATA[",
                                      "&#x;",
                                      "format: ",
                                      "<link name='a'/>",
                                      "rpy=\"0 0 nan\"",
                                      "series",
                                      "harmonic 1000000000",
                                      "A1.theta",
                                      "\xFC",
                                      std::string(1, '\0')};

std::string text_of(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

// files_fuzz COUNT FILE... Of a long file the first 20 kB are taken.
int main(int argc, char** argv) {
  constexpr size_t kLongest = 20'000;
  std::vector<std::string> texts;
  for (int i = 2; i < argc; ++i) {
    texts.push_back(text_of(argv[i]).substr(0, kLongest));
    if (texts.back().empty()) return std::cerr << argv[i] << ": no such file\n", 1;
  }
  if (texts.empty()) return std::cerr << "usage: files_fuzz COUNT FILE...\n", 1;
  armtrue::Mutation mutate(1, kWords);
  for (int i = 0; i < std::atoi(argv[1]); ++i) {
    const std::string input = mutate(texts[static_cast<size_t>(i) % texts.size()]);
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(input.data()), input.size());
  }
}

#endif
