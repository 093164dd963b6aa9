#include "armtrue/calibration/camera_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr int kFolds = 5;

// Where a parameter stands among the unknowns, or nothing.
std::optional<Eigen::Index> unknown_of(const CalibrationResult& result, int parameter) {
  const auto found = std::ranges::find(result.set.kept, parameter);
  if (found == result.set.kept.end()) return std::nullopt;
  return found - result.set.kept.begin();
}

bool has_images(const Campaign& campaign, const Contact& contact) {
  return std::ranges::any_of(campaign.touch, [&](const Touch& touch) {
    if (!touch.is_pixel) return false;
    const PixelName name(campaign.contact_names[touch.contact]);
    const std::string& own = contact.kind == ContactKind::camera ? name.camera : name.board;
    return own.empty() || own == contact.name;
  });
}

// 95 % bounds of the place, along and about its axes: the largest of three each. Those beside an
// arm that is held count its errors as independent from image to image, which they are not.
std::string place_in_words(const CalibrationResult& result, int contact, int poses,
                           bool arm_is_held) {
  const KinematicChain& chain = result.robot.chain;
  const Contact& thing = chain.contacts[contact];
  const int first = first_contact_parameter(chain) + kParametersOfContact * contact;
  double bounds[2] = {0, 0};
  for (int k = 0; k < 6; ++k)
    if (const auto unknown = unknown_of(result, first + k))
      bounds[k / 3] = std::max(bounds[k / 3], std::sqrt(result.covariance(*unknown, *unknown)));
    else
      return "";
  const double wide = student_t_975(std::max(1, poses - 1));
  const Eigen::Vector3d place = thing.place.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(thing.place.rotation) / kDegree;
  return fmt::format(
      "{} '{}' in {}: {:.3f}, {:.3f}, {:.3f} mm, each within {:.2g} mm; a, b, c {:.4f}, {:.4f}, "
      "{:.4f} deg, about each of its axes within {:.2g} deg (95 %{})",
      thing.kind == ContactKind::camera ? "camera" : "board", thing.name,
      thing.on_arm ? "the measured frame" : "R_A", place.x(), place.y(), place.z(),
      wide * bounds[0] / kMillimetre, abc.x(), abc.y(), abc.z(), wide * bounds[1] / kDegree,
      arm_is_held ? " if the arm has no error" : "");
}

std::string both_units(double rms, const Campaign& campaign) {
  return fmt::format("{:.3g} px, {:.3g} mm at the board", rms / campaign.metre_per_pixel,
                     rms / kMillimetre);
}

// Empty if some fold leaves too little.
std::vector<double> held_out_errors(const Robot& nominal, const IdentifiableSet& set,
                                    const Campaign& campaign) {
  std::vector<double> all;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<int> used, held_out;
    for (int row = 0; row < campaign.rows(); ++row)
      (campaign.pose[row] % kFolds == fold ? held_out : used).push_back(row);
    if (used.empty() || held_out.empty()) return {};
    try {
      const CalibrationResult fit = calibrate(nominal, campaign.select(used), set);
      const Campaign others = campaign.select(held_out);
      const std::vector<double> errors = image_errors(evaluate(fit.robot, others), others);
      all.insert(all.end(), errors.begin(), errors.end());
    } catch (const std::invalid_argument&) {  // a camera or a board has too few images left
      return {};
    }
  }
  return all;
}

// The same with the parameters of the arm identified, too; empty also if these readings are too few
// for them.
std::vector<double> held_out_errors_with_arm(Robot nominal, const Campaign& campaign) {
  nominal.identify.insert(nominal.identify.begin(), "auto");
  try {
    return held_out_errors(nominal, calibrate(nominal, campaign).set, campaign);
  } catch (const std::invalid_argument&) {
    return {};
  }
}

bool identifies_links(const CalibrationResult& result) {
  const ParameterLayout layout = layout_of(result.robot.chain);
  return std::ranges::any_of(result.set.kept, [&](int parameter) {
    return layout.is_of_links(parameter) || layout.is_of_couplings(parameter);
  });
}

}  // namespace

std::vector<std::string> cameras_in_words(const Robot& nominal, const CalibrationResult& result,
                                          const Campaign& campaign, const Evaluation& evaluation) {
  std::vector<std::string> words;
  if (!campaign.has_pixels()) return words;
  constexpr double kClearly = 0.9;  // RMS: an arm without error gets none smaller than by chance
  const int poses = campaign.poses();
  const bool arm_is_held = !identifies_links(result);
  const std::vector<Contact>& contacts = result.robot.chain.contacts;
  for (int c = 0; c < std::ssize(contacts); ++c)
    if (is_of_images(contacts[c].kind) && has_images(campaign, contacts[c]))
      if (std::string place = place_in_words(result, c, poses, arm_is_held); !place.empty())
        words.push_back(std::move(place));
  std::string reprojection =
      "reprojection, RMS: " +
      both_units(summarize(image_errors(evaluation, campaign)).rms, campaign);
  words.push_back(reprojection);
  if (!arm_is_held) return words;
  const std::vector<double> errors = held_out_errors(nominal, result.set, campaign);
  if (errors.empty()) return words;
  const double held = summarize(errors).rms;
  words.back() += "; of images that the fit has not used, a fifth of the poses at a time: " +
                  both_units(held, campaign);
  if (const std::vector<double> with_arm = held_out_errors_with_arm(nominal, campaign);
      !with_arm.empty() && summarize(with_arm).rms < kClearly * held)
    words.push_back(
        "the arm has errors, and the places above may be off by more than their bounds: with "
        "'auto' in identify, images that the fit has not used are left with " +
        both_units(summarize(with_arm).rms, campaign));
  return words;
}

}  // namespace armtrue
