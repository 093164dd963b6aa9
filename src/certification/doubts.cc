#include "armtrue/certification/doubts.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "armtrue/certification/stray_visits.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "certification/visit_step.h"

namespace armtrue {
namespace {

constexpr double kNoChance = 1e-4;

// The rows of each place to which the robot returns: pose, session and reflector. Of many visits
// the first, because each is compared with each.
std::vector<std::vector<int>> rows_of_places(const Campaign& campaign) {
  constexpr size_t kMostVisits = 2 * kStandardCycles;
  std::map<std::array<int, 3>, std::vector<int>> rows;
  for (int row = 0; row < campaign.rows(); ++row)
    rows[{campaign.pose[row], campaign.target.empty() ? 0 : campaign.target[row],
          campaign.session.empty() ? 0 : campaign.session[row]}]
        .push_back(row);
  std::vector<std::vector<int>> places;
  for (auto& [place, list] : rows) {
    if (list.size() < 2) continue;
    if (list.size() > kMostVisits) list.resize(kMostVisits);
    places.push_back(std::move(list));
  }
  return places;
}

// The step of the coordinates [m]: all differ by multiples of it.
double step_of(const Campaign& campaign) {
  constexpr double kFinest = 1e-9;  // m: finer digits are those of a computation
  std::int64_t step = 0;
  for (const Eigen::Vector3d& point : campaign.position)
    for (const double difference : point - campaign.position.front())
      step = std::gcd(step, std::llround(difference / kFinest));
  return kFinest * static_cast<double>(std::max<std::int64_t>(step, 1));
}

// How often two visits of a pose read the same by chance, from the differences of those that do
// not: along each principal axis of these a quarter of them is shorter than q, and a step then
// holds less than step / (4 q). The quarter stays within one of several places, such as those of a
// backlash.
double chance_of_the_same(const Eigen::Matrix3Xd& differences, double step) {
  if (differences.cols() == 0) return 1;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(differences * differences.transpose());
  const Eigen::Matrix3Xd along_axes = axes.eigenvectors().transpose() * differences;
  double chance = 1;
  for (const auto& along : along_axes.rowwise()) {
    std::vector<double> lengths(differences.cols());
    std::ranges::transform(along, lengths.begin(), [](double part) { return std::abs(part); });
    const auto quarter = lengths.begin() + std::ssize(lengths) / 4;
    std::ranges::nth_element(lengths, quarter);
    chance *= std::min(1.0, step / (4 * std::max(*quarter, 1e-300)));
  }
  return chance;
}

std::optional<std::string> find_copies(const Campaign& campaign,
                                       const std::vector<std::vector<int>>& places) {
  int visits = 0, copies = 0, all_alike = 0, line = 0, of_line = 0;
  int pairs = 0, same_pairs = 0;
  std::vector<Eigen::Vector3d> differences;  // of the pairs that are not the same
  for (const std::vector<int>& rows : places) {
    int own = 0;
    for (size_t b = 1; b < rows.size(); ++b) {
      int same = -1;
      for (size_t a = 0; a < b; ++a) {
        const Eigen::Vector3d apart = campaign.position[rows[b]] - campaign.position[rows[a]];
        ++pairs;
        if (!apart.isZero(0)) {
          differences.push_back(apart);
          continue;
        }
        ++same_pairs;
        if (same < 0) same = rows[a];
      }
      if (same < 0) continue;
      ++own;
      if (of_line > 0) continue;
      line = campaign.line[rows[b]];
      of_line = campaign.line[same];
    }
    visits += static_cast<int>(rows.size()) - 1;  // the first is a copy of none
    copies += own;
    all_alike += own + 1 == std::ssize(rows);
  }
  if (copies == 0) return std::nullopt;
  const Eigen::Map<const Eigen::Matrix3Xd> apart(
      differences.empty() ? nullptr : differences.front().data(), 3, std::ssize(differences));
  const double chance = chance_of_the_same(apart, step_of(campaign));
  const bool are_most = 2 * all_alike > std::ssize(places);
  if (!are_most && binomial_at_least(same_pairs, pairs, chance) >= kNoChance) return std::nullopt;
  return fmt::format(
      "{} of {} visits read the same as an earlier visit of their pose in all digits, and {} of {} "
      "poses have an RP of 0 so (line {} as line {}): readings that were copied, or digits too few "
      "to show the arm; give each visit its own reading, with all digits of the instrument",
      copies, visits, all_alike, places.size(), line, of_line);
}

// The largest power of ten of which the three coordinates are multiples [m].
double digits_of(const Eigen::Vector3d& point) {
  constexpr double kFinest = 1e-9, kCoarsest = 1e-3;
  const auto has = [&](double step) {
    const Eigen::Array3d steps = point.array() / step;
    return ((steps - steps.round()).abs() * step < kFinest / 10).all();
  };
  double step = kFinest;
  while (step < kCoarsest && has(10 * step)) step *= 10;
  return step;
}

// Visits that are earlier ones with fewer digits: the scatter of such a pose is that of rounding.
std::optional<std::string> find_rounded_copies(const Campaign& campaign,
                                               const std::vector<std::vector<int>>& places) {
  int visits = 0, copies = 0, pairs = 0, same_pairs = 0, line = 0, of_line = 0;
  double coarsest = 0;
  std::vector<Eigen::Vector3d> differences;  // of the pairs that are not the same
  for (const std::vector<int>& rows : places) {
    std::vector<double> digits;
    for (const int row : rows) digits.push_back(digits_of(campaign.position[row]));
    visits += static_cast<int>(rows.size()) - 1;
    for (size_t b = 1; b < rows.size(); ++b) {
      bool is_copy = false;
      for (size_t a = 0; a < b; ++a) {
        const Eigen::Vector3d apart = campaign.position[rows[b]] - campaign.position[rows[a]];
        const double step = std::max(digits[a], digits[b]);
        // A hundred: of right readings one in 1000 ends with three zeros.
        constexpr double kBeyondRounding = 1.001, kFewerDigits = 99;
        ++pairs;
        if (step < kFewerDigits * std::min(digits[a], digits[b]) ||
            apart.cwiseAbs().maxCoeff() > kBeyondRounding * step) {
          differences.push_back(apart);
          continue;
        }
        ++same_pairs;
        coarsest = std::max(coarsest, step);
        is_copy = true;
        if (of_line == 0) {
          line = campaign.line[rows[b]];
          of_line = campaign.line[rows[a]];
        }
      }
      copies += is_copy;
    }
  }
  if (copies == 0) return std::nullopt;
  const Eigen::Map<const Eigen::Matrix3Xd> apart(
      differences.empty() ? nullptr : differences.front().data(), 3, std::ssize(differences));
  // To one side or the other of a digit that was cut off.
  const double chance = chance_of_the_same(apart, 2 * coarsest);
  const bool are_most = 2 * copies > visits;
  if (!are_most && binomial_at_least(same_pairs, pairs, chance) >= kNoChance) return std::nullopt;
  return fmt::format(
      "{} of {} visits are an earlier visit of their pose with other digits (line {} as line {}): "
      "readings that were copied and rounded, whose RP is that of the rounding; give each visit "
      "its own reading, with all digits of the instrument",
      copies, visits, line, of_line);
}

constexpr double kMuchLess = 1.0 / 3;  // of a stated noise: no reading is as good

// Visits that lie closer to an earlier one of their pose than two readings with the noise of the
// instrument do, as copies do to which small numbers were added. Where the arm scatters, too, or
// comes from two sides, readings lie farther apart.
std::optional<std::string> find_near_copies(const Campaign& campaign,
                                            const std::vector<std::vector<int>>& places,
                                            double noise) {
  constexpr int kAxes = 3;
  struct Close {
    double apart;
    int row, of;
  };
  std::vector<Close> closest;  // of each visit but the first of its pose
  int pairs = 0;
  for (const std::vector<int>& rows : places)
    for (size_t b = 1; b < rows.size(); ++b) {
      Close close{std::numeric_limits<double>::infinity(), rows[b], 0};
      for (size_t a = 0; a < b; ++a, ++pairs) {
        const double apart = (campaign.position[rows[b]] - campaign.position[rows[a]]).norm();
        if (apart < close.apart) close = {apart, rows[b], rows[a]};
      }
      closest.push_back(close);
    }
  std::ranges::sort(closest, {}, &Close::apart);
  const double variance = 2 * std::pow(kMuchLess * noise, 2);
  const double rounded = std::sqrt(1.0 * kAxes) * step_of(campaign);
  const auto tried = static_cast<double>(closest.size());
  int copies = 0;
  double least_chance = kNoChance / tried;
  for (int k = 1; k <= std::ssize(closest); ++k) {
    const double apart = closest[k - 1].apart + rounded;
    const double as_close = 1 - chi_squared_above(apart * apart / variance, kAxes);
    const double chance = binomial_at_least(k, pairs, as_close);
    if (chance >= least_chance) continue;
    least_chance = chance;
    copies = k;
  }
  if (copies == 0) return std::nullopt;
  const auto named =
      std::ranges::min_element(closest.begin(), closest.begin() + copies, {}, &Close::row);
  return fmt::format(
      "{} of {} visits lie within {:.2g} mm of an earlier visit of their pose (line {} of line "
      "{}), closer than readings with a third of the stated noise_mm, {:.4g}, do: were they copied "
      "with small changes, or averaged? Give each visit its own reading, or correct noise_mm",
      copies, closest.size(), closest[copies - 1].apart / kMillimetre, campaign.line[named->row],
      campaign.line[named->of], noise / kMillimetre);
}

// The difference of two visits of a pose, in the axes of the tool.
struct Pair {
  int a, b;  // rows
  Eigen::Vector3d apart;
};

std::vector<Pair> pairs_of(const Robot& robot, const Campaign& campaign,
                           const Evaluation& evaluation,
                           const std::vector<std::vector<int>>& places) {
  Robot geometry = robot;  // turns the tool well enough, and needs no measured driver
  geometry.effects.clear();
  const RobotModel model(geometry);
  std::vector<Pair> pairs;
  for (const std::vector<int>& rows : places) {
    const Eigen::Matrix3d turned = model.pose(campaign.context(rows.front())).rotation.transpose();
    for (size_t b = 1; b < rows.size(); ++b)
      for (size_t a = 0; a < b; ++a) {
        const auto residual = [&](int row) -> Eigen::Vector3d {
          return evaluation.residuals[row].head<3>();
        };
        pairs.push_back({rows[a], rows[b], turned * (residual(rows[b]) - residual(rows[a]))});
      }
  }
  std::ranges::sort(pairs, {}, [](const Pair& pair) { return pair.apart.norm(); });
  return pairs;
}

// Whether the direction of arrival of one joint differs in the long pairs and agrees in the short
// ones: then the arm stands at two places, by its backlash.
bool is_of_a_direction(const Campaign& campaign, const std::vector<Pair>& pairs,
                       size_t first_long) {
  constexpr double kNearlyAll = 0.95;
  if (campaign.arrival.empty()) return false;
  for (size_t joint = 0; joint < campaign.arrival.front().size(); ++joint) {
    int explained = 0, known = 0;
    for (size_t k = 0; k < pairs.size(); ++k) {
      const int a = campaign.arrival[pairs[k].a][joint], b = campaign.arrival[pairs[k].b][joint];
      if (a == 0 || b == 0) continue;
      ++known;
      explained += (a != b) == (k >= first_long);
    }
    if (known > 0 && explained >= kNearlyAll * known) return true;
  }
  return false;
}

std::optional<std::string> find_nests(const Robot& robot, const Campaign& campaign,
                                      const Evaluation& evaluation,
                                      const std::vector<std::vector<int>>& places) {
  constexpr size_t kFewestPairs = 12, kFewestPoses = 3;
  constexpr double kLeastGap = 3;  // lengths of normal differences have no such gap between them
  constexpr double kLeastShare = 0.15;  // of the pairs that are short, and that are long, at least
  constexpr double kOneLine = 0.95;     // of the squared lengths along one direction of the tool
  constexpr double kOneLength = 2;      // longest over shortest long one: D + D / 3 over D - D / 3
  if (places.size() < kFewestPoses) return std::nullopt;
  const std::vector<Pair> pairs = pairs_of(robot, campaign, evaluation, places);
  if (pairs.size() < kFewestPairs) return std::nullopt;
  const auto least =
      static_cast<size_t>(std::ceil(kLeastShare * static_cast<double>(pairs.size())));
  size_t first_long = 0;
  double gap = kLeastGap;
  for (size_t k = least; k + least <= pairs.size(); ++k) {
    const double shorter = pairs[k - 1].apart.norm(), longer = pairs[k].apart.norm();
    if (longer <= gap * shorter || shorter == 0) continue;
    gap = longer / shorter;
    first_long = k;
  }
  if (first_long == 0) return std::nullopt;
  // All long differences, but for one in twenty, are one vector, either way.
  const size_t longest = pairs.size() - 1 - (pairs.size() - first_long) / 20;
  if (pairs[longest].apart.norm() > kOneLength * pairs[first_long].apart.norm())
    return std::nullopt;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  std::map<int, int> poses;
  std::vector<double> lengths;
  for (size_t k = first_long; k < pairs.size(); ++k) {
    squares += pairs[k].apart * pairs[k].apart.transpose();
    ++poses[campaign.pose[pairs[k].a]];
    lengths.push_back(pairs[k].apart.norm());
  }
  // The largest eigenvalue, by powers: another is at most a twentieth of it if there is one line.
  Eigen::Vector3d along = pairs.back().apart.normalized();
  for (int k = 0; k < 20; ++k) along = (squares * along).normalized();
  if (along.dot(squares * along) < kOneLine * squares.trace()) return std::nullopt;
  if (poses.size() < kFewestPoses || is_of_a_direction(campaign, pairs, first_long))
    return std::nullopt;
  return fmt::format(
      "the visits of {} of {} poses stand at two places, {:.4g} mm apart along one direction of "
      "the tool, and within {:.2g} mm at each: did the reflector stand in two nests? RP and AP "
      "contain the way between them; give the nests two names in the column target, or measure "
      "with one",
      poses.size(), places.size(), median(lengths) / kMillimetre,
      pairs[first_long - 1].apart.norm() / kMillimetre);
}

std::optional<std::string> contradiction_of_noise(double noise, const Scatter& scatter) {
  constexpr double kMuchMore = 100;
  const double ratio = scatter.deviation / noise;
  const std::string seen = fmt::format(
      "the visits scatter by {:.3g} mm per axis, {:.3g} times the noise_mm that is stated for the "
      "instrument, {:.4g}",
      scatter.deviation / kMillimetre, ratio, noise / kMillimetre);
  if (ratio > kMuchMore)
    return seen + ": is it in another unit? Give one standard deviation per axis in mm";
  if (ratio < kMuchLess && scatter.deviation > 0 &&
      1 - chi_squared_above(scatter.freedom * ratio * ratio, scatter.freedom) < kNoChance)
    return seen +
           ": no reading is better than its noise; correct noise_mm, or look for readings "
           "that were copied or averaged";
  return std::nullopt;
}

std::vector<std::string> doubts_of_all(const Robot& robot, const Campaign& campaign,
                                       const Evaluation& evaluation,
                                       const std::optional<double>& noise) {
  std::vector<std::string> doubts;
  const std::vector<std::vector<int>> places = rows_of_places(campaign);
  if (places.empty()) return doubts;
  const auto add = [&](const std::optional<std::string>& doubt) {
    if (doubt) doubts.push_back(*doubt);
  };
  auto copies = find_copies(campaign, places);
  if (!copies) copies = find_rounded_copies(campaign, places);
  add(copies);
  add(find_nests(robot, campaign, evaluation, places));
  add(find_visit_step(robot, campaign, evaluation, places));
  if (!noise || copies) return doubts;
  const auto contradiction =
      contradiction_of_noise(*noise, scatter_of(figures_of(campaign, evaluation).poses));
  add(contradiction);
  if (!contradiction) add(find_near_copies(campaign, places, *noise));
  return doubts;
}

Evaluation without_strays(const Evaluation& evaluation, const std::vector<StrayVisit>& strays) {
  Evaluation rest;
  for (size_t row = 0; row < evaluation.residuals.size(); ++row)
    if (std::ranges::find(strays, static_cast<int>(row), &StrayVisit::row) == strays.end())
      rest.residuals.push_back(evaluation.residuals[row]);
  return rest;
}

}  // namespace

std::vector<std::string> doubts_of_visits(const Robot& robot, const Campaign& campaign,
                                          const Evaluation& evaluation,
                                          const std::optional<double>& noise) {
  const std::vector<std::vector<int>> places = rows_of_places(campaign);
  std::vector<StrayVisit> strays = find_stray_visits(campaign, evaluation);
  // After a knock, or in another nest, visits of many poses stand apart.
  constexpr size_t kOfOneCause = 3;
  std::set<int> poses;
  for (const StrayVisit& stray : strays)
    if (!stray.with_all) poses.insert(campaign.pose[stray.row]);
  if (poses.size() >= kOfOneCause && (find_nests(robot, campaign, evaluation, places) ||
                                      find_visit_step(robot, campaign, evaluation, places)))
    strays.clear();
  if (strays.empty()) {
    std::vector<std::string> doubts = doubts_of_all(robot, campaign, evaluation, noise);
    if (const std::string far = no_arm_in_words(campaign, evaluation); !far.empty())
      doubts.insert(doubts.begin(), far);
    return doubts;
  }
  std::vector<std::string> doubts = doubts_of_all(robot, armtrue::without_strays(campaign, strays),
                                                  without_strays(evaluation, strays), noise);
  doubts.insert(doubts.begin(), strays_in_words(campaign, strays));
  return doubts;
}

std::vector<std::string> doubts_of(const About& about) {
  std::vector<std::string> doubts;
  // `given` in the unit of the key; 0: not stated.
  const auto check = [&](const char* key, double given, double least, double most, const char* unit,
                         const char* example) {
    if (given == 0 || (given >= least && given <= most)) return;
    doubts.push_back(
        fmt::format("{} is {:.4g} {}, and {}: is it in another unit? Give it in {}, such as {}",
                    key, given, unit,
                    given < least ? fmt::format("hardly any is below {:g}", least)
                                  : fmt::format("hardly any is above {:g}", most),
                    unit, example));
  };
  constexpr double kMicro = 1e-6, kUsualRange = 3;  // m: of a tracker to an arm
  const StatedUncertainty& stated = about.stated;
  const double range = about.range.value_or(kUsualRange);
  // An interferometer errs by 0.5 um in each metre, cameras by some tenths of a millimetre.
  check("mpe_um at the range of the readings",
        (stated.mpe_constant + stated.mpe_per_metre * range) / kMicro, 1, 2000, "um",
        "{constant: 15, per_m: 6} of a laser tracker");
  if (doubts.empty()) {  // else that says it
    check("mpe_um: constant", stated.mpe_constant / kMicro, 0.1, 2000, "um", "15");
    check("mpe_um: per_m", stated.mpe_per_metre / kMicro, 0.1, 1000, "um", "6");
  }
  check("noise_mm", stated.noise.value_or(0) / kMillimetre, 1e-4, 2, "mm", "0.01");
  check("mounting_mm", stated.mounting / kMillimetre, 1e-4, 2, "mm", "0.01");
  check("temperature: within_k", stated.temperature_half_width, 0, 60, "K", "1");
  check("temperature: length_mm", stated.length / kMillimetre, 50, 20000, "mm", "2500");
  check("range_mm", about.range.value_or(0) / kMillimetre, 50, 200000, "mm", "4000");
  return doubts;
}

std::string doubt_of_type(const std::string& type, const std::string& robot) {
  const auto numbers_in = [](const std::string& text) {
    std::set<std::string> numbers;
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    for (size_t at = 0; at < text.size();) {
      size_t end = at;
      while (end < text.size() && is_digit(text[end])) ++end;
      if (end > at) numbers.insert(text.substr(at, end - at));
      at = std::max(end, at + 1);
    }
    return numbers;
  };
  const std::set<std::string> stated = numbers_in(type), own = numbers_in(robot);
  const bool is_shared =
      std::ranges::any_of(stated, [&](const std::string& number) { return own.contains(number); });
  if (stated.empty() || own.empty() || is_shared) return "";
  return fmt::format("robot: type is {}, and that of --robot {}: is it this arm?", type, robot);
}

}  // namespace armtrue
