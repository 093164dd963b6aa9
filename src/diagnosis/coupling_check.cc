#include "diagnosis/coupling_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// A joint that may move with another, and the column of its coefficient.
struct CoupledPair {
  int link, followed;  // 0-based
  Eigen::VectorXd column;
};

std::vector<CoupledPair> pairs_of(const KinematicChain& chain, const Campaign& readings,
                                  const FitEquations& equations) {
  std::vector<CoupledPair> pairs;
  const int joints = joint_count(chain);
  for (int other = 0; other < joints; ++other) {
    if (is_prismatic(joint_link(chain, other))) continue;
    Eigen::VectorXd q(readings.rows());
    for (int row = 0; row < readings.rows(); ++row) q[row] = readings.q[row][other];
    for (int joint = 0; joint < joints; ++joint)
      if (joint != other)
        pairs.push_back({link_of_joint(chain, joint), link_of_joint(chain, other),
                         times_of_rows(equations.columns.col(joint), q)});
  }
  return pairs;
}

// Of the squared residual, that of the positions or of the orientations, whichever is explained
// better: a joint whose axis meets the measured point turns it only.
double largest_share(const Eigen::MatrixXd& columns, const JointFit& fit,
                     const FitEquations& equations) {
  constexpr int kOfPose = 6, kOfPosition = 3;
  if (equations.row_size != kOfPose || columns.cols() == 0) return fit.share;
  Eigen::VectorXd explained = columns * fit.value;
  explained -= equations.basis * (equations.basis.transpose() * explained);
  double before[2] = {0, 0}, after[2] = {0, 0};
  for (Eigen::Index k = 0; k < explained.size(); ++k) {
    const int part = k % kOfPose < kOfPosition ? 0 : 1;
    before[part] += std::pow(equations.residual[k], 2);
    after[part] += std::pow(equations.residual[k] - explained[k], 2);
  }
  return 1 -
         std::min(after[0] / std::max(before[0], 1e-300), after[1] / std::max(before[1], 1e-300));
}

double stated_coefficient(const KinematicChain& chain, int link, int followed) {
  for (const Coupling& coupling : chain.couplings)
    if (coupling.follower == link && coupling.followed == followed) return coupling.coefficient;
  return 0;
}

// Whether a link follows another, by some others or at once.
bool is_follower(const std::vector<Coupling>& couplings, int link, int of) {
  return std::ranges::any_of(couplings, [&](const Coupling& coupling) {
    return coupling.follower == link &&
           (coupling.followed == of || is_follower(couplings, coupling.followed, of));
  });
}

// "J5 with J4 (`coupled: {J4: 0.02}`)".
std::string in_words(const KinematicChain& chain, const Coupling& coupling) {
  const Link &link = chain.links[coupling.follower], &followed = chain.links[coupling.followed];
  const double unit = is_prismatic(link) == is_prismatic(followed) ? 1
                      : is_prismatic(link)                         ? kMillimetre
                                                                   : 1 / kMillimetre;
  return fmt::format("{} with {} (`{}: {{{}: {:.3g}}}`)", link.name, followed.name,
                     link.has_encoder ? "coupled" : "follows", followed.name,
                     coupling.coefficient / unit);
}

}  // namespace

std::vector<ChangedCouplings> other_signs_of_couplings(const KinematicChain& chain) {
  constexpr size_t kMost = 4;  // their subsets are tried
  const size_t count = chain.couplings.size();
  std::vector<ChangedCouplings> changed;
  if (count > kMost) return changed;
  for (unsigned subset = 1; subset < 1U << count; ++subset) {
    ChangedCouplings& signs = changed.emplace_back(chain.couplings, "");
    std::vector<std::string> words;
    for (size_t k = 0; k < count; ++k) {
      if ((subset >> k & 1U) == 0) continue;
      signs.couplings[k].coefficient *= -1;
      words.push_back(in_words(chain, signs.couplings[k]));
    }
    signs.words = fmt::format("{}", fmt::join(words, ", "));
  }
  return changed;
}

std::vector<Coupling> near_couplings(const KinematicChain& chain) {
  constexpr int kFarthest = 2;  // joints apart: gears of a wrist pass one joint by
  const int joints = joint_count(chain);
  std::vector<Coupling> near;
  for (int joint = 0; joint < joints; ++joint)
    for (int other = 0; other < joints; ++other) {
      const int link = link_of_joint(chain, joint), followed = link_of_joint(chain, other);
      if (other == joint || std::abs(other - joint) > kFarthest ||
          is_prismatic(chain.links[followed]) || is_follower(chain.couplings, followed, link))
        continue;
      near.push_back({link, followed, stated_coefficient(chain, link, followed),
                      zero_of(chain.links[followed])});
    }
  return near;
}

ChangedCouplings with_coupling(const KinematicChain& chain, const Coupling& coupling) {
  ChangedCouplings changed{chain.couplings, in_words(chain, coupling)};
  std::erase_if(changed.couplings, [&](const Coupling& stated) {
    return stated.follower == coupling.follower && stated.followed == coupling.followed;
  });
  changed.couplings.push_back(coupling);
  return changed;
}

std::optional<std::string> find_coupling(const PlainFit& fit) {
  constexpr double kNearlyAll = 0.95, kLeastOfAngle = 5e-3, kLeastOfLength = 0.5 * kMillimetre;
  constexpr int kMostPairs = 3;
  const KinematicChain& chain = fit.result.robot.chain;
  std::vector<int> zeros;
  for (int joint = 0; joint < joint_count(chain); ++joint)
    zeros.push_back(zero_offset(chain, joint));
  const FitEquations equations = fit_equations(fit, zeros);
  const std::vector<CoupledPair> pairs = pairs_of(chain, fit.readings, equations);
  const auto is_small = [&](const CoupledPair& pair, double coefficient) {
    return std::abs(coefficient) <
           (is_prismatic(chain.links[pair.link]) ? kLeastOfLength : kLeastOfAngle);
  };
  Eigen::MatrixXd columns(equations.residual.size(), 0);
  std::vector<int> chosen;
  JointFit best;
  double choices = 1, share = 0, fall = 0;
  while (std::ssize(chosen) < std::min<long>(kMostPairs, std::ssize(pairs))) {
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    int next = -1;
    JointFit of_next;
    for (int k = 0; k < std::ssize(pairs); ++k) {
      columns.rightCols<1>() = pairs[k].column;
      JointFit joint = fit_beside(columns, equations);
      if (next >= 0 && joint.share <= of_next.share) continue;
      next = k;
      of_next = std::move(joint);
    }
    columns.rightCols<1>() = pairs[next].column;
    choices *= static_cast<double>(pairs.size());
    const double fall_with = fall_of_bic(of_next, equations, fit.poses(), choices);
    if (share >= kNearlyAll &&
        (fall_with < fall + kClearFall || is_small(pairs[next], of_next.value.tail<1>()[0])))
      break;
    best = std::move(of_next);
    fall = fall_with;
    share = largest_share(columns, best, equations);
    chosen.push_back(next);
  }
  if (share < kNearlyAll || fall < kClearFall) return std::nullopt;
  std::vector<std::string> found;
  for (int k = 0; k < std::ssize(chosen); ++k) {
    const CoupledPair& pair = pairs[chosen[k]];
    if (is_small(pair, best.value[k])) return std::nullopt;
    const double coefficient = stated_coefficient(chain, pair.link, pair.followed) +
                               chain.links[pair.link].sign * best.value[k];
    found.push_back(in_words(chain, {pair.link, pair.followed, coefficient}));
  }
  return fmt::format(
      "joints look as if gears or a screw moved them with others, otherwise than the robot file "
      "says: {}; that explains {:.1f} % of the squared error. If the arm is built so, state it in "
      "the robot file",
      fmt::join(found, ", "), 100 * share);
}

}  // namespace armtrue
