#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include "armtrue/compensation/target_doubts.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr double kSamePlace = 1e-3;  // m
constexpr double kSameTurn = 0.1 * kDegree;
constexpr double kElsewhere = 5e-3;  // m: hints that are no more than hints

bool is_same_place(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() < kSamePlace;
}

double turn_between(const Pose& a, const Pose& b) {
  return rotation_log(a.rotation.transpose() * b.rotation).norm();
}

std::string numbers_of(const Pose& pose) {
  const Eigen::Vector3d mm = pose.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(pose.rotation) / kDegree;
  std::string text;
  for (const double number : {mm[0], mm[1], mm[2], abc[0], abc[1], abc[2]}) {
    constexpr double kDigits = 1000;  // mm and deg, as people enter them
    const double rounded = std::round(number * kDigits) / kDigits;
    text += fmt::format("{}{:.10g}", text.empty() ? "" : ",", rounded == 0 ? 0.0 : rounded);
  }
  return text;
}

// Targets beside their hints, all in R_0.
class HintedTargets {
 public:
  HintedTargets(const Program& program, const Robot& controller, const CompensationOptions& options)
      : program_(program), options_(options) {
    KinematicChain chain = controller.chain;
    chain.base = chain.tool = {};
    const ChainEvaluator evaluator(chain);
    for (const JointVector& q : program.visits.q) {
      last_.push_back(evaluator.pose(q));
      hinted_.push_back(last_.back() * options.tool);
    }
  }

  // Median distance of a target from its hint [m].
  double apart() const {
    std::vector<double> apart;
    for (size_t row = 0; row < rows(); ++row)
      apart.push_back((target(row).translation - hinted_[row].translation).norm());
    const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(rows() / 2);
    std::ranges::nth_element(apart, middle);
    return *middle;
  }

  // The largest distance of a place from its hint [m], with factors on its coordinates.
  double farthest(const Eigen::Vector3d& factors) const {
    double most = 0;
    for (size_t row = 0; row < rows(); ++row) {
      const Pose changed{program_.poses[row].rotation,
                         factors.cwiseProduct(program_.poses[row].translation)};
      most =
          std::max(most, ((options_.base * changed).translation - hinted_[row].translation).norm());
    }
    return most;
  }

  // Where places agree, and most orientations do not.
  std::string turned_otherwise() const {
    size_t turned = 0;
    for (size_t row = 0; row < rows(); ++row)
      turned += turn_between(target(row), hinted_[row]) > 10 * kSameTurn;
    if (2 * turned < rows()) return "";
    return fmt::format(
        "the joint angles of {} of {} targets reach their places, but not with their a_deg, b_deg, "
        "c_deg: R = Rz(a) Ry(b) Rx(c) in deg; check their order, sign and unit, and --tool",
        turned, rows());
  }

  // What would bring the targets to their hints; empty if nothing does.
  std::string remedy() const {
    if (const auto base =
            common([&](size_t row) { return hinted_[row] * inverse(program_.poses[row]); }))
      return "at each of them with --base=" + numbers_of(*base) + ": is the base that one?";
    if (const auto tool = common([&](size_t row) { return inverse(last_[row]) * target(row); }))
      return "at each of them with --tool=" + numbers_of(inverse(options_.flange) * *tool) +
             ": is the tool that one?";
    if (std::string words = remedy_of_coordinates(); !words.empty()) return words;
    for (const size_t late : {size_t{1}, rows() - 1})
      if (agrees_with_row(late))
        return fmt::format("at those of the row {}: move the columns by one row",
                           late == 1 ? "behind" : "before");
    return "";
  }

 private:
  size_t rows() const { return program_.rows(); }
  Pose target(size_t row) const { return options_.base * program_.poses[row]; }

  // The displacement that is the same in all rows; nothing if it differs.
  std::optional<Pose> common(const std::function<Pose(size_t)>& of_row) const {
    const Pose first = of_row(0);
    for (size_t row = 1; row < rows(); ++row) {
      const Pose other = of_row(row);
      if (!is_same_place(first, other) || turn_between(first, other) >= kSameTurn)
        return std::nullopt;
    }
    return first;
  }

  std::string remedy_of_coordinates() const {
    struct Factors {
      Eigen::Vector3d factors;
      const char* words;
    };
    for (const Factors& other : {Factors{{-1, 1, 1}, "x_mm with the other sign"},
                                 Factors{{1, -1, 1}, "y_mm with the other sign"},
                                 Factors{{1, 1, -1}, "z_mm with the other sign"},
                                 Factors{{1000, 1000, 1000}, "x_mm, y_mm, z_mm in m"},
                                 Factors{{25.4, 25.4, 25.4}, "x_mm, y_mm, z_mm in inches"}})
      if (const double left = farthest(other.factors); left < kElsewhere)
        return fmt::format("within {:.2g} mm at each of them if the file gives {}: correct it",
                           left / kMillimetre, other.words);
    return "";
  }

  // One row has no such neighbour.
  bool agrees_with_row(size_t late) const {
    const auto agree = std::ranges::count_if(std::views::iota(size_t{0}, rows()), [&](size_t row) {
      return is_same_place(target(row), hinted_[(row + late) % rows()]);
    });
    return agree + 1 >= static_cast<std::ptrdiff_t>(rows());
  }

  const Program& program_;
  const CompensationOptions& options_;
  std::vector<Pose> last_, hinted_;  // of each row: R_7, and the TCP
};

}  // namespace

std::string contradiction_of_hints(const Program& program, const Robot& controller,
                                   const CompensationOptions& options) {
  constexpr int kFewestRows = 4;
  if (!program.is_cartesian() || program.rows() < kFewestRows || !program.set_up.empty() ||
      options.tool_is_measured || !std::ranges::all_of(program.hinted, std::identity()))
    return "";
  const HintedTargets targets(program, controller, options);
  if (targets.farthest({1, 1, 1}) < kSamePlace) return targets.turned_otherwise();
  const double apart = targets.apart();
  if (apart < kElsewhere) return "";
  const std::string remedy = targets.remedy();
  if (remedy.empty()) return "";
  return fmt::format(
      "the joint angles of the targets stand {:.4g} mm from their poses (median), and {}",
      apart / kMillimetre, remedy);
}

}  // namespace armtrue
