#include "armtrue/identification/planning.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "armtrue/identification/calibration.h"
#include "armtrue/identification/identifiability.h"
#include "fold.h"

namespace armtrue {
namespace {

constexpr double kUsualPositionNoise = 1e-4;     // m
constexpr double kUsualOrientationNoise = 1e-4;  // rad
constexpr double kOnTheFloor = 1e-9;             // m; a frame in the plane of the base is above it
constexpr int kDrawsPerConfiguration = 64;
constexpr int kDrawsForZone = 200000;  // forward kinematics is cheap, and a zone is small

// Share of an average pose that is known of every unknown from the start, so that the first poses,
// too few for full rank, have a criterion.
constexpr double kKnownFromStart = 1e-6;
constexpr double kWorthExchanging = 1e-6;  // relative gain
constexpr int kMaxPasses = 100;

Robot geometric_only(Robot robot) {
  robot.effects.clear();
  return robot;
}

ReadingScale noise_of(const Robot& robot) {
  return {robot.noise.position > 0 ? robot.noise.position : kUsualPositionNoise,
          robot.noise.orientation > 0 ? robot.noise.orientation : kUsualOrientationNoise};
}

bool is_above(double floor, const ChainEvaluator& evaluator, const KinematicChain& chain,
              const JointVector& q) {
  const std::array<Pose, kLinks> frames = evaluator.link_frames(q);
  const auto above = [&](const Eigen::Vector3d& point) { return point.z() >= floor - kOnTheFloor; };
  const Pose tool = frames.back() * chain.tool;
  return std::all_of(frames.begin(), frames.end(),
                     [&](const Pose& frame) { return above(frame.translation); }) &&
         above(tool.translation) &&
         std::all_of(chain.targets.begin(), chain.targets.end(),
                     [&](const Target& target) { return above(tool * target.position); });
}

Eigen::MatrixXd upper_triangle(const Eigen::MatrixXd& rows) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(rows)
      .matrixQR()
      .topRows(rows.cols())
      .triangularView<Eigen::Upper>();
}

Eigen::MatrixXd divided_by(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& triangle) {
  return triangle.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(rows);
}

// The search. Unknowns are scaled so that an average pose has the identity as its information:
// determinants and variances then stay near 1 whatever the units.
class Exchange {
 public:
  // `blocks`: unknowns x (candidates * block), the transposed derivatives of each candidate.
  // `aim`: the criterion is |aim information^-1/2|^2; empty: the determinant.
  Exchange(Eigen::MatrixXd blocks, int block, Eigen::MatrixXd information, Eigen::MatrixXd aim)
      : blocks_(std::move(blocks)),
        block_(block),
        information_(std::move(information)),
        aim_(std::move(aim)),
        is_chosen_(static_cast<size_t>(blocks_.cols() / block), false) {}

  std::vector<int> choose(int count) {
    std::vector<int> chosen;
    for (int k = 0; k < count; ++k) {
      const Eigen::VectorXd gains = gains_of_adding();
      chosen.push_back(best_free(gains));
      set_chosen(chosen.back(), true);
    }
    bool exchanged = true;
    for (int pass = 0; pass < kMaxPasses && exchanged; ++pass) {
      exchanged = false;
      for (int& candidate : chosen) {
        set_chosen(candidate, false);
        const Eigen::VectorXd gains = gains_of_adding();
        const int best = best_free(gains);
        if (gains[best] > (1 + kWorthExchanging) * gains[candidate]) {
          candidate = best;
          exchanged = true;
        }
        set_chosen(candidate, true);
      }
    }
    return chosen;
  }

 private:
  void set_chosen(int candidate, bool chosen) {
    const auto rows = blocks_.middleCols(candidate * block_, block_);
    if (chosen)
      information_ += rows * rows.transpose();
    else
      information_ -= rows * rows.transpose();
    is_chosen_[candidate] = chosen;
  }

  int best_free(const Eigen::VectorXd& gains) const {
    int best = -1;
    for (int i = 0; i < gains.size(); ++i)
      if (!is_chosen_[i] && (best < 0 || gains[i] > gains[best])) best = i;
    return best;
  }

  // With the information M = L L^T and P = L^-1 B^T of a candidate's block B:
  // log det(M + B^T B) - log det M = log det(I + P^T P), and the variance of the aim A falls by
  // tr((I + P^T P)^-1 Q^T Q), Q = A L^-T P (Woodbury).
  Eigen::VectorXd gains_of_adding() const {
    const Eigen::LLT<Eigen::MatrixXd> llt(information_);
    const Eigen::MatrixXd p = llt.matrixL().solve(blocks_);
    Eigen::MatrixXd q;
    if (aim_.size() > 0) q = llt.matrixU().solve<Eigen::OnTheRight>(aim_) * p;
    Eigen::VectorXd gains(static_cast<Eigen::Index>(is_chosen_.size()));
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

  const Eigen::MatrixXd blocks_;
  const int block_;
  Eigen::MatrixXd information_;
  const Eigen::MatrixXd aim_;
  std::vector<bool> is_chosen_;
};

}  // namespace

PosePlanner::PosePlanner(const Robot& robot, const PlanOptions& options, const Campaign& given)
    : robot_(geometric_only(robot)),
      options_(options),
      noise_(noise_of(robot)),
      given_rows_(given.rows()) {
  if (given_rows_ > 0) {  // what is planned is read as what is given
    options_.orientation = given.has_orientation();
    if (given.target_names.empty()) robot_.chain.targets.clear();
    if (!given.has_distances()) robot_.chain.anchors.clear();
  } else if (!robot_.chain.targets.empty() || !robot_.chain.anchors.empty()) {
    options_.orientation = false;
  }
  cloud_ = draw(candidate_count(), options_.box, options_.seed);

  // A box may leave unseen what the given poses show.
  std::vector<JointVector> seen = cloud_;
  std::vector<bool> is_in(given.pose_ids.size(), false);
  for (int row = 0; row < given_rows_; ++row)
    if (!is_in[given.pose[row]]) {
      is_in[given.pose[row]] = true;
      seen.push_back(given.q[row]);
    }
  const Campaign everything = readings(seen);
  unknowns_ = choose_identifiable(robot_, everything).kept;
  if (unknowns_.empty())
    throw std::invalid_argument(
        "no pose shows any of the parameters that 'identify' of the robot allows; allow others, or "
        "measure orientations too");
  typical_ = triangle(everything) / std::sqrt(static_cast<double>(seen.size()));

  // Only derivatives count. They do not depend on the positions read, and on the orientations read
  // only as far as these lie off the model.
  Campaign as_predicted = given;
  const ChainEvaluator evaluator(robot_.chain);
  for (size_t row = 0; row < as_predicted.orientation.size(); ++row)
    as_predicted.orientation[row] = evaluator.pose(given.q[row]).rotation;
  given_ = triangle(as_predicted);

  cloud_position_ = position_triangle(cloud_);
  if (options_.zone) zone_position_ = position_triangle(zone_configurations());
}

std::vector<JointVector> PosePlanner::draw(int count, const std::optional<Box>& box,
                                           std::uint64_t seed) const {
  const ChainEvaluator evaluator(robot_.chain);
  for (int draws = 2; draws <= kDrawsPerConfiguration; draws *= 2) {
    std::vector<JointVector> drawn = random_configurations(robot_, draws * count, box, seed);
    std::erase_if(drawn, [&](const JointVector& q) {
      return !is_above(options_.floor, evaluator, robot_.chain, q);
    });
    if (static_cast<int>(drawn.size()) < count) continue;
    drawn.resize(count);
    return drawn;
  }
  throw std::invalid_argument(
      "hardly any configuration keeps links and tool above the floor; lower it or move the box up");
}

std::vector<JointVector> PosePlanner::zone_configurations() const {
  const ChainEvaluator evaluator(robot_.chain);
  std::vector<JointVector> drawn =
      random_configurations(robot_, kDrawsForZone, std::nullopt, options_.seed);
  std::erase_if(drawn, [&](const JointVector& q) {
    return (evaluator.pose(q).translation - options_.zone->centre).norm() > options_.zone->radius ||
           !is_above(options_.floor, evaluator, robot_.chain, q);
  });
  if (drawn.empty())
    throw std::invalid_argument(
        "no configuration within the travel limits and above the floor has its point in the zone; "
        "enlarge or move the zone (its centre is in the instrument's frame)");
  return drawn;
}

// Of every target, once for each anchor.
Campaign PosePlanner::points(const std::vector<JointVector>& configurations) const {
  const ChainEvaluator evaluator(robot_.chain);
  const size_t targets = robot_.chain.targets.size(), anchors = robot_.chain.anchors.size();
  Campaign campaign;
  for (const Target& target : robot_.chain.targets) campaign.target_names.push_back(target.name);
  for (size_t pose = 0; pose < configurations.size(); ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose + 1));
    const Pose frame = evaluator.pose(configurations[pose]);
    for (size_t channel = 0; channel < std::max<size_t>(1, targets) * std::max<size_t>(1, anchors);
         ++channel) {
      campaign.pose.push_back(static_cast<int>(pose));
      campaign.q.push_back(configurations[pose]);
      campaign.position.push_back(frame.translation);
      if (targets > 0) campaign.target.push_back(static_cast<int>(channel % targets));
    }
  }
  return campaign;
}

Campaign PosePlanner::readings(const std::vector<JointVector>& configurations) const {
  Campaign campaign = points(configurations);
  const size_t targets = std::max<size_t>(1, robot_.chain.targets.size());
  const size_t anchors = robot_.chain.anchors.size();
  if (anchors > 0) {
    for (const Anchor& anchor : robot_.chain.anchors) campaign.anchor_names.push_back(anchor.name);
    for (size_t row = 0; row < campaign.q.size(); ++row)
      campaign.anchor.push_back(static_cast<int>(row / targets % anchors));
    campaign.position.clear();
    campaign.distance.assign(campaign.q.size(), 1.0);  // only derivatives count
  }
  if (options_.orientation) {
    const ChainEvaluator evaluator(robot_.chain);
    for (const JointVector& q : campaign.q)
      campaign.orientation.emplace_back(evaluator.pose(q).rotation);
  }
  return campaign;
}

Eigen::MatrixXd PosePlanner::triangle(const Campaign& campaign) const {
  const ObservationModel model(campaign, robot_, unknowns_, noise_);
  const int p = model.unknowns();
  if (campaign.rows() == 0) return Eigen::MatrixXd::Zero(p, p);
  return fold(model.at(Eigen::VectorXd::Zero(p)), model, ReadingLaw{}).factor.topLeftCorner(p, p);
}

Eigen::MatrixXd PosePlanner::position_triangle(
    const std::vector<JointVector>& configurations) const {
  const Campaign read = points(configurations);
  const ObservationModel model(read, robot_, unknowns_, {1.0, 1.0});
  const int p = model.unknowns();
  return fold(model.at(Eigen::VectorXd::Zero(p)), model, ReadingLaw{}).factor.topLeftCorner(p, p) /
         std::sqrt(static_cast<double>(read.rows()));
}

std::vector<JointVector> PosePlanner::plan(int count) const {
  if (count > candidate_count())
    throw std::invalid_argument("more poses are asked for than there are candidates, " +
                                std::to_string(candidate_count()));
  const Campaign campaign = readings(cloud_);
  const ObservationModel model(campaign, robot_, unknowns_, noise_);
  const int p = model.unknowns(), size = model.row_size();
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(p));
  Eigen::MatrixXd rows(model.rows() * size, p), row(size, p + 1);
  for (int i = 0; i < model.rows(); ++i) {
    at.block(i, row);
    rows.middleRows(i * size, size) = row.leftCols(p);
  }
  const Eigen::MatrixXd given = divided_by(given_, typical_);
  const Eigen::MatrixXd information =
      given.transpose() * given + kKnownFromStart * Eigen::MatrixXd::Identity(p, p);
  Exchange exchange(divided_by(rows, typical_).transpose(),
                    static_cast<int>(rows.rows() / candidate_count()), information,
                    options_.zone ? divided_by(zone_position_, typical_) : Eigen::MatrixXd());
  std::vector<JointVector> planned;
  for (int candidate : exchange.choose(count)) planned.push_back(cloud_[candidate]);
  return planned;
}

std::vector<JointVector> PosePlanner::random(int count, std::uint64_t seed) const {
  return draw(count, options_.box, seed);
}

PlanQuality PosePlanner::quality(const std::vector<JointVector>& configurations) const {
  const Campaign campaign = readings(configurations);
  const Eigen::Index p = typical_.cols();
  Eigen::MatrixXd rows(2 * p, p);
  rows << given_, triangle(campaign);
  const Eigen::MatrixXd all = upper_triangle(rows);

  PlanQuality quality;
  const Eigen::VectorXd s =
      noise_.position * Eigen::JacobiSVD<Eigen::MatrixXd>(all).singularValues();
  quality.observability = observability(s, given_rows_ + campaign.rows());
  const double infinity = std::numeric_limits<double>::infinity();
  if (s[p - 1] <= 1e-10 * s[0]) {
    quality.log_determinant = -infinity;
    quality.cloud_deviation = infinity;
    quality.zone_deviation = options_.zone ? infinity : 0;
    return quality;
  }
  quality.log_determinant = 2 * all.diagonal().cwiseAbs().array().log().sum();
  quality.cloud_deviation = divided_by(cloud_position_, all).norm();
  quality.zone_deviation = options_.zone ? divided_by(zone_position_, all).norm() : 0;
  return quality;
}

}  // namespace armtrue
