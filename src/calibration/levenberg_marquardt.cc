#include "calibration/levenberg_marquardt.h"

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace armtrue {
namespace {

// One group of rows, or the whole campaign where there is only one, as one residual block of p + 1
// residuals: with R = triangle of its fold, the last column of R and the Jacobian -R (the residual
// is measured minus model). The sum of their squares is the loss, their gradient that of the loss,
// so Levenberg-Marquardt takes the same steps as on all rows. The parameter blocks are the
// group's runs. The priors are further residuals.
//
// Under Student's t, and by normal equations, a triangle of the second derivative takes the place
// of R and of the priors where there is one: see Fold::bend.
class FoldedCost : public ceres::CostFunction {
 public:
  FoldedCost(const SessionModels& models, int group, const ReadingLaw& law,
             const std::vector<Prior>& priors, FoldBy fold_by, const KeptDerivatives* kept,
             Curvature curvature)
      : model_(models.model(group)),
        fold_by_(fold_by),
        kept_(kept),
        curvature_(curvature),
        law_(models.law_of(group, law)),
        priors_(priors) {
    for (const SessionModels::Run& run : models.runs(group))
      mutable_parameter_block_sizes()->push_back(run.count);
    const bool apart = fold_by == FoldBy::qr;  // the priors
    set_num_residuals(model_.unknowns() + 1 + (apart ? static_cast<int>(priors.size()) : 0));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const int p = model_.unknowns();
    Eigen::VectorXd x(p);
    int filled = 0;
    for (size_t b = 0; b < parameter_block_sizes().size(); ++b) {
      std::copy_n(parameters[b], parameter_block_sizes()[b], x.data() + filled);
      filled += parameter_block_sizes()[b];
    }
    const ObservationModel::At at = model_.at(x);
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r.setZero();
    Eigen::VectorXd of_priors(std::ssize(priors_));
    for (size_t k = 0; k < priors_.size(); ++k) of_priors[k] = priors_[k].residual(x);
    if (!jacobians) {
      const bool apart = fold_by_ == FoldBy::qr;
      r[p] = std::sqrt(total_loss(at, model_, law_) + (apart ? 0 : of_priors.squaredNorm()));
      if (apart) r.tail(of_priors.size()) = of_priors;
      return std::isfinite(r[p]);
    }
    const bool is_whole =
        curvature_ == Curvature::of_each_step || last_.folded.products.size() == 0;
    last_ = {x, !kept_     ? fold(at, model_, law_, fold_by_)
                : is_whole ? fold(at, model_, law_, *kept_)
                           : fold(at, model_, law_, *kept_, last_.folded)};
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(num_residuals(), p);
    if (!by_second_derivative(of_priors, r, jacobian)) by_rows(of_priors, r, jacobian);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    int taken = 0;
    for (size_t b = 0; b < parameter_block_sizes().size(); ++b) {
      const int columns = parameter_block_sizes()[b];
      if (jacobians[b])
        Eigen::Map<RowMajor>(jacobians[b], num_residuals(), columns) =
            jacobian.middleCols(taken, columns);
      taken += columns;
    }
    return std::isfinite(r[p]) && jacobian.allFinite();
  }

  GroupFold take_last_fold() { return std::move(last_); }

 private:
  // Residuals and Jacobian from the triangle of the rows.
  void by_rows(const Eigen::VectorXd& of_priors, Eigen::Map<Eigen::VectorXd>& r,
               Eigen::MatrixXd& jacobian) const {
    const int p = model_.unknowns();
    const Eigen::MatrixXd& triangle = last_.folded.factor;
    r.head(p) = triangle.col(p).head(p);
    // The part of the loss that the linear part does not explain, a constant.
    r[p] = std::sqrt(std::max(0.0, last_.folded.loss - r.head(p).squaredNorm()));
    jacobian.topRows(p) = -triangle.topLeftCorner(p, p);
    r.tail(of_priors.size()) = of_priors;
    for (int k = 0; k < std::ssize(priors_); ++k)
      jacobian(p + 1 + k, priors_[k].unknown) = 1.0 / priors_[k].deviation;
  }

  // The same from a triangle C of the second derivative, C^T C = H + priors, and from the gradient
  // g: residuals C^-T g, whose sum of squares is twice the fall that the step predicts. If that is
  // large, the solution is far and H may be wrong, so a part of `bend` is left out (without `bend`
  // the step never overshoots); likewise if H is not positive definite. False if the triangle of
  // the rows exists and is as good.
  bool by_second_derivative(const Eigen::VectorXd& of_priors, Eigen::Map<Eigen::VectorXd>& r,
                            Eigen::MatrixXd& jacobian) const {
    const int p = model_.unknowns();
    const Fold& folded = last_.folded;
    const bool has_rows = fold_by_ == FoldBy::qr;
    if (has_rows && folded.bend.size() == 0) return false;
    Eigen::MatrixXd whole = folded.information();
    Eigen::VectorXd gradient = folded.gradient();
    for (size_t k = 0; k < priors_.size(); ++k) {
      const int unknown = priors_[k].unknown;
      const double weight = 1.0 / priors_[k].deviation;
      whole(unknown, unknown) += weight * weight;
      gradient[unknown] -= weight * of_priors[k];
    }
    const double loss = folded.loss + of_priors.squaredNorm();
    r[p] = std::sqrt(loss);
    struct Part {
      double share, most;  // of `bend`; of the loss that the step may promise
    };
    for (const auto& [share, most] :
         {Part{1, 1e-3}, {0.75, 2e-3}, {0.5, 1e-2}, {0.25, 0.1}, {0, 1}}) {
      Eigen::MatrixXd second = whole;
      if (share == 0 && has_rows) return false;
      if (folded.bend.size() > 0)
        second -= share * folded.bend;
      else if (share > 0)
        continue;
      const Eigen::MatrixXd triangle = root_of(second, whole.diagonal(), share == 0);
      if (triangle.size() == 0) continue;
      const Eigen::VectorXd residual =
          triangle.transpose().triangularView<Eigen::Lower>().solve(gradient);
      if (share > 0 && !(residual.squaredNorm() <= most * loss)) continue;
      r.head(p) = residual;
      r[p] = std::sqrt(std::max(0.0, loss - residual.squaredNorm()));
      jacobian.topRows(p) = -triangle;
      return true;
    }
    return false;
  }

  // Upper triangle C with C^T C = `upper` (upper half), or empty if that is not clearly positive
  // definite. `squares`: those of the lengths of the columns. `ridge`: adds what makes it so to
  // directions that are hardly determined; they take short steps.
  static Eigen::MatrixXd root_of(const Eigen::MatrixXd& upper, const Eigen::VectorXd& squares,
                                 bool ridge) {
    constexpr double kMinPivot = 1e-5;  // of columns of unit length; less is mostly rounding
    const Eigen::VectorXd length = (squares.array() > 0).select(squares.cwiseSqrt(), 1.0);
    const Eigen::VectorXd unit = length.cwiseInverse();
    Eigen::MatrixXd scaled = unit.asDiagonal() *
                             Eigen::MatrixXd(upper.selfadjointView<Eigen::Upper>()) *
                             unit.asDiagonal();
    if (ridge) scaled.diagonal().array() += kMinPivot * kMinPivot;
    const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
    if (llt.info() != Eigen::Success) return {};
    if (!ridge && llt.matrixLLT().diagonal().minCoeff() < kMinPivot) return {};
    return Eigen::MatrixXd(llt.matrixU()) * length.asDiagonal();
  }

  const ObservationModel& model_;
  const FoldBy fold_by_;
  const KeptDerivatives* kept_;  // or null
  const Curvature curvature_;
  const ReadingLaw law_;
  const std::vector<Prior> priors_;
  // The last fold that a Jacobian was made of. Evaluate() is const for Ceres; this one is called by
  // one thread only (Solver::Options::num_threads).
  mutable GroupFold last_;
};

// The priors of the unknowns that a group is the first to have, by their places among its own.
std::vector<std::vector<Prior>> priors_by_group(const SessionModels& models,
                                                const std::vector<Prior>& priors) {
  constexpr int kNobody = -1;
  struct Place {
    int group = kNobody, place = 0;
  };
  std::vector<Place> places(models.unknowns());
  for (int g = 0; g < models.groups(); ++g) {
    int place = 0;
    for (const SessionModels::Run& run : models.runs(g))
      for (int k = run.first; k < run.first + run.count; ++k, ++place)
        if (places[k].group == kNobody) places[k] = {g, place};
  }
  std::vector<std::vector<Prior>> own(models.groups());
  for (Prior prior : priors) {
    const auto [group, place] = places[prior.unknown];
    if (group == kNobody) continue;  // no reading, and so no step, has anything to do with it
    prior.unknown = place;
    own[group].push_back(prior);
  }
  return own;
}

}  // namespace

Solution minimise(const SessionModels& models, const ReadingLaw& law,
                  const std::vector<Prior>& priors, int max_iterations, double tolerance, FoldBy by,
                  Eigen::VectorXd& x, const std::vector<KeptDerivatives>& kept,
                  Curvature curvature) {
  if (x.size() == 0)
    return {true, 0, "nothing to identify", std::vector<GroupFold>(models.groups())};
  std::vector<std::unique_ptr<FoldedCost>> costs;
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  const std::vector<std::vector<Prior>> own_priors = priors_by_group(models, priors);
  for (int g = 0; g < models.groups(); ++g) {
    std::vector<double*> blocks;
    for (const SessionModels::Run& run : models.runs(g)) blocks.push_back(x.data() + run.first);
    costs.push_back(std::make_unique<FoldedCost>(models, g, law, own_priors[g], by,
                                                 kept.empty() ? nullptr : &kept[g], curvature));
    problem.AddResidualBlock(costs.back().get(), nullptr, blocks);
  }
  ceres::Solver::Options options;
  // No group sees another's own unknowns. The normal equations need no more care than they were
  // made with.
  options.linear_solver_type = models.groups() > 1 ? ceres::SPARSE_NORMAL_CHOLESKY
                               : by == FoldBy::qr  ? ceres::DENSE_QR
                                                   : ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = tolerance;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 1e-14;
  // Nearly linear problems with nearly invisible directions: start with hardly any damping.
  options.initial_trust_region_radius = 1e8;
  options.max_trust_region_radius = 1e20;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Solution solution{summary.termination_type == ceres::CONVERGENCE,
                    std::max(0, static_cast<int>(summary.iterations.size()) - 1),
                    summary.message,
                    {}};
  for (const auto& cost : costs) solution.folds.push_back(cost->take_last_fold());
  return solution;
}

}  // namespace armtrue
