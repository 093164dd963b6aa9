#include "armtrue/certification/stray_visits.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "certification/lone_distances.h"

namespace armtrue {
namespace {

constexpr double kNoReturn = 2e-3;  // [m]: no arm returns worse
constexpr double kNoArm = 20e-3;    // [m]: no arm errs as far

Eigen::Vector3d error_of(const Evaluation& evaluation, int row) {
  return evaluation.residuals[row].head<3>();
}

// Pose, session and reflector: one point to which the robot returns.
struct VisitedPlace {
  std::vector<int> rows;
  std::vector<double> off;  // of each row from the middle one; of two, from each other
  int middle = 0;           // the row nearest to all others
  bool is_stray = false;    // as a whole
};

class StraySearch {
 public:
  StraySearch(const Campaign& campaign, const Evaluation& evaluation)
      : campaign_(campaign), evaluation_(evaluation) {
    std::map<std::array<int, 3>, VisitedPlace> places;
    for (int row = 0; row < campaign.rows(); ++row)
      places[{campaign.pose[row], campaign.target.empty() ? 0 : campaign.target[row],
              campaign.session.empty() ? 0 : campaign.session[row]}]
          .rows.push_back(row);
    for (auto& [key, place] : places) {
      find_middle(place);
      places_.push_back(std::move(place));
    }
  }

  // Single visits, by the others of their pose.
  void find_single() {
    constexpr size_t kEnough = 10;  // visits; the middle one of fewer lies beside the place
    std::vector<double> distances, of_many;
    for (const VisitedPlace& place : places_) {
      if (place.rows.size() >= kEnough)
        of_many.insert(of_many.end(), place.off.begin(), place.off.end());
      if (place.rows.size() == 2) distances.push_back(place.off.front());
      if (place.rows.size() > 2)
        distances.insert(distances.end(), place.off.begin(), place.off.end());
    }
    const double least = least_that_stands_out(distances, kNoReturn);
    const double least_of_many = std::min(least, least_lone_distance(of_many));
    const Eigen::Vector3d common = common_error();
    for (VisitedPlace& place : places_) {
      if (place.rows.size() == 2 && place.off.front() >= least) {
        // One of two: the one that the commanded pose is farther from.
        const auto error = [&](int row) { return (residual(row) - common).norm(); };
        if (error(place.rows[0]) > error(place.rows[1])) std::swap(place.rows[0], place.rows[1]);
        place.middle = place.rows[0];
        place.off[0] = 0;
      }
      for (size_t k = 0; k < place.rows.size(); ++k)
        if (place.off[k] >= (place.rows.size() >= kEnough ? least_of_many : least))
          strays_.push_back({place.rows[k], false, place.off[k], {}, 0});
    }
  }

  // All visits of a pose, by the errors of the other poses.
  void find_whole() {
    const Eigen::Vector3d common = common_error();
    std::vector<double> distances;
    constexpr size_t kFewestPlaces = 5;  // of three, the common error is one of them
    if (places_.size() < kFewestPlaces) return;
    for (const VisitedPlace& place : places_)
      distances.push_back((residual(place.middle) - common).norm());
    const double least = least_that_stands_out(distances, kNoArm);
    for (size_t k = 0; k < places_.size(); ++k) {
      if (distances[k] < least) continue;
      places_[k].is_stray = true;
      for (const int row : places_[k].rows)
        if (!is_stray(row)) strays_.push_back({row, true, distances[k], {}, 0});
    }
  }

  std::vector<StrayVisit> strays() {
    const Eigen::Vector3d common = common_error();
    for (StrayVisit& stray : strays_) {
      double nearest = std::min(kNoArm, stray.off / 2);
      for (const VisitedPlace& place : places_) {
        if (campaign_.pose[place.middle] == campaign_.pose[stray.row]) continue;
        const Eigen::Vector3d commanded = campaign_.position[place.middle] - residual(place.middle);
        const Eigen::Vector3d stands =
            commanded + (place.is_stray ? common : residual(place.middle));
        const double beside = (campaign_.position[stray.row] - stands).norm();
        if (beside >= nearest) continue;
        nearest = stray.beside = beside;
        stray.fits = place.middle;
      }
    }
    std::ranges::sort(strays_, {}, &StrayVisit::row);
    return strays_;
  }

 private:
  Eigen::Vector3d residual(int row) const { return error_of(evaluation_, row); }

  bool is_stray(int row) const {
    return std::ranges::find(strays_, row, &StrayVisit::row) != strays_.end();
  }

  void find_middle(VisitedPlace& place) const {
    double least = std::numeric_limits<double>::infinity();
    for (const int row : place.rows) {
      std::vector<double> off;
      for (const int other : place.rows) off.push_back((residual(other) - residual(row)).norm());
      const double all = sum(off);
      if (all >= least) continue;
      least = all;
      place.middle = row;
      place.off = std::move(off);
    }
    if (place.rows.size() == 2)
      place.off.assign(2, (residual(place.rows[1]) - residual(place.rows[0])).norm());
  }

  static double sum(const std::vector<double>& values) {
    double all = 0;
    for (const double value : values) all += value;
    return all;
  }

  // The error that the poses have in common, of which few strays take nothing.
  Eigen::Vector3d common_error() const {
    Eigen::Vector3d common;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> errors;
      for (const VisitedPlace& place : places_) errors.push_back(residual(place.middle)[axis]);
      common[axis] = median(std::move(errors));
    }
    return common;
  }

  // The smallest of the distances that are strays; infinite if there are none.
  static double least_that_stands_out(std::vector<double> distances, double no_arm) {
    constexpr double kTail = 2, kRareGap = 1e-4;
    std::ranges::sort(distances, std::greater<>{});
    const auto most = std::max<std::ptrdiff_t>(0, (std::ssize(distances) - 1) / 2);
    double least_log = std::log(kRareGap / static_cast<double>(std::max<std::ptrdiff_t>(1, most)));
    double least = std::numeric_limits<double>::infinity();
    for (std::ptrdiff_t k = 1; k <= most && distances[k - 1] > no_arm; ++k) {
      const double log = kTail * static_cast<double>(k) * std::log(distances[k] / distances[k - 1]);
      if (log >= least_log) continue;
      least_log = log;
      least = distances[k - 1];
    }
    return least;
  }

  const Campaign& campaign_;
  const Evaluation& evaluation_;
  std::vector<VisitedPlace> places_;
  std::vector<StrayVisit> strays_;
};

}  // namespace

std::vector<StrayVisit> find_stray_visits(const Campaign& campaign, const Evaluation& evaluation) {
  StraySearch visits(campaign, evaluation);
  visits.find_single();
  visits.find_whole();
  return visits.strays();
}

std::string strays_in_words(const Campaign& campaign, const std::vector<StrayVisit>& strays) {
  constexpr size_t kNamed = 6;
  if (strays.empty()) return "";
  const auto pose_of = [&](int row) { return campaign.pose_ids[campaign.pose[row]]; };
  std::string text;
  for (size_t k = 0; k < std::min(kNamed, strays.size()); ++k) {
    const StrayVisit& stray = strays[k];
    text += fmt::format("{} line {} stands {:.4g} mm from {} pose {}", k == 0 ? ":" : ";",
                        campaign.line[stray.row], stray.off / kMillimetre,
                        stray.with_all ? "the commanded place of" : "the other visits of",
                        pose_of(stray.row));
    if (stray.fits)
      text += fmt::format(", and {:.2g} mm from pose {}", stray.beside / kMillimetre,
                          pose_of(*stray.fits));
  }
  if (std::ranges::all_of(strays, [](const StrayVisit& stray) { return stray.off < kNoReturn; }))
    return fmt::format(
        "{} of {} visits stand farther aside than the scatter of the others explains{}{}. AP, RP "
        "and U contain them; measure these visits again or leave their rows out",
        strays.size(), campaign.rows(), text, strays.size() > kNamed ? "; ..." : "");
  return fmt::format(
      "{} of {} visits are not of their pose{}{}. AP, RP and U contain them; correct the column "
      "pose where another pose fits, else measure these visits again or leave their rows out",
      strays.size(), campaign.rows(), text, strays.size() > kNamed ? "; ..." : "");
}

std::string no_arm_in_words(const Campaign& campaign, const Evaluation& evaluation) {
  int farthest = 0;
  for (int row = 0; row < campaign.rows(); ++row)
    if (error_of(evaluation, row).norm() > error_of(evaluation, farthest).norm()) farthest = row;
  const double off = error_of(evaluation, farthest).norm();
  // A nominal arm in a set-up that is known roughly may err by more than kNoArm.
  if (off <= 5 * kNoArm) return "";
  return fmt::format(
      "line {} stands {:.4g} mm from the commanded place of pose {}, farther than any arm errs: "
      "the names of poses may be exchanged, or base and tool of the robot file are not those of "
      "this set-up; correct the column pose, or give --refit base,tool if that is missing",
      campaign.line[farthest], off / kMillimetre, campaign.pose_ids[campaign.pose[farthest]]);
}

Campaign without_strays(const Campaign& campaign, const std::vector<StrayVisit>& strays) {
  std::vector<int> rows;
  for (const StrayVisit& stray : strays) rows.push_back(stray.row);
  return rows.empty() ? campaign : without_rows(campaign, rows);
}

Robot refit_to_sound(const Robot& robot, const Campaign& campaign,
                     const std::vector<std::string>& what) {
  StraySearch visits(campaign, evaluate(robot, campaign));
  visits.find_single();  // does not need to know the set-up
  const Campaign sound = without_strays(campaign, visits.strays());
  Robot fitted = robot;
  fitted.identify = what;
  fitted.identify_per_session.clear();
  fitted.effects.clear();
  return refit_set_up(robot, without_gross(sound, find_gross_poses(fitted, sound)), what);
}

}  // namespace armtrue
