#include "armtrue/planning/planning.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "armtrue/calibration/calibration.h"
#include "calibration/fold.h"
#include "linear_algebra/decompositions.h"
#include "planning/exchange.h"

namespace armtrue {
namespace {

constexpr int kDrawsForZone = 200000;  // forward kinematics is cheap, and a zone is small

Eigen::MatrixXd upper_triangle(const Eigen::MatrixXd& rows) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(rows)
      .matrixQR()
      .topRows(rows.cols())
      .triangularView<Eigen::Upper>();
}

Eigen::MatrixXd divided_by(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& triangle) {
  return triangle.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(rows);
}

// Criterion of a design: D- or I-optimality. Unknowns are scaled so that the information of an
// average pose is the identity: determinants and variances then stay near 1 whatever the units.
class Information {
 public:
  // `blocks`: unknowns x (candidates * block), the transposed derivatives of each candidate.
  // `aim` A: minimise tr(A M^-1 A^T), M the information; empty: maximise log det M.
  Information(Eigen::MatrixXd blocks, int block, Eigen::MatrixXd information, Eigen::MatrixXd aim)
      : blocks_(std::move(blocks)),
        block_(block),
        information_(std::move(information)),
        aim_(std::move(aim)) {}

  void set_chosen(int candidate, bool chosen) {
    const auto rows = blocks_.middleCols(candidate * block_, block_);
    if (chosen)
      information_ += rows * rows.transpose();
    else
      information_ -= rows * rows.transpose();
  }

  // With the information M = L L^T and P = L^-1 B^T of a candidate's block B:
  // log det(M + B^T B) - log det M = log det(I + P^T P), and the variance of the aim A falls by
  // tr((I + P^T P)^-1 Q^T Q), Q = A L^-T P (Woodbury).
  Eigen::VectorXd values_of_adding() const {
    const Eigen::LLT<Eigen::MatrixXd> llt(information_);
    const Eigen::MatrixXd p = llt.matrixL().solve(blocks_);
    Eigen::MatrixXd q;
    if (aim_.size() > 0) q = llt.matrixU().solve<Eigen::OnTheRight>(aim_) * p;
    Eigen::VectorXd gains(blocks_.cols() / block_);
    Eigen::MatrixXd gram(block_, block_);
    Eigen::LLT<Eigen::MatrixXd> gram_llt(block_);
    for (Eigen::Index i = 0; i < gains.size(); ++i) {
      const auto own = p.middleCols(i * block_, block_);
      gram.noalias() = own.transpose().lazyProduct(own);
      gram.diagonal().array() += 1;
      gram_llt.compute(gram);
      if (aim_.size() > 0)
        gains[i] =
            gram_llt.matrixL().solve(q.middleCols(i * block_, block_).transpose()).squaredNorm();
      else
        gains[i] = 2 * gram_llt.matrixLLT().diagonal().array().log().sum();
    }
    return gains;
  }

 private:
  const Eigen::MatrixXd blocks_;
  const int block_;
  Eigen::MatrixXd information_;
  const Eigen::MatrixXd aim_;
};

}  // namespace

PosePlanner::PosePlanner(const Robot& robot, const PlanOptions& options, const Campaign& given)
    : zone_(options.zone), cloud_(pose_cloud(robot, options, given)) {
  const std::vector<PlannedPose> seen = with_given(cloud_);
  typical_ = triangle(readings(cloud_, seen)) / std::sqrt(static_cast<double>(seen.size()));
  given_ = given_derivatives(cloud_, cloud_.robot);
  cloud_position_ = position_triangle(configurations(cloud_.poses));
  if (zone_) zone_position_ = position_triangle(zone_configurations());
}

std::vector<JointVector> PosePlanner::zone_configurations() const {
  const Robot& robot = cloud_.robot;
  const ChainEvaluator evaluator(robot.chain);
  std::vector<JointVector> drawn =
      random_configurations(robot, kDrawsForZone, std::nullopt, cloud_.options.seed);
  std::erase_if(drawn, [&](const JointVector& q) {
    return (evaluator.pose(q).translation - zone_->centre).norm() > zone_->radius ||
           !is_above_floor(cloud_, q);
  });
  if (drawn.empty())
    throw std::invalid_argument(
        "no configuration within the travel limits and above the floor has its point in the zone; "
        "enlarge or move the zone (its centre is in the instrument's frame)");
  return drawn;
}

Eigen::MatrixXd PosePlanner::triangle(const Campaign& campaign) const {
  const ObservationModel model(campaign, cloud_.robot, cloud_.unknowns, cloud_.noise);
  const int p = model.unknowns();
  if (campaign.rows() == 0) return Eigen::MatrixXd::Zero(p, p);
  return fold(model.at(Eigen::VectorXd::Zero(p)), model, ReadingLaw{}).factor.topLeftCorner(p, p);
}

Eigen::MatrixXd PosePlanner::position_triangle(
    const std::vector<JointVector>& configurations) const {
  const Campaign read = points(cloud_, configurations);
  const ObservationModel model(read, cloud_.robot, cloud_.unknowns, {1.0, 1.0});
  const int p = model.unknowns();
  return fold(model.at(Eigen::VectorXd::Zero(p)), model, ReadingLaw{}).factor.topLeftCorner(p, p) /
         std::sqrt(static_cast<double>(read.rows()));
}

std::vector<PlannedPose> PosePlanner::plan(int count) const {
  if (count > kCloudSize)
    throw std::invalid_argument("more poses are asked for than there are candidates, " +
                                std::to_string(kCloudSize));
  const Campaign campaign = readings(cloud_, cloud_.poses);
  const ObservationModel model(campaign, cloud_.robot, cloud_.unknowns, cloud_.noise);
  const int p = model.unknowns(), size = model.row_size();
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(p));
  Eigen::MatrixXd rows(model.rows() * size, p), row(size, p + 1);
  for (int i = 0; i < model.rows(); ++i) {
    at.block(i, row);
    rows.middleRows(i * size, size) = row.leftCols(p);
  }
  rows = equal_blocks(campaign, rows);
  const Eigen::MatrixXd given = divided_by(given_, typical_);
  const Eigen::MatrixXd information =
      given.transpose() * given + kKnownFromStart * Eigen::MatrixXd::Identity(p, p);
  Information design(divided_by(rows, typical_).transpose(),
                     static_cast<int>(rows.rows() / kCloudSize), information,
                     zone_ ? divided_by(zone_position_, typical_) : Eigen::MatrixXd());
  std::vector<PlannedPose> planned;
  for (int candidate : choose_by_exchange(design, kCloudSize, count))
    planned.push_back(cloud_.poses[candidate]);
  return planned;
}

std::vector<PlannedPose> PosePlanner::random(int count, std::uint64_t seed) const {
  return random_poses(cloud_, count, seed);
}

PlanQuality PosePlanner::quality(const std::vector<PlannedPose>& poses) const {
  const Campaign campaign = readings(cloud_, poses);
  const Eigen::Index p = typical_.cols();
  Eigen::MatrixXd rows(2 * p, p);
  rows << given_, triangle(campaign);
  const Eigen::MatrixXd all = upper_triangle(rows);

  PlanQuality quality;
  const Eigen::VectorXd s =
      cloud_.noise.position * Eigen::JacobiSVD<Eigen::MatrixXd>(all).singularValues();
  quality.observability = observability(s, cloud_.given.rows() + campaign.rows());
  const double infinity = std::numeric_limits<double>::infinity();
  if (s[p - 1] <= 1e-10 * s[0]) {
    quality.log_determinant = -infinity;
    quality.cloud_deviation = infinity;
    quality.zone_deviation = zone_ ? infinity : 0;
    return quality;
  }
  quality.log_determinant = 2 * all.diagonal().cwiseAbs().array().log().sum();
  quality.cloud_deviation = divided_by(cloud_position_, all).norm();
  quality.zone_deviation = zone_ ? divided_by(zone_position_, all).norm() : 0;
  return quality;
}

}  // namespace armtrue
