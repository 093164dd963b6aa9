#include "search/linearization.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/session_models.h"
#include "calibration/pose_influence.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kMinPivot = 1e-9;  // columns have unit length; a smaller pivot is rounding
// The relative error of a pivot p of a Gram matrix is 1e-16 / p.
constexpr double kMinClearPivot = 1e-5;
// Squared share of a direction that other columns have as well. With less they would have to move
// the readings a thousand times as far to take its place.
constexpr double kMinShared = 1e-6;
// A parameter is named as refitted if it moves the readings by at least this share of the effect.
constexpr double kMinShareOfRefit = 0.1;
constexpr int kNone = -1;  // no row, or no column
// A column that moves the readings by less than this beside all others, as a multiple of the noise
// of one of them, is not seen, though its coefficient be the largest that is possible.
constexpr double kUnseen = 0.01;

// Scales each column to unit length; a zero column stays zero.
Eigen::MatrixXd normalized(Eigen::MatrixXd columns) {
  for (int k = 0; k < columns.cols(); ++k) columns.col(k).normalize();
  return columns;
}

// An orthonormal basis of some columns, and the columns in its coordinates.
struct Basis {
  Eigen::MatrixXd vectors, columns;
};

bool are_clearly_independent(const Eigen::LLT<Eigen::MatrixXd>& llt) {
  return llt.info() == Eigen::Success &&
         (llt.cols() == 0 || llt.matrixLLT().diagonal().minCoeff() >= kMinClearPivot);
}

// Numbers of columns of unit length: those that are clearly independent of each other, and the
// others.
struct Columns {
  std::vector<Eigen::Index> clear, others;
};

// By Cholesky's factor L of their Gram matrix. Its next column is that with most left beside those
// before. (Eigen's LDLT takes them in another order, by what they have on the diagonal at first, so
// that small pivots come early and spoil what follows.)
Columns sorted_out(const Eigen::MatrixXd& gram) {
  const Eigen::Index count = gram.cols();
  std::vector<Eigen::Index> all(count);
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  if (are_clearly_independent(Eigen::LLT<Eigen::MatrixXd>(gram))) return {all, {}};
  Columns columns;
  Eigen::MatrixXd l(count, count);
  Eigen::VectorXd left = gram.diagonal();  // of the squared length of each
  for (Eigen::Index rank = 0; rank < count; ++rank) {
    Eigen::Index next = 0;
    if (left.maxCoeff(&next) < kMinClearPivot * kMinClearPivot) break;
    auto own = l.col(rank);
    own = gram.col(next) - l.leftCols(rank) * l.row(next).head(rank).transpose();
    own /= std::sqrt(left[next]);
    left -= own.cwiseAbs2();
    left[next] = 0;
    columns.clear.push_back(next);
  }
  std::ranges::copy_if(all, std::back_inserter(columns.others), [&](Eigen::Index k) {
    return std::ranges::find(columns.clear, k) == columns.clear.end();
  });
  return columns;
}

constexpr int kEquationsPerBlock = 2048;  // of a task; a product of fewer is as fast by itself

Eigen::MatrixXd gram_of(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  for_ordered_blocks<Eigen::MatrixXd>(
      static_cast<int>(columns.rows()), kEquationsPerBlock,
      [&](int begin, int end) {
        Eigen::MatrixXd own = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
        own.selfadjointView<Eigen::Lower>().rankUpdate(
            columns.middleRows(begin, end - begin).transpose());
        return own;
      },
      [&](const Eigen::MatrixXd& own) { gram += own; });
  return gram.selfadjointView<Eigen::Lower>();
}

// columns U^-1.
void divide_by(const Eigen::LLT<Eigen::MatrixXd>& llt, Eigen::MatrixXd& columns) {
  for_ordered_blocks<int>(
      static_cast<int>(columns.rows()), kEquationsPerBlock,
      [&](int begin, int end) {
        auto own = columns.middleRows(begin, end - begin);
        llt.matrixU().solveInPlace<Eigen::OnTheRight>(own);
        return 0;
      },
      [](int) {});
}

// By reflections. Leaves out columns that depend on the others.
Basis basis_by_reflections(const Eigen::MatrixXd& columns) {
  // A blocked QR first reduces the tall columns to a triangle, which is several times faster.
  const Eigen::HouseholderQR<Eigen::MatrixXd> tall(columns);
  const Eigen::Index p = std::min(columns.rows(), columns.cols());
  const Eigen::MatrixXd triangle = tall.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> small(triangle);
  const auto rank = (small.matrixQR().diagonal().array().abs() > kMinPivot).count();
  Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(columns.rows(), rank);
  if (rank == 0) return {chosen, Eigen::MatrixXd(0, columns.cols())};
  chosen.topRows(p) = first_columns(small.householderQ(), rank);
  return {product(tall.householderQ(), chosen), chosen.topRows(p).transpose() * triangle};
}

// An orthonormal basis of the part of columns that is orthogonal to a given basis.
Eigen::MatrixXd basis_beside(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& columns) {
  const Eigen::MatrixXd rests = columns - basis * (basis.transpose() * columns);
  std::vector<Eigen::Index> other;
  for (Eigen::Index k = 0; k < rests.cols(); ++k)
    if (rests.col(k).norm() > kMinPivot) other.push_back(k);
  if (other.empty()) return Eigen::MatrixXd(basis.rows(), 0);
  Eigen::MatrixXd own = basis_by_reflections(rests(Eigen::all, other)).vectors;
  own -= basis * (basis.transpose() * own);  // the first difference was small, and has lost digits
  divide_by(Eigen::LLT<Eigen::MatrixXd>(gram_of(own)), own);
  return own;
}

// By Cholesky's factor of the Gram matrix, twice: the second time takes off what the squared
// condition of the first leaves (CholeskyQR2; Yamamoto and others 2015, ETNA 44). Half the time of
// reflections, by which the few columns that are not clearly independent of the others follow.
// Nothing if the factor does not exist.
std::optional<Basis> basis_by_gram(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd gram = gram_of(columns);
  const auto& [clear, others] = sorted_out(gram);
  const Eigen::Index rank = std::ssize(clear);
  gram = gram(clear, clear).eval();
  Basis of_clear{columns(Eigen::all, clear), Eigen::MatrixXd::Identity(rank, rank)};
  for (int pass = 0; pass < 2; ++pass) {
    if (pass > 0) gram = gram_of(of_clear.vectors);
    const Eigen::LLT<Eigen::MatrixXd> llt(gram);
    if (!are_clearly_independent(llt)) return std::nullopt;
    divide_by(llt, of_clear.vectors);
    of_clear.columns = llt.matrixU() * of_clear.columns;
  }
  if (others.empty()) return of_clear;
  const Eigen::MatrixXd unclear = columns(Eigen::all, others);
  const Eigen::MatrixXd own = basis_beside(of_clear.vectors, unclear);
  Basis basis{Eigen::MatrixXd(columns.rows(), rank + own.cols()),
              Eigen::MatrixXd::Zero(rank + own.cols(), columns.cols())};
  basis.vectors << of_clear.vectors, own;
  basis.columns.topRows(rank)(Eigen::all, clear) = of_clear.columns;
  basis.columns(Eigen::all, others) = basis.vectors.transpose() * unclear;
  return basis;
}

// Leaves out columns that depend on the others.
Basis orthonormal_basis(const Eigen::MatrixXd& columns) {
  if (auto basis = basis_by_gram(columns)) return std::move(*basis);
  return basis_by_reflections(columns);
}

// Whitens and weights the derivatives and the readings of a fit.
LinearProblem linear_problem(const CalibrationResult& fit, const Campaign& campaign) {
  LinearProblem problem;
  std::vector<int> all(parameter_count(fit.robot.chain));
  std::iota(all.begin(), all.end(), 0);
  const SessionModels models(campaign, fit.robot, all, fit.sigma);
  RowsOfReplicates rows = rows_of_replicates(models, fit.weights);
  problem.replicates = std::move(rows.replicates);
  const int size = problem.row_size = models.row_size();
  const std::vector<int> pose = campaign.pose_by_id();
  for (int reading : rows.nearest) problem.pose.push_back(pose[reading]);
  const Eigen::MatrixXd& blocks = rows.blocks;
  problem.jacobian = blocks.leftCols(all.size());
  // The fit has columns for each session, but an effect moves its parameter in all sessions.
  std::vector<int> row_of_nearest(campaign.rows(), kNone);
  for (size_t row = 0; row < rows.nearest.size(); ++row)
    row_of_nearest[rows.nearest[row]] = static_cast<int>(row);
  for (int s = 1; s < models.sessions(); ++s) {
    const ObservationModel& own = models.model(s);
    const ObservationModel model(own.campaign(),
                                 own.robot_at(Eigen::VectorXd::Zero(own.unknowns())), all,
                                 own.sigma(), 0, models.common_from_own(s));
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(size, model.unknowns() + 1);
    for (int i = 0; i < model.rows(); ++i) {
      const int row = row_of_nearest[models.rows_of(s)[i]];
      if (row == kNone) continue;
      at.block(i, block);
      problem.jacobian.middleRows(row * size, size) = rows.length[row] * block.leftCols(all.size());
    }
  }

  problem.geometric = static_cast<int>(fit.set.kept.size());
  const int others = models.unknowns() - static_cast<int>(all.size());
  problem.fitted.resize(blocks.rows(), problem.geometric + others);
  problem.fitted << blocks(Eigen::all, fit.set.kept), blocks.middleCols(all.size(), others);
  problem.readings = blocks.rightCols<1>();
  for (const Effect& effect : fit.robot.effects) {
    std::vector<double>& values = problem.coefficients_of_effect.emplace_back();
    for (const Coefficient& coefficient : effect.coefficients) {
      values.push_back(coefficient.value);
      const double square = models.mean_square_value(static_cast<int>(problem.most.size()));
      problem.most.push_back(square > 0 ? kMaxVariation / std::sqrt(square) : 0);
    }
  }
  problem.mean_psi_derivative = mean_psi_derivative(fit.weights, fit.degrees_of_freedom, size);
  return problem;
}

// Design effect deff (Kish, "Survey Sampling", 1965): the number of readings that are worth one
// independent reading. All readings of a pose share the error of the model at that pose, which is a
// small motion of the measured frame: d numbers, of which a point shows three, an image six, and a
// touch one. Of n equations in all, D = sum d are shared and n - D are not. With the mean squares
// MS of both, by an analysis of variance of the position residuals,
//     deff = MS_shared / mean square of all = n MS_shared / (D MS_shared + (n - D) MS_others).
// The unknowns follow the shared parts, so they reduce their degrees of freedom.
double estimate_design_effect(const Linearization& problem, Eigen::Index tool,
                              const ReadingSize& size) {
  const GroupedRows poses = grouped_rows(problem.pose());
  double of_shared = 0, shared = 0;
  for (int pose = 0; pose < poses.groups(); ++pose) {
    const int first = poses.first[pose], count = poses.first[pose + 1] - first;
    Eigen::MatrixXd motion(count * size.position, kParametersPerPose);
    Eigen::VectorXd residual(count * size.position);
    for (int k = 0; k < count; ++k) {
      const int from = poses.row[first + k] * problem.row_size(), to = k * size.position;
      motion.middleRows(to, size.position) =
          problem.jacobian().block(from, tool, size.position, kParametersPerPose);
      residual.segment(to, size.position) = problem.residual().segment(from, size.position);
    }
    const Eigen::MatrixXd span =
        basis_by_reflections(motion / std::max(motion.norm(), kMinPivot)).vectors;
    of_shared += (span.transpose() * residual).squaredNorm();
    shared += static_cast<double>(span.cols());
  }
  double squares = problem.replicates().rest.topRows(size.position).squaredNorm();
  for (int row = 0; row < problem.rows(); ++row)
    squares += problem.residual().segment(row * problem.row_size(), size.position).squaredNorm();
  const double others = size.position * problem.replicates().readings() - shared;
  const double freedom =
      shared - size.share_of_position() * static_cast<double>(problem.basis().cols());
  if (others < 1 || freedom < 1 || !(squares > of_shared)) return 1.0;
  const double mean_shared = of_shared / freedom, mean_others = (squares - of_shared) / others;
  return std::max(1.0,
                  (shared + others) * mean_shared / (shared * mean_shared + others * mean_others));
}

}  // namespace

Linearization::Linearization(LinearProblem problem)
    : row_size_(problem.row_size),
      pose_(std::move(problem.pose)),
      replicates_(problem.replicates.reading.empty()
                      ? Replicates::none(static_cast<int>(pose_.size()), row_size_)
                      : std::move(problem.replicates)),
      jacobian_(std::move(problem.jacobian)),
      mean_psi_derivative_(problem.mean_psi_derivative) {
  const Eigen::VectorXd length = problem.fitted.colwise().norm();
  Eigen::MatrixXd columns = normalized(std::move(problem.fitted));
  std::vector<std::pair<Eigen::Index, Eigen::VectorXd>> unseen;
  for (;;) {
    Basis basis = orthonormal_basis(columns);
    basis_ = std::move(basis.vectors);
    fitted_ = std::move(basis.columns);
    set_duals();
    const Eigen::Index column = unseen_column(problem, length);
    if (column == kNone) break;
    unseen.emplace_back(column, columns.col(column));
    columns.col(column).setZero();
  }
  Eigen::MatrixXd coordinates = fitted_;
  for (const auto& [column, values] : unseen) coordinates.col(column) = basis_.transpose() * values;
  explained_ = basis_.transpose() * problem.readings;
  residual_ = problem.readings - basis_ * explained_;
  residual_norm_ = residual_.squaredNorm() + replicates_.rest.squaredNorm();

  int column = problem.geometric;
  for (const std::vector<double>& coefficients : problem.coefficients_of_effect) {
    first_effect_column_.push_back(column);
    Eigen::VectorXd contribution = Eigen::VectorXd::Zero(basis_.cols());
    for (double coefficient : coefficients) {
      contribution += coordinates.col(column) * (length[column] * coefficient);
      ++column;
    }
    contribution_.push_back(contribution);
  }
  first_effect_column_.push_back(column);
}

Linearization::Linearization(const CalibrationResult& fit, const Campaign& campaign)
    : Linearization(linear_problem(fit, campaign)) {
  design_effect_ =
      estimate_design_effect(*this, layout_of(fit.robot.chain).tool, campaign.reading_size());
}

// With the decomposition fitted^T = turn * triangle the duals are triangle^-1 turn^T. Where no
// column depends on the others, Cholesky's factor is a triangle already.
void Linearization::set_duals() {
  const Eigen::Index rank = fitted_.rows(), count = fitted_.cols();
  if (rank == count && fitted_.isUpperTriangular(0)) {
    duals_ = Eigen::MatrixXd::Identity(rank, rank);
    fitted_.transpose().triangularView<Eigen::Lower>().solveInPlace(duals_);
    return;
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(fitted_.transpose());
  duals_ = first_columns(qr.householderQ(), rank).transpose();
  if (rank < count) turn_ = duals_;
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(rank);
  triangle.triangularView<Eigen::Upper>().solveInPlace(duals_);
}

// The least seen column of an effect, if it is not seen. A driver that takes no notice of effects
// makes such columns: the length of a wire grows as all lengths of the arm do, but for what the
// other effects add to it, which is their own column a hundred thousand times smaller. Left in, it
// would take their place, with an impossible coefficient.
Eigen::Index Linearization::unseen_column(const LinearProblem& problem,
                                          const Eigen::VectorXd& length) const {
  Eigen::Index least_seen = kNone;
  double least = kUnseen;
  for (Eigen::Index k = 0; k < std::ssize(problem.most); ++k) {
    const Eigen::Index column = problem.geometric + k;
    const double dual = duals_.col(column).norm();  // of what is beside all others, 1 / length
    const double seen = problem.most[k] * length[column] / dual;
    if (fitted_.col(column).isZero() || !(seen < least)) continue;
    least = seen;
    least_seen = column;
  }
  return least_seen;
}

// Decomposes the fitted columns without those of some effects.
Eigen::ColPivHouseholderQR<Eigen::MatrixXd> Linearization::all_but(
    const std::vector<int>& effects) const {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index column = 0; column < fitted_.cols(); ++column)
    if (std::none_of(effects.begin(), effects.end(), [&](int effect) {
          return column >= first_effect_column_[effect] &&
                 column < first_effect_column_[effect + 1];
        }))
      columns.push_back(column);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fitted_(Eigen::all, columns));
  qr.setThreshold(kMinPivot);
  return qr;
}

double Linearization::standard_deviation(const Eigen::VectorXd& column) const {
  const Eigen::VectorXd beside = column - basis_ * (basis_.transpose() * column);
  const double length = std::max(beside.norm(), kMinPivot * column.norm());
  const GroupedRows rows = grouped_rows(pose_);
  const Eigen::Index rank = basis_.cols();
  InfluenceSums sums;
  for (int pose = 0; pose < rows.groups(); ++pose) {
    const int first = rows.first[pose], count = rows.first[pose + 1] - first;
    Eigen::MatrixXd shown(count * row_size_, rank + 1);
    Eigen::VectorXd residual(count * row_size_);
    for (int k = 0; k < count; ++k) {
      const int from = rows.row[first + k] * row_size_, to = k * row_size_;
      shown.middleRows(to, row_size_) << basis_.middleRows(from, row_size_),
          beside.segment(from, row_size_) / length;
      residual.segment(to, row_size_) = residual_.segment(from, row_size_);
    }
    sums.add(influence_of_pose(shown, residual));
  }
  const double freedom = static_cast<double>(replicates_.rest.size() - basis_.cols() - 1);
  const double variance = residual_norm_ / std::max(1.0, freedom);
  return std::sqrt(sums.covariance(mean_psi_derivative_, variance)(rank, rank)) / length;
}

// The span of some columns alone is orthogonal to all other columns. It is the span of their duals
// D if no column depends on others, else the D z with z = H z, H = turn^T turn of these columns.
Eigen::MatrixXd Linearization::only_by(const std::vector<int>& effects) const {
  std::vector<Eigen::Index> columns;
  for (int effect : effects)
    for (int k = first_effect_column_[effect]; k < first_effect_column_[effect + 1]; ++k)
      columns.push_back(k);
  Eigen::MatrixXd span = duals_(Eigen::all, columns);
  if (turn_.size() > 0 && !columns.empty()) {
    const Eigen::MatrixXd own = turn_(Eigen::all, columns);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
        Eigen::MatrixXd(own.transpose() * own)};
    const auto count = (eigen.eigenvalues().array() > 1 - kMinShared).count();
    span *= eigen.eigenvectors().rightCols(count).eval();
  }
  const Eigen::Index count = span.cols();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(normalized(std::move(span)));
  return first_columns(qr.householderQ(), count);
}

Linearization::Loss Linearization::without(const std::vector<int>& effects) const {
  Loss loss;
  loss.span = only_by(effects);
  Eigen::VectorXd readings = explained_;
  for (int effect : effects) readings += contribution_[effect];
  loss.residual = loss.span.transpose() * readings;
  return loss;
}

BesideTheRest Linearization::effects_from(int first) const {
  std::vector<int> effects(contribution_.size() - first);
  std::iota(effects.begin(), effects.end(), first);
  const Loss loss = without(effects);
  BesideTheRest beside;
  for (int e : effects) {
    const int begin = first_effect_column_[e], count = first_effect_column_[e + 1] - begin;
    beside.columns.push_back(loss.span.transpose() * fitted_.middleCols(begin, count));
  }
  beside.readings = loss.residual;
  beside.span = basis_ * loss.span;
  beside.residual = residual_;
  beside.pose = pose_;
  beside.row_size = row_size_;
  return beside;
}

std::vector<int> Linearization::most_refitted(int effect, const Eigen::VectorXd& imitation,
                                              int count) const {
  const Eigen::VectorXd moved = all_but({effect}).solve(
      Eigen::VectorXd(basis_.transpose() * imitation - contribution_[effect]));
  std::vector<int> order;
  for (int k = 0; k < first_effect_column_.front(); ++k)
    if (std::abs(moved[k]) > kMinShareOfRefit * contribution_[effect].norm()) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(moved[a]) > std::abs(moved[b]); });
  order.resize(std::min(order.size(), static_cast<size_t>(count)));
  return order;
}

}  // namespace armtrue
