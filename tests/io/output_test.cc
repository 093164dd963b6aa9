#include "armtrue/io/output.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "io/temporary_file.h"

namespace armtrue {
namespace {

std::string text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(Output, ReplacesAFileWhole) {
  const TemporaryFile file("before");
  write_output(file.path, "after");
  EXPECT_EQ(text_of(file.path), "after");
}

TEST(Output, ALinkStays) {
  const TemporaryFile file("before");
  const std::string link = file.path + ".link";
  std::filesystem::create_symlink(file.path, link);
  write_output(link, "after");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(text_of(file.path), "after");
  std::filesystem::remove(link);
}

TEST(Output, APipeIsWrittenToAndNotReplaced) {
  const TemporaryFile place("");
  const std::string pipe = place.path + ".pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { read = text_of(pipe); });
  write_output(pipe, "through");
  reader.join();
  EXPECT_EQ(read, "through");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  std::filesystem::remove(pipe);
}

TEST(Output, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(write_output("/nowhere/at/all.csv", "text"), OutputError);
}

}  // namespace
}  // namespace armtrue
