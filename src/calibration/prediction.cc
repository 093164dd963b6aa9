#include "armtrue/calibration/prediction.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "calibration/moved_positions.h"
#include "calibration/pose_after_pose.h"
#include "calibration/prior.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

// Covariances of the positions of all rows that a root gives, 3 x 3, or 1 x 1 of lengths.
std::vector<Eigen::MatrixXd> position_covariances(const MovedPositions& positions, int rows) {
  std::vector<Eigen::MatrixXd> covariances(rows);
  positions.for_each_row([&](size_t row, const auto& moved, const auto&) {
    covariances[row] = moved * moved.transpose();
  });
  return covariances;
}

// The largest variance of a row's position, summed over its axes, that a root gives.
double largest_variance(const MovedPositions& positions) {
  double largest = 0;
  positions.add_up<double>(
      [](double& most, std::span<const int> rows, const auto& moved, const auto&) {
        const auto axes = moved.rows() / std::ssize(rows);
        for (Eigen::Index first = 0; first < moved.rows(); first += axes)
          most = std::max(most, moved.middleRows(first, axes).squaredNorm());
      },
      [&](double most) { largest = std::max(largest, most); });
  return largest;
}

// The measured points of a campaign that reads lengths, without values.
Campaign as_points(Campaign campaign) {
  campaign.distance.clear();
  campaign.coordinate.clear();
  campaign.touch.clear();
  campaign.profile.clear();
  campaign.anchor.clear();
  campaign.anchor_names.clear();
  campaign.contact_names.clear();
  campaign.position.assign(campaign.q.size(), Eigen::Vector3d::Zero());
  return campaign;
}

// Lower triangular G with G G^T = covariance.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd unit = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd inverse = (unit.array() > 0).select(unit.cwiseInverse(), 0.0);
  // A covariance from fewer poses than unknowns has no Cholesky factor; its QR one exists.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
      Eigen::MatrixXd(inverse.asDiagonal() * covariance * inverse.asDiagonal())};
  const Eigen::MatrixXd square_root =
      eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(square_root);
  const Eigen::MatrixXd triangle = qr.matrixQR().triangularView<Eigen::Upper>();
  return unit.asDiagonal() * triangle.transpose();
}

std::vector<int> indices_of(const Robot& robot, const std::vector<std::string>& names) {
  std::vector<int> indices;
  for (const std::string& name : names)
    indices.push_back(find_parameter(robot.chain, name).value());
  return indices;
}

// The standard deviation that each row states, over `usual`; 0: over usual_sigma() of the campaign.
std::vector<double> times_of_usual(const Campaign& campaign, double usual) {
  std::vector<double> times = campaign.sigma_position;
  if (times.empty()) return std::vector<double>(campaign.q.size(), 1);
  if (usual <= 0) usual = usual_sigma(campaign);
  for (double& sigma : times) sigma /= usual;
  return times;
}

// Number of the pairs of a pose and a quantity that is read of it.
double count_read(const Campaign& campaign) {
  std::vector<int> read;
  for (int row = 0; row < campaign.rows(); ++row) read.push_back(campaign.pose_by_quantity(row));
  std::ranges::sort(read);
  return static_cast<double>(std::ranges::unique(read).begin() - read.begin());
}

// How readings scatter about the model.
struct Spread {
  InstrumentNoise deviation;  // per axis
  double tail = 1;            // Uncertainty::tail
};

// The 95 % quantile of the lengths of position residuals over `normal`, that of a normal law; 1 if
// no more poses lie beyond it than chance allows.
double tail_of(std::vector<double> lengths, double normal, int poses) {
  constexpr double kOutside = 0.05, kSignificance = 0.05;
  const auto rows = static_cast<double>(lengths.size());
  const auto beyond = static_cast<double>(
      std::ranges::count_if(lengths, [&](double length) { return length > normal; }));
  // Readings of a pose share their error, so they count as one.
  const int poses_beyond = static_cast<int>(std::floor(beyond / rows * poses));
  if (normal <= 0 || binomial_at_least(poses_beyond, poses, kOutside) >= kSignificance) return 1;
  const auto inside =
      lengths.begin() + static_cast<std::ptrdiff_t>(std::ceil((1 - kOutside) * rows));
  std::nth_element(lengths.begin(), inside - 1, lengths.end());
  return std::max(1.0, *(inside - 1) / normal);
}

// Of the residuals of a fit, corrected for the number of unknowns; includes the error that rows of
// one pose have in common.
Spread spread_of(const CalibrationResult& fit, const Campaign& campaign,
                 const Evaluation& evaluation) {
  if (std::ssize(fit.weights) != campaign.rows())
    throw std::logic_error("the campaign is not the one of the fit");
  const ReadingSize size = campaign.reading_size();
  double position = 0, orientation = 0, rows = 0;
  for (int row = 0; row < campaign.rows(); ++row) {
    const double weight = fit.weights[row];
    position += weight * evaluation.residuals[row].head<3>().squaredNorm();
    orientation += weight * evaluation.residuals[row].tail<3>().squaredNorm();
    rows += std::min(1.0, weight);
  }
  // Readings of a pose share the lack of fit of the model: the unknowns follow poses, not readings.
  const double poses = campaign.poses();
  const double quantities = campaign.has_touches() ? count_read(campaign)  // each of one contact
                                                   : poses * campaign.quantities();
  // Within poses the noise loses nothing to the unknowns; between poses all readings of a pose do.
  const double visits = std::max(1.0, rows / quantities);
  const auto deviation = [&](double squares, int axes, double determined) {
    if (axes == 0) return 0.0;
    const double left = std::max(0.1, 1 - determined / (quantities * axes));
    return std::sqrt(squares / (rows * axes * (visits - 1 + left) / visits));
  };
  Spread spread;
  spread.deviation = {deviation(position, size.position, fit.determined[0]),
                      deviation(orientation, size.orientation, fit.determined[1])};
  const int axes = size.position;
  const double normal =
      std::sqrt(position / rows * fisher_f_quantile(0.95, axes, axes * std::max(1.0, poses - 1)));
  spread.tail = tail_of(evaluation.position, normal, campaign.poses());
  return spread;
}

}  // namespace

MeanSquare mean_square_by_uncertainty(const Robot& robot, const Campaign& campaign,
                                      const RootsOfSessions& roots) {
  const Uncertainty& known = robot.uncertainty.value();
  const Eigen::Index columns = known.root.cols();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(columns, columns);  // its lower triangle
  const std::vector<int> geometric = indices_of(robot, known.parameters);
  MovedPositions(robot, campaign, geometric, known.root, roots)
      .add_up<Eigen::MatrixXd>(
          [&](Eigen::MatrixXd& of_block, std::span<const int>, const auto& moved, const auto&) {
            if (of_block.size() == 0) of_block = Eigen::MatrixXd::Zero(columns, columns);
            of_block.selfadjointView<Eigen::Lower>().rankUpdate(moved.transpose());
          },
          [&](const Eigen::MatrixXd& of_block) { sum += of_block; });
  sum /= campaign.rows();
  const double expected = sum.trace();
  if (expected <= 0) return {};
  const double squares = 2 * sum.squaredNorm() - sum.diagonal().squaredNorm();
  return {expected, expected * expected / squares};
}

namespace {

// The unknowns of a fit whose uncertainty is stated: those of the first session, without the places
// of targets where there are so many that a file may not hold the root. Effects that were not
// fitted stand behind those that were, and have no unknowns.
std::vector<int> stated_unknowns(const CalibrationResult& fit) {
  constexpr int kMaxUnknowns = 800;
  const auto geometric = std::ssize(fit.set.kept);
  const int count = fit.shared;
  const int first = layout_of(fit.robot.chain).targets;
  const int end = first_anchor_parameter(fit.robot.chain);
  std::vector<int> unknowns;
  for (int k = 0; k < count; ++k) {
    const int parameter = k < geometric ? fit.set.kept[k] : 0;
    if (count <= kMaxUnknowns || parameter < first || parameter >= end) unknowns.push_back(k);
  }
  return unknowns;
}

// A parameter that these poses do not show, but others would, keeps its nominal value: it errs by
// its prior, and those that imitate it at these poses err by their shares of that. Elsewhere they
// do not imitate it.
void add_lost(const CalibrationResult& fit, const Campaign& campaign, Uncertainty& uncertainty) {
  Robot as_made = fit.robot;
  if (as_made.nominal) as_made.chain.links = as_made.nominal->links;
  const std::vector<int> lost = lost_to_poses(as_made, campaign, fit.set);
  const std::vector<int> known = indices_of(fit.robot, uncertainty.parameters);
  const Eigen::Index geometric = std::ssize(known), before = uncertainty.root.rows();
  std::vector<Eigen::VectorXd> moved;  // of each lost one, what its prior moves
  for (const AbsorbedParameter& absorbed : fit.set.absorbed) {
    if (std::ranges::count(lost, absorbed.parameter) == 0) continue;
    const double deviation = prior_deviation(as_made, absorbed.parameter, fit.prior_widths);
    if (deviation <= 0) continue;
    Eigen::VectorXd& column = moved.emplace_back(Eigen::VectorXd::Zero(before));
    for (const auto& [parameter, share] : absorbed.absorbed_by)
      if (const auto found = std::ranges::find(known, parameter); found != known.end())
        column[found - known.begin()] = -share * deviation;
    uncertainty.parameters.push_back(parameter_name(fit.robot.chain, absorbed.parameter));
    column.conservativeResize(before + 1);
    column[before] = deviation;
  }
  if (moved.empty()) return;
  // Lost ones stand between the geometric parameters and the coefficients.
  const Eigen::Index count = std::ssize(moved), after = before - geometric;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(before + count, before + count);
  root.topLeftCorner(geometric, before) = uncertainty.root.topRows(geometric);
  root.bottomLeftCorner(after, before) = uncertainty.root.bottomRows(after);
  for (Eigen::Index k = 0; k < count; ++k) {
    root.col(before + k).head(geometric) = moved[k].head(geometric);
    root(geometric + k, before + k) = moved[k][before];
  }
  uncertainty.root = root_of(root * root.transpose());
}

// Of the parameters that were identified.
Uncertainty uncertainty_of_fit(const CalibrationResult& fit, const Campaign& campaign,
                               const Evaluation& evaluation) {
  Uncertainty uncertainty;
  const std::vector<int> unknowns = stated_unknowns(fit);
  std::vector<int> geometric;
  for (int k : unknowns)
    if (k < std::ssize(fit.set.kept)) geometric.push_back(fit.set.kept[k]);
  for (int k : geometric) uncertainty.parameters.push_back(parameter_name(fit.robot.chain, k));
  uncertainty.root = root_of(fit.covariance(unknowns, unknowns));
  const Spread spread = spread_of(fit, campaign, evaluation);
  uncertainty.reading = spread.deviation;
  uncertainty.tail = spread.tail;
  uncertainty.poses = campaign.poses();
  uncertainty.largest_variance =
      largest_variance(MovedPositions(fit.robot, campaign, geometric, uncertainty.root));
  if (campaign.reads_one_number()) {
    const Campaign points = as_points(campaign);
    uncertainty.largest_variance_of_point =
        largest_variance(MovedPositions(fit.robot, points, geometric, uncertainty.root));
  }
  return uncertainty;
}

}  // namespace

Uncertainty uncertainty_of(const CalibrationResult& fit, const Campaign& campaign) {
  return uncertainty_of(fit, campaign, evaluate(fit.robot, campaign));
}

Uncertainty uncertainty_of(const CalibrationResult& fit, const Campaign& campaign,
                           const Evaluation& evaluation) {
  Uncertainty uncertainty = uncertainty_of_fit(fit, campaign, evaluation);
  add_lost(fit, campaign, uncertainty);
  return uncertainty;
}

namespace {

// The rows of a root of all unknowns, `stated` those of the first session, with the own parameters
// of each further session in their place. Where few points determine it, a base errs by much, and
// by its own amount.
RootsOfSessions roots_of_sessions(const CalibrationResult& fit, const std::vector<int>& stated,
                                  const Eigen::MatrixXd& root) {
  RootsOfSessions roots;
  for (const auto& [name, session] : fit.robot.sessions) {
    std::vector<Eigen::Index> rows(stated.begin(), stated.end());
    bool is_further = false;
    for (Eigen::Index& row : rows)
      if (const auto own = std::find(fit.names.begin() + fit.shared, fit.names.end(),
                                     "session " + name + " " + fit.names[row]);
          own != fit.names.end()) {
        row = own - fit.names.begin();
        is_further = true;
      }
    if (is_further) roots[name] = root(rows, Eigen::all);
  }
  return roots;
}

}  // namespace

IfComplete uncertainty_if_complete(const CalibrationResult& fit, const Campaign& campaign) {
  constexpr Eigen::Index kMaxColumns =
      800;  // of all sessions: a filter of their bases takes its cube
  Uncertainty uncertainty = uncertainty_of_fit(fit, campaign, evaluate(fit.robot, campaign));
  const std::vector<int> stated = stated_unknowns(fit);
  const Eigen::MatrixXd root = fit.inverse_root(stated, Eigen::all);
  // Readings of a pose may err together: they scatter about the model as single ones do.
  const double usual =  // of fit.sigma a row has the median
      campaign.sigma_position.empty() ? 1 : usual_sigma(campaign) / median(campaign.sigma_position);
  const double scatter = std::max(1.0, uncertainty.reading.position / (usual * fit.sigma.position));
  if (fit.robot.sessions.empty() || fit.inverse_root.cols() > kMaxColumns) {
    uncertainty.root = scatter * root_of(root * root.transpose());
    return {uncertainty, {}};
  }
  uncertainty.root = scatter * root;
  return {uncertainty, roots_of_sessions(fit, stated, scatter * fit.inverse_root)};
}

Uncertainty after_refit(const Robot& robot, const Campaign& campaign,
                        const std::vector<int>& refitted) {
  if (!robot.uncertainty)
    throw std::invalid_argument("the robot does not state its uncertainty; calibrate writes it");
  Uncertainty known = *robot.uncertainty;
  const std::vector<int> before = indices_of(robot, known.parameters);
  std::vector<int> all = refitted;  // then the others
  std::vector<Eigen::Index> others;
  for (Eigen::Index k = 0; k < known.root.rows(); ++k) {
    const bool geometric = k < std::ssize(before);
    if (geometric && std::ranges::count(refitted, before[k]) > 0) continue;
    if (geometric) all.push_back(before[k]);
    others.push_back(k);
  }
  const ReadingSigma sigma{std::max(1e-9, known.reading.position),
                           known.reading.orientation > 0 ? known.reading.orientation : 1.0};
  const ObservationModel model(campaign, robot, all, sigma);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  const int size = model.row_size();
  Eigen::MatrixXd rows(model.rows() * size, model.unknowns() + 1);
  for (int row = 0; row < model.rows(); ++row) at.block(row, rows.middleRows(row * size, size));

  const Eigen::Index own = refitted.size();
  const auto rest = std::min<Eigen::Index>(std::ssize(others), model.unknowns() - own);
  others.resize(rest);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows.leftCols(own));
  const Eigen::MatrixXd taken_up = -qr.solve(Eigen::MatrixXd(rows.middleCols(own, rest)));
  const Eigen::MatrixXd root = known.root(others, Eigen::all);
  Eigen::MatrixXd joint(own + rest, root.cols());
  joint << taken_up * root, root;
  Eigen::MatrixXd covariance = joint * joint.transpose();
  const Eigen::MatrixXd gram = rows.leftCols(own).transpose() * rows.leftCols(own);
  covariance.topLeftCorner(own, own) += gram.ldlt().solve(identity(own));
  known.root = root_of(covariance);
  known.parameters.clear();
  for (int k : all) known.parameters.push_back(parameter_name(robot.chain, k));
  return known;
}

std::vector<Prediction> predict(const Robot& robot, const Campaign& campaign) {
  if (!robot.uncertainty)
    throw std::invalid_argument("the robot does not state its uncertainty; calibrate writes it");
  const Uncertainty& known = *robot.uncertainty;
  const std::vector<int> geometric = indices_of(robot, known.parameters);
  const MovedPositions positions(robot, campaign, geometric, known.root);
  const bool points_after_lengths =
      known.largest_variance_of_point > 0 && !campaign.reads_one_number();
  const double largest =
      points_after_lengths ? known.largest_variance_of_point : known.largest_variance;
  const std::vector<double> times = times_of_usual(campaign, 0);
  std::vector<Prediction> predictions;
  for (Eigen::MatrixXd& covariance : position_covariances(positions, campaign.rows())) {
    const double of_row = known.reading.position * times[predictions.size()];
    Prediction& prediction = predictions.emplace_back();
    const double of_robot = covariance.trace();
    if (largest > 0) prediction.leverage = of_robot / largest;
    const auto axes = static_cast<double>(covariance.rows());
    const double reading = of_row * of_row;
    prediction.deviation = std::sqrt(of_robot + axes * reading);
    covariance.diagonal().array() += known.tail * known.tail * reading;
    const double trace = covariance.trace(), of_reading = trace - of_robot;
    const double freedom = trace * trace / covariance.squaredNorm();
    // The robot's part comes from the scatter of the poses, that of a reading from their axes too.
    const double poses = std::max(1, known.poses - 1);
    const double known_with =
        trace * trace / (of_robot * of_robot / poses + of_reading * of_reading / (axes * poses));
    prediction.bound_95 = std::sqrt(trace * fisher_f_quantile(0.95, freedom, known_with));
  }
  return predictions;
}

double usual_sigma(const Campaign& campaign) {
  const std::vector<double>& own = campaign.sigma_position;
  return own.empty() ? 0 : std::sqrt(mean_of(own, [](double sigma) { return sigma * sigma; }));
}

double p_of_errors(const Robot& robot, const Campaign& campaign, double usual,
                   const RootsOfSessions& roots) {
  const Uncertainty& known = robot.uncertainty.value();
  const Eigen::Index columns = known.root.cols();
  const int axes = campaign.reading_size().position;
  const std::vector<int> geometric = indices_of(robot, known.parameters);
  const std::vector<double> times = times_of_usual(campaign, usual);
  std::map<int, PoseError> poses;
  MovedPositions(robot, campaign, geometric, known.root, roots)
      .for_each_row([&](size_t row, const auto& moved, const auto& residual) {
        PoseError& pose = poses[campaign.pose[row]];
        if (pose.readings++ == 0) {
          pose.moved = Eigen::MatrixXd::Zero(axes, columns);
          pose.residual = Eigen::VectorXd::Zero(axes);
        }
        pose.moved += moved / times[row];  // as if all read with the usual noise
        pose.residual += residual / times[row];
      });
  const double known_with = axes * std::max(1, known.poses - 1);
  const double bound_95 = axes * fisher_f_quantile(0.95, axes, known_with);
  const double gross = axes * fisher_f_quantile(0.999, axes, known_with);
  constexpr size_t kPosesAtOnce = 32;
  PoseAfterPose judged(columns, std::max(1e-9, known.reading.position));
  int outside = 0;
  const auto end = poses.end();
  for (auto first = poses.begin(); first != end;) {
    std::vector<PoseError> some;
    for (; first != end && some.size() < kPosesAtOnce; ++first)
      some.push_back(std::move(first->second));
    for (double squares : judged.squares_of(some, gross)) outside += !(squares <= bound_95);
  }
  return binomial_at_least(outside, static_cast<int>(poses.size()), 0.05);
}

}  // namespace armtrue
