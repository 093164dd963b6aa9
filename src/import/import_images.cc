#include "armtrue/import/import_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>
#include <vector>

#include "armtrue/io/inputs_stay.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/joint_stops.h"

namespace armtrue {
namespace {

namespace fs = std::filesystem;

constexpr size_t kNamesTold = 5;     // of images, in a message
constexpr int kFewestCorners = 4;    // from which the pose of a board follows
constexpr int kImagesExplained = 2;  // finding the reason takes ten times as long as the search

// Formats that cameras write and OpenCV reads.
bool is_image(const fs::path& path) {
  static const std::vector<std::string> kEnds{".png",  ".jpg", ".jpeg", ".bmp", ".tif",
                                              ".tiff", ".pgm", ".ppm",  ".webp"};
  return std::ranges::count(kEnds, lower_case(path.extension().string())) > 0;
}

// Image names in natural order: img2 before img10.
std::vector<std::string> image_names(const std::string& folder) {
  std::vector<std::string> names;
  size_t others = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->is_directory() && is_image(entry->path()))
      names.push_back(entry->path().filename().string());
    else
      ++others;
  }
  if (error)
    throw InputError(folder + ": " + error.message() +
                     "; give the folder in which the images of the campaign stand");
  if (names.empty())
    throw InputError(
        fmt::format("{}: has no image (.png, .jpg, .bmp, .tif, .pgm, .ppm, .webp) among its {}; "
                    "give the "
                    "folder in which the images of the campaign stand",
                    folder, counted(others, "entry")));
  std::ranges::sort(names, [](const std::string& a, const std::string& b) {
    const int order = strverscmp(a.c_str(), b.c_str());
    return order != 0 ? order < 0 : a < b;
  });
  return names;
}

std::string told(std::vector<std::string> names) {
  const bool more = names.size() > kNamesTold;
  if (more) names.resize(kNamesTold);
  return fmt::format("{}{}", fmt::join(names, ", "), more ? ", ..." : "");
}

struct Pair {
  std::string image;
  int row = 0;  // of the table of joint angles
};

// A table may name the whole path, or leave the extension out.
std::string bare(const std::string& name) {
  const size_t slash = name.find_last_of("/\\");
  return slash == std::string::npos ? name : name.substr(slash + 1);
}

std::string stem(const std::string& image) { return fs::path(image).stem().string(); }

class ImageJoin {
 public:
  ImageJoin(std::string folder, std::vector<std::string> images, const JointStops& stops,
            std::vector<std::string>& warnings)
      : folder_(std::move(folder)),
        images_(std::move(images)),
        stops_(stops),
        table_(stops.readings.campaign.source),
        warnings_(warnings) {}

  std::vector<Pair> pairs() const { return stops_.images.empty() ? by_order() : by_name(); }

 private:
  std::vector<Pair> by_order() const {
    const int rows = stops_.readings.campaign.rows();
    if (std::ssize(images_) != rows)
      throw InputError(fmt::format(
          "{}: has {}, and {} has {} ({} to {}); rows belong to images in the order "
          "of their names, so both need as many: add a column image with the name of the file, or "
          "take out what has no partner",
          table_, counted(rows, "row"), folder_, counted(images_.size(), "image"), images_.front(),
          images_.back()));
    std::vector<Pair> pairs;
    for (int row = 0; row < rows; ++row) pairs.push_back({images_[row], row});
    return pairs;
  }

  std::vector<Pair> by_name() const {
    std::map<std::string, std::vector<std::string>> files;  // by name, and by name without its end
    for (const std::string& image : images_) {
      files[image] = {image};
      files[stem(image)].push_back(image);
    }
    std::map<std::string, int> row_of;  // by file
    std::vector<std::string> missing;
    for (size_t row = 0; row < stops_.images.size(); ++row) {
      const std::string& cell = stops_.images[row];
      const auto found = files.find(bare(cell));
      if (found == files.end()) {
        missing.push_back(cell);
        continue;
      }
      const int line = stops_.readings.campaign.line[row];
      if (found->second.size() > 1)
        throw InputError(fmt::format("{}:{}: column 'image': '{}' may be {}; write the whole name",
                                     table_, line, cell, fmt::join(found->second, " or ")));
      const auto [place, is_new] = row_of.try_emplace(found->second.front(), row);
      if (!is_new)
        throw InputError(
            fmt::format("{}:{}: column 'image': '{}' stands in line {} too; an image is of one row",
                        table_, line, cell, stops_.readings.campaign.line[place->second]));
    }
    if (row_of.empty())
      throw InputError(fmt::format(
          "{}: column 'image' names no file of {}, whose images are {}; correct the names", table_,
          folder_, told(images_)));
    if (!missing.empty())
      warnings_.push_back(
          fmt::format("{}: left out: {} of {} rows, whose images {} does not have ({})", table_,
                      missing.size(), stops_.images.size(), folder_, told(missing)));
    std::vector<Pair> pairs;
    std::vector<std::string> alone;
    for (const std::string& image : images_)
      if (const auto row = row_of.find(image); row != row_of.end())
        pairs.push_back({image, row->second});
      else
        alone.push_back(image);
    if (!alone.empty())
      warnings_.push_back(fmt::format("{}: left out: {} of {} images, which have no row in {} ({})",
                                      folder_, alone.size(), images_.size(), table_, told(alone)));
    return pairs;
  }

  std::string folder_;
  std::vector<std::string> images_;
  const JointStops& stops_;
  std::string table_;
  std::vector<std::string>& warnings_;
};

struct SeenImage {
  Pair of;
  std::vector<SeenCorner> corners;
};

struct SeenImages {
  std::vector<SeenImage> images;
  int width = 0, height = 0;
};

SeenImages look(const ImageFolder& folder, const std::vector<Pair>& pairs,
                const FindCorners& find_corners, std::vector<std::string>& warnings) {
  SeenImages seen;
  std::vector<std::string> empty;
  std::string hint;
  for (const Pair& pair : pairs) {
    const bool explain =
        seen.images.empty() && hint.empty() && std::ssize(empty) < kImagesExplained;
    const std::string file = (fs::path(folder.folder) / pair.image).string();
    note_input(file);
    ImageCorners found = find_corners(folder.pattern, file, explain);
    if (hint.empty()) hint = found.hint;
    if (seen.width == 0) {
      seen.width = found.width;
      seen.height = found.height;
    } else if (found.width != seen.width || found.height != seen.height) {
      throw InputError(fmt::format(
          "{}: '{}' has {} x {} pixels and '{}' {} x {}; the images of one camera have one size: "
          "take out those of another camera, and export all in full size",
          folder.folder, pair.image, found.width, found.height, pairs.front().image, seen.width,
          seen.height));
    }
    if (std::ssize(found.corners) < kFewestCorners)
      empty.push_back(pair.image);
    else
      seen.images.push_back({pair, std::move(found.corners)});
  }
  if (seen.images.empty())
    throw InputError(fmt::format(
        "{}: none of {} shows the board '{}'; {}", folder.folder, counted(pairs.size(), "image"),
        folder.pattern.text,
        !hint.empty()
            ? hint
            : "count its columns and rows again (--board), look whether the board is whole "
              "and sharp in the images, with a bright border around it"));
  if (!empty.empty())
    warnings.push_back(
        fmt::format("{}: left out: {} of {} images, in which the board '{}' is not found ({})",
                    folder.folder, empty.size(), pairs.size(), folder.pattern.text, told(empty)));
  return seen;
}

// Numbers the visits of each pose, if there are several of one.
void number_repeats(Campaign& stops) {
  if (!stops.repeat.empty()) return;
  std::vector<int> visits(stops.pose_ids.size());
  for (int pose : stops.pose) stops.repeat.push_back(++visits[pose]);
  if (std::ranges::max(visits) == 1) stops.repeat.clear();
}

Campaign corners_of(const Campaign& stops, const SeenImages& seen, const ImageFolder& folder) {
  std::vector<int> rows;
  for (const SeenImage& image : seen.images)
    rows.insert(rows.end(), image.corners.size(), image.of.row);
  Campaign campaign = stops.select(rows);
  campaign.position.clear();
  campaign.metre_per_pixel = 1;
  for (const ArtefactPoint& point : points_of(folder.pattern))
    campaign.contact_names.push_back(PixelName(folder.camera, "", point.name).text());
  for (const SeenImage& image : seen.images)
    for (const SeenCorner& corner : image.corners) {
      campaign.position.emplace_back(corner.u, corner.v, 0);
      campaign.distance.push_back(0);
      campaign.touch.push_back({corner.point, -1, true});
    }
  return campaign;
}

std::string summary(const ImageFolder& folder, const SeenImages& seen, size_t images) {
  size_t corners = 0;
  for (const SeenImage& image : seen.images) corners += image.corners.size();
  return fmt::format(
      "{}: the board in {} of {}, {}\n"
      "  for the robot file, with the focal length in px, and arm or cell as it is:\n"
      "  cameras: {{{}: {{on: arm, fx_px: , fy_px: , cx_px: {:g}, cy_px: {:g}, width_px: {}, "
      "height_px: {}}}}}\n"
      "  boards: {{board: {{on: cell, pattern: \"{}\"}}}}\n",
      folder.folder, seen.images.size(), counted(images, "image"), counted(corners, "corner"),
      folder.camera.empty() ? "camera" : folder.camera, (seen.width - 1) / 2.0,
      (seen.height - 1) / 2.0, seen.width, seen.height, folder.pattern.text);
}

}  // namespace

ImportedReadings import_images(const ImageFolder& folder, const std::string& joints,
                               const ImportOptions& options, const FindCorners& find_corners) {
  std::vector<std::string> images = image_names(folder.folder);
  const JointStops stops = read_joint_stops(joints, options);
  ImportedReadings result = stops.readings;
  Campaign& campaign = result.campaign;
  const std::vector<Pair> pairs =
      ImageJoin(folder.folder, std::move(images), stops, result.warnings).pairs();
  if (!stops.has_poses)
    for (const Pair& pair : pairs) campaign.pose_ids[campaign.pose[pair.row]] = stem(pair.image);
  number_repeats(campaign);
  const SeenImages seen = look(folder, pairs, find_corners, result.warnings);
  campaign = corners_of(campaign, seen, folder);
  result.mapping += summary(folder, seen, pairs.size());
  if (is_symmetric(folder.pattern))
    result.warnings.push_back(fmt::format(
        "the board '{}' looks the same turned by {}: corners are counted from its end to the left "
        "of each image, which is wrong where the camera has turned by more than {} about its line "
        "of sight between images; the next time use a board with an odd and an even number of "
        "corners, or with markers",
        folder.pattern.text, folder.pattern.columns == folder.pattern.rows ? "a quarter" : "a half",
        folder.pattern.columns == folder.pattern.rows ? "45 deg" : "90 deg"));
  return result;
}

}  // namespace armtrue
