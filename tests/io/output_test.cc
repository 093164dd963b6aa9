#include "armtrue/io/output.h"
#include "armtrue/io/inputs_stay.h"
#include "armtrue/io/output_folder.h"
#include "armtrue/io/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "support/temporary_file.h"

namespace armtrue::output_test {
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

// A folder of its own, gone at the end of the scope.
struct TemporaryFolder {
  TemporaryFolder() {
    char name[] = "/tmp/armtrue-test-XXXXXX";
    path = mkdtemp(name);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path))
      names.push_back(entry.path().filename());
    std::ranges::sort(names);
    return names;
  }
  std::string path;
};

TEST(Output, ProductsThatBelongTogetherReplaceTheOldOnes) {
  const TemporaryFolder folder;
  const std::string dat = folder.path + "/p.dat", src = folder.path + "/p.src";
  write_outputs({{dat, "old data"}, {src, "old moves"}});
  write_outputs({{dat, "new data"}, {src, "new moves"}});
  EXPECT_EQ(text_of(dat), "new data");
  EXPECT_EQ(text_of(src), "new moves");
  EXPECT_THAT(folder.files(), testing::ElementsAre("p.dat", "p.src"));
}

TEST(Output, IfOneProductFailsTheOldOnesStay) {
  const TemporaryFolder folder;
  const std::string dat = folder.path + "/p.dat";
  const std::string unwritable = folder.path + "/" + std::string(255, 'x');
  write_output(dat, "old data");
  EXPECT_THROW(write_outputs({{dat, "new data"}, {unwritable, "new moves"}}), OutputError);
  EXPECT_EQ(text_of(dat), "old data");
  EXPECT_THAT(folder.files(), testing::ElementsAre("p.dat"));
}

// SIGTERM at any moment: the process ends, the file is whole, and no temporary file is left.
TEST(Output, ASignalLeavesNoTemporaryFile) {
  const std::string old_text(1 << 16, 'a'), new_text(1 << 16, 'b');
  for (int delay = 0; delay < 40; ++delay) {
    const TemporaryFolder folder;
    const std::string path = folder.path + "/product";
    write_output(path, old_text);
    const pid_t child = fork();
    if (child == 0)
      while (true) write_output(path, new_text);
    usleep(static_cast<useconds_t>(1000 + 137 * delay));
    kill(child, SIGTERM);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_THAT(text_of(path), testing::AnyOf(old_text, new_text));
    EXPECT_THAT(folder.files(), testing::ElementsAre("product"));
  }
}

// SIGKILL cannot wait: the files under the two names are never of different runs.
TEST(Output, AKilledProcessLeavesNoMixture) {
  for (int delay = 0; delay < 40; ++delay) {
    const TemporaryFolder folder;
    const std::string dat = folder.path + "/p.dat", src = folder.path + "/p.src";
    write_outputs({{dat, "0"}, {src, "0"}});
    const pid_t child = fork();
    for (int run = 1; child == 0; ++run)
      write_outputs({{dat, std::to_string(run)}, {src, std::to_string(run)}});
    usleep(static_cast<useconds_t>(1000 + 137 * delay));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (std::filesystem::exists(dat) && std::filesystem::exists(src))
      EXPECT_EQ(text_of(dat), text_of(src));
    else
      EXPECT_GT(folder.files().size(), 2);  // set aside
  }
}

TEST(Output, AFileIsTheSameByAnyName) {
  const TemporaryFile file("text");
  const std::string link = file.path + ".link", hard = file.path + ".hard";
  std::filesystem::create_symlink(file.path, link);
  std::filesystem::create_hard_link(file.path, hard);
  EXPECT_TRUE(same_file(file.path, link));
  EXPECT_TRUE(same_file(file.path, hard));
  EXPECT_TRUE(same_file("/no/such/file", "/no/../no/such/file"));
  EXPECT_FALSE(same_file(file.path, "/no/such/file"));
  std::filesystem::remove(link);
  std::filesystem::remove(hard);
}

TEST(Output, OnlyDescriptorsAndWhatIsNoFileAreWrittenToAsTheyStand) {
  const TemporaryFile file("text");
  const std::string link = file.path + ".link";
  std::filesystem::create_symlink("/dev/stdout", link);
  EXPECT_TRUE(is_device_or_pipe("/dev/null"));
  EXPECT_TRUE(is_device_or_pipe("/dev/stdout"));
  EXPECT_TRUE(is_device_or_pipe("/proc/self/fd/1"));
  EXPECT_TRUE(is_device_or_pipe(link));
  EXPECT_FALSE(is_device_or_pipe(file.path));
  EXPECT_FALSE(is_device_or_pipe("/dev/shm/armtrue-none"));
  std::filesystem::remove(link);
}

mode_t mode_of(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

TEST(Output, AReplacedFileKeepsItsMode) {
  const TemporaryFolder folder;
  const std::string one = folder.path + "/a", other = folder.path + "/b";
  for (const mode_t mode : {0600U, 0640U, 0755U, 02775U}) {
    write_outputs({{one, "old"}, {other, "old"}});
    ASSERT_EQ(chmod(one.c_str(), mode), 0);
    write_output(one, "new");
    EXPECT_EQ(mode_of(one), mode);
    write_outputs({{other, "new"}, {one, "newer"}});
    EXPECT_EQ(mode_of(one), mode);
  }
  EXPECT_EQ(text_of(one), "newer");
}

TEST(Output, AReplacedFolderKeepsItsModeAndThoseOfItsPictures) {
  const TemporaryFolder folder;
  const std::string pictures = folder.path + "/pictures";
  const std::string text = "<svg xmlns=\"http://www.w3.org/2000/svg\" data-by=\"armtrue\"/>";
  replace_folder(pictures, {{"a.svg", text}});
  ASSERT_EQ(chmod(pictures.c_str(), 0700), 0);
  ASSERT_EQ(chmod((pictures + "/a.svg").c_str(), 0600), 0);
  replace_folder(pictures, {{"a.svg", text}, {"b.svg", text}});
  EXPECT_EQ(mode_of(pictures), 0700);
  EXPECT_EQ(mode_of(pictures + "/a.svg"), 0600);
  EXPECT_TRUE(std::filesystem::exists(pictures + "/b.svg"));
}

TEST(Output, ALinkToNothingIsAnErrorAndStays) {
  const TemporaryFolder folder;
  const std::string link = folder.path + "/link", loop = folder.path + "/loop";
  std::filesystem::create_symlink("nothing", link);
  std::filesystem::create_symlink("loop", loop);
  for (const std::string& path : {link, loop}) {
    EXPECT_THROW(check_writable(path), OutputError);
    EXPECT_THROW(write_output(path, "text"), OutputError);
    EXPECT_THROW(replace_folder(path, {}), OutputError);
    EXPECT_TRUE(std::filesystem::is_symlink(path));
  }
  EXPECT_THAT(folder.files(), testing::ElementsAre("link", "loop"));
}

// Whatever led to its name.
TEST(Output, AFileThatWasReadIsNotWrittenByAnyName) {
  const TemporaryFile file("text");
  const std::string link = file.path + ".link", hard = file.path + ".hard";
  std::filesystem::create_symlink(file.path, link);
  std::filesystem::create_hard_link(file.path, hard);
  {
    const InputsStay inputs_stay;
    Source(file.path).read_all();
    for (const std::string& path : {file.path, link, hard}) {
      EXPECT_THROW(write_output(path, "product"), InputWouldBeLost);
      EXPECT_THROW(write_outputs({{file.path + ".other", "product"}, {path, "product"}}),
                   InputWouldBeLost);
      EXPECT_THROW(expect_output(path), InputWouldBeLost);
    }
    EXPECT_THROW(expect_output(std::filesystem::path(file.path).parent_path()), InputWouldBeLost);
    EXPECT_FALSE(std::filesystem::exists(file.path + ".other"));
    EXPECT_EQ(text_of(file.path), "text");
  }
  write_output(file.path, "after the run of the command");
  std::filesystem::remove(link);
  std::filesystem::remove(hard);
}

TEST(Output, AFileThatWillBeWrittenIsNotRead) {
  const TemporaryFile file("text");
  const InputsStay inputs_stay;
  expect_output(file.path);
  EXPECT_THROW(Source{file.path}, InputWouldBeLost);
  const Source null("/dev/null");
  expect_output("/dev/null");  // loses nothing
}

TEST(Output, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(write_output("/nowhere/at/all.csv", "text"), OutputError);
}

}  // namespace
}  // namespace armtrue::output_test
