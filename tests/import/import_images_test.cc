// Images and joint angles joined, with a stand-in for what finds the corners.

#include "armtrue/import/import_images.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "armtrue/io/campaign_io.h"
#include "armtrue/kinematics/board_pattern.h"
#include "armtrue/text/input_error.h"
#include "support/temporary_file.h"

namespace armtrue::import_images_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

const std::string kHeader = "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg";

// A folder of files whose content is the number of corners that they show, and their width.
using Files = std::vector<std::pair<std::string, std::string>>;
class Folder {
 public:
  explicit Folder(const Files& files) {
    std::string name = (fs::temp_directory_path() / "armtrue-images-XXXXXX").string();
    path = mkdtemp(name.data());
    for (const auto& [file, content] : files) std::ofstream(fs::path(path) / file) << content;
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path;
};

ImageCorners stand_in(const BoardPattern&, const std::string& file, bool) {
  ImageCorners found;
  int corners = 0;
  std::ifstream(file) >> corners >> found.width;
  found.height = 480;
  for (int k = 0; k < corners; ++k) found.corners.push_back({k, 10.0 * k, found.width + 0.5});
  return found;
}

ImportedReadings import(const Folder& folder, const std::string& joints,
                        const std::string& camera = "") {
  return import_images({folder.path, board_pattern("checkerboard:3x4:20mm"), camera},
                       TemporaryFile(joints).path, {}, stand_in);
}

std::string error_of(const Folder& folder, const std::string& joints) {
  try {
    import(folder, joints);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// The poses, each once.
std::vector<std::string> poses_of(const ImportedReadings& readings) {
  return readings.campaign.pose_ids;
}

TEST(ImportImages, RowsBelongToTheNamesInTheOrderOfTheirNumbers) {
  const Folder folder(
      {{"im10.png", "4 640"}, {"im9.png", "5 640"}, {"im2.PNG", "6 640"}, {"notes.txt", "x"}});
  const ImportedReadings readings =
      import(folder, kHeader + "\n1,0,0,0,0,0\n2,0,0,0,0,0\n3,0,0,0,0,0\n");
  EXPECT_THAT(poses_of(readings), ElementsAre("im2", "im9", "im10"));
  const Campaign& c = readings.campaign;
  ASSERT_EQ(c.rows(), 15);
  EXPECT_NEAR(c.q[0][0], 0.017453292519943295, 1e-15);
  EXPECT_NEAR(c.q[6][0], 2 * 0.017453292519943295, 1e-15);
  EXPECT_NEAR(c.q[14][0], 3 * 0.017453292519943295, 1e-15);
  const std::string text = write_campaign(c);
  EXPECT_THAT(text, HasSubstr("pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,corner,u_px,v_px\n"
                              "im2,1,0,0,0,0,0,0,0,640.5\n"));
  EXPECT_THAT(text, HasSubstr("\nim10,3,0,0,0,0,0,3,30,640.5\n"));
}

TEST(ImportImages, AColumnNamesTheImages) {
  const Folder folder({{"a.png", "4 640"}, {"b.jpg", "4 640"}, {"c.png", "4 640"}});
  const ImportedReadings readings =
      import(folder,
             "image,t_s," + kHeader +
                 "\n/data/c.png,5,1,0,0,0,0,0\nb,6,2,0,0,0,0,0\nd.png,7,3,0,0,0,0,0\n",
             "left");
  EXPECT_THAT(poses_of(readings), ElementsAre("b", "c"));
  EXPECT_THAT(readings.warnings,
              ElementsAre(HasSubstr("left out: 1 of 3 rows, whose images"), HasSubstr("(a.png)")));
  EXPECT_EQ(readings.campaign.time_s.front(), 6);
  EXPECT_THAT(write_campaign(readings.campaign),
              HasSubstr("pose,t_s,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,camera,corner,u_px"));
}

TEST(ImportImages, VisitsOfAPoseAreNumbered) {
  const Folder folder({{"1.png", "4 640"}, {"2.png", "4 640"}, {"3.png", "4 640"}});
  const ImportedReadings readings =
      import(folder, "pose," + kHeader + "\nP,1,0,0,0,0,0\nQ,2,0,0,0,0,0\nP,1,0,0,0,0,0\n");
  EXPECT_THAT(poses_of(readings), ElementsAre("P", "Q"));
  ASSERT_FALSE(readings.campaign.repeat.empty());
  EXPECT_EQ(readings.campaign.repeat.front(), 1);
  EXPECT_EQ(readings.campaign.repeat.back(), 2);
}

TEST(ImportImages, AnImageWithoutABoardIsNamedAndLeftOut) {
  const Folder folder({{"1.png", "4 640"}, {"2.png", "3 640"}, {"3.png", "0 640"}});
  const std::string joints = kHeader + "\n1,0,0,0,0,0\n2,0,0,0,0,0\n3,0,0,0,0,0\n";
  const ImportedReadings readings = import(folder, joints);
  EXPECT_THAT(poses_of(readings), ElementsAre("1"));
  EXPECT_THAT(readings.warnings,
              ElementsAre(HasSubstr("left out: 2 of 3 images, in which the board "
                                    "'checkerboard:3x4:20mm' is not found (2.png, 3.png)")));
}

TEST(ImportImages, WhatDoesNotFitIsAnErrorWithItsRemedy) {
  const std::string row = "\n1,0,0,0,0,0";
  const Folder three({{"1.png", "4 640"}, {"2.png", "4 640"}, {"3.png", "4 640"}});
  EXPECT_THAT(error_of(three, kHeader + row + row + "\n"),
              HasSubstr("has 2 rows, and " + three.path + " has 3 images (1.png to 3.png)"));
  EXPECT_THAT(error_of(three, "image," + kHeader + "\nx.png,1,0,0,0,0,0\n"),
              HasSubstr("column 'image' names no file of " + three.path));
  EXPECT_THAT(error_of(three, "image," + kHeader + "\n1,1,0,0,0,0,0\n1.png,2,0,0,0,0,0\n"),
              HasSubstr(":3: column 'image': '1.png' stands in line 2 too"));
  EXPECT_THAT(error_of(Folder(Files{{"1.png", ""}, {"1.jpg", ""}}),
                       "image," + kHeader + "\n1,1,0,0,0,0,0\n"),
              HasSubstr("'1' may be 1.jpg or 1.png"));
  EXPECT_THAT(
      error_of(Folder(Files{{"1.txt", ""}}), kHeader + row + "\n"),
      HasSubstr("has no image (.png, .jpg, .bmp, .tif, .pgm, .ppm, .webp) among its 1 entry"));
  EXPECT_THAT(
      error_of(Folder(Files{{"1.png", "4 640"}, {"2.png", "4 800"}}), kHeader + row + row + "\n"),
      HasSubstr("'2.png' has 800 x 480 pixels and '1.png' 640 x 480"));
  EXPECT_THAT(error_of(Folder(Files{{"1.png", "0 640"}}), kHeader + row + "\n"),
              HasSubstr("none of 1 image shows the board 'checkerboard:3x4:20mm'; count"));
}

TEST(ImportImages, PatternsAreReadAsPeopleWriteThem) {
  EXPECT_EQ(points_of(board_pattern("checkerboard:9x6:2.5cm")).size(), 54u);
  EXPECT_EQ(points_of(board_pattern("charuco:7x5:0.03m:DICT_5X5_250")).size(), 24u);
  EXPECT_EQ(board_pattern("charuco:7x5:30mm:DICT_5X5_250").family, "5x5");
  EXPECT_EQ(board_pattern("charuco:7x6:30mm:legacy").is_legacy, true);
  const auto tags = points_of(board_pattern("apriltag:2x2:40mm:10mm:APRILTAG_36h11"));
  ASSERT_EQ(tags.size(), 16u);
  EXPECT_TRUE(tags[14].position.isApprox(Eigen::Vector3d(0.09, 0.09, 0), 1e-12));
  const auto circles = points_of(board_pattern("asymmetric-circles:4x11:20mm"));
  EXPECT_TRUE(circles[4].position.isApprox(Eigen::Vector3d(0.02, 0.02, 0), 1e-12));
  EXPECT_FALSE(is_symmetric(board_pattern("checkerboard:9x6:25mm")));
  EXPECT_TRUE(is_symmetric(board_pattern("checkerboard:8x6:25mm")));
  for (const char* wrong :
       {"", "chess", "checkerboard", "checkerboard:9x6", "checkerboard:9x6:25",
        "checkerboard:9:25mm", "checkerboard:9x6:-25mm", "checkerboard:9x6:0mm",
        "checkerboard:2x6:25mm", "checkerboard:9x6:25mm:5x5", "checkerboard:99999999999x6:25mm",
        "checkerboard:9x6:infmm", "charuco:7x5:30mm:22mm", "charuco:7x5:30mm:8x8",
        "apriltag:6x6:40mm", "circles:500x500:20mm",
        "checkerboard:9x6:25mm:", "apriltag:0x6:40mm:10mm"})
    EXPECT_THROW(board_pattern(wrong), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace armtrue::import_images_test
