#include "planning/contest.h"

#include <algorithm>
#include <cmath>

#include "armtrue/observation/session_models.h"
#include "planning/choose_by_exchange.h"

namespace armtrue {
namespace {

constexpr double kMinLeft = 1e-5;   // of a column's own norm; less is rounding
constexpr double kMinPivot = 1e-9;  // of columns of unit length

}  // namespace

Contest contest_about(size_t which, const Robot& robot, const std::vector<TracedEffect>& found) {
  Contest contest;
  contest.robot = robot;
  for (size_t k = 0; k < found.size(); ++k)
    if (k != which) contest.robot.effects.push_back(found[k].effect);
  contest.members.push_back({found[which].effect, found[which].separated_by});
  for (const Rival& rival : found[which].indistinguishable)
    contest.members.push_back({rival.effect, rival.separated_by});
  return contest;
}

void enter_members(Contest& contest, const std::vector<std::string>& temperature_names) {
  for (Contest::Member& member : contest.members) {
    member.raw_count =
        BoundEffect(member.effect, contest.robot, temperature_names).coefficient_count();
    contest.robot.effects.push_back(member.effect);
  }
}

Eigen::MatrixXd derivatives(const Contest& contest, const PoseCloud& cloud,
                            const Campaign& campaign) {
  const Eigen::MatrixXd blocks =
      SessionModels(campaign, contest.robot, cloud.unknowns, sigma_of(cloud, campaign)).blocks();
  return blocks.leftCols(blocks.cols() - 1);
}

namespace {

// Leaves out columns whose part orthogonal to the others is below `smallest` of their norm in
// `whole`.
Contest::Standard standard_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& whole,
                              double smallest, double poses) {
  const Eigen::VectorXd norm = columns.colwise().norm();
  const Eigen::VectorXd unit =
      (norm.array() > smallest * whole.array()).select(norm.cwiseInverse(), 0.0);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  qr.setThreshold(smallest);
  qr.compute(columns * unit.asDiagonal());
  const Eigen::Index rank = qr.rank();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(columns.cols(), rank);
  inverse.topRows(rank) = qr.matrixR()
                              .topLeftCorner(rank, rank)
                              .triangularView<Eigen::Upper>()
                              .solve(Eigen::MatrixXd::Identity(rank, rank));
  Contest::Standard standard;
  standard.of_raw = std::sqrt(poses) * unit.asDiagonal() * (qr.colsPermutation() * inverse);
  standard.of_coefficients = (columns * standard.of_raw).transpose() * columns / poses;
  return standard;
}

}  // namespace

void standardise(Contest& contest, const Eigen::MatrixXd& rows, double poses) {
  Eigen::Index raw_members = 0;
  for (const Contest::Member& member : contest.members) raw_members += member.raw_count;
  const Eigen::Index raw = rows.cols() - raw_members;
  const Eigen::MatrixXd nuisances = rows.leftCols(raw), members = rows.rightCols(raw_members);
  const Contest::Standard nuisance =
      standard_of(nuisances, nuisances.colwise().norm(), kMinPivot, poses);
  const Eigen::MatrixXd basis = nuisances * nuisance.of_raw;
  const Eigen::MatrixXd along = basis.transpose() * members / poses;
  const Eigen::MatrixXd left = members - basis * along;
  const Eigen::VectorXd whole = members.colwise().norm();

  contest.nuisances = static_cast<int>(basis.cols());
  Eigen::Index taken = 0;
  int count = 0;
  Eigen::MatrixXd of_raw = Eigen::MatrixXd::Zero(raw_members, raw_members);
  for (Contest::Member& member : contest.members) {
    member.standard = standard_of(left.middleCols(taken, member.raw_count),
                                  whole.segment(taken, member.raw_count), kMinLeft, poses);
    member.first = count;
    member.count = static_cast<int>(member.standard.of_raw.cols());
    of_raw.block(taken, count, member.raw_count, member.count) = member.standard.of_raw;
    taken += member.raw_count;
    count += member.count;
  }
  const Eigen::MatrixXd used = of_raw.leftCols(count);
  contest.standard = Eigen::MatrixXd::Zero(rows.cols(), contest.nuisances + count);
  contest.standard.topLeftCorner(raw, contest.nuisances) = nuisance.of_raw;
  contest.standard.topRightCorner(raw, count) = -nuisance.of_raw * along * used;
  contest.standard.bottomRightCorner(raw_members, count) = used;
}

Fitted::Fitted(const Eigen::MatrixXd& gram, int nuisances)
    : nuisance(gram.topLeftCorner(nuisances, nuisances) +
               kKnownFromStart * Eigen::MatrixXd::Identity(nuisances, nuisances)) {
  const Eigen::Index count = gram.rows() - nuisances;
  share = nuisance.matrixL().solve(gram.topRightCorner(nuisances, count));
  members = gram.bottomRightCorner(count, count) - share.transpose() * share;
}

Imitation::Imitation(const Eigen::MatrixXd& information, const Contest::Member& truth,
                     const Contest::Member& rival) {
  const auto between = [&](const Contest::Member& a, const Contest::Member& b) {
    return information.block(a.first, b.first, a.count, b.count);
  };
  Eigen::MatrixXd of_rival = between(rival, rival);
  of_rival.diagonal().array() += kKnownFromStart;
  const Eigen::VectorXd product = between(rival, truth) * truth.size;
  size = Eigen::LLT<Eigen::MatrixXd>(of_rival).solve(product);
  left = std::max(0.0, truth.size.dot(between(truth, truth) * truth.size) - product.dot(size));
}

}  // namespace armtrue
