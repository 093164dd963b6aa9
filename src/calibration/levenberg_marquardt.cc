#include "calibration/levenberg_marquardt.h"

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>

namespace armtrue {
namespace {

// One session, or the whole campaign where there is only one, as one residual block of p + 1
// residuals: with R = factor of its fold, the last column of R and the Jacobian -R (the residual is
// measured minus model). The sum of their squares is the loss, their gradient that of the loss, so
// Levenberg-Marquardt takes the same steps as on all rows. The parameter blocks are the session's
// runs. The priors are further residuals.
class FoldedCost : public ceres::CostFunction {
 public:
  FoldedCost(const SessionModels& models, int session, const ReadingLaw& law,
             const std::vector<Prior>& priors, FoldBy fold_by)
      : model_(models.model(session)),
        fold_by_(fold_by),
        law_(models.law_of(session, law)),
        priors_(priors) {
    for (const SessionModels::Run& run : models.runs(session))
      mutable_parameter_block_sizes()->push_back(run.count);
    set_num_residuals(model_.unknowns() + 1 + static_cast<int>(priors.size()));
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
    for (size_t k = 0; k < priors_.size(); ++k)
      r[p + 1 + static_cast<int>(k)] = priors_[k].residual(x);
    if (!jacobians) {
      r[p] = std::sqrt(total_loss(at, model_, law_));
      return std::isfinite(r[p]);
    }
    last_ = {x, model_.sigma(), law_, fold(at, model_, law_, fold_by_)};
    const Fold& folded = last_.folded;
    r.head(p) = folded.factor.col(p).head(p);
    // What the linear part does not explain; no unknown moves it.
    r[p] = std::sqrt(std::max(0.0, folded.loss - r.head(p).squaredNorm()));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(num_residuals(), p);
    jacobian.topRows(p) = -folded.factor.topLeftCorner(p, p);
    for (size_t k = 0; k < priors_.size(); ++k)
      jacobian(p + 1 + static_cast<int>(k), priors_[k].unknown) = 1.0 / priors_[k].deviation;
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

  const SessionFold& last_fold() const { return last_; }

 private:
  const ObservationModel& model_;
  const FoldBy fold_by_;
  const ReadingLaw law_;
  const std::vector<Prior> priors_;
  // The last fold that a Jacobian was made of. Evaluate() is const for Ceres; this one is called by
  // one thread only (Solver::Options::num_threads).
  mutable SessionFold last_;
};

// The priors of the unknowns that a session is the first to have, by their places among its own.
std::vector<Prior> priors_of_session(const SessionModels& models, int session,
                                     const std::vector<Prior>& priors) {
  const int begin = session == 0 ? 0 : models.first_own(session);
  const int end = models.first_own(session + 1);
  std::vector<Prior> own;
  for (Prior prior : priors) {
    if (prior.unknown < begin || prior.unknown >= end) continue;
    int place = 0;
    for (const SessionModels::Run& run : models.runs(session)) {
      if (prior.unknown >= run.first && prior.unknown < run.first + run.count) {
        prior.unknown += place - run.first;
        break;
      }
      place += run.count;
    }
    own.push_back(prior);
  }
  return own;
}

}  // namespace

Solution minimise(const SessionModels& models, const ReadingLaw& law,
                  const std::vector<Prior>& priors, int max_iterations, double tolerance, FoldBy by,
                  Eigen::VectorXd& x) {
  if (x.size() == 0)
    return {true, 0, "nothing to identify", std::vector<SessionFold>(models.sessions())};
  std::vector<std::unique_ptr<FoldedCost>> costs;
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (int s = 0; s < models.sessions(); ++s) {
    std::vector<double*> blocks;
    for (const SessionModels::Run& run : models.runs(s)) blocks.push_back(x.data() + run.first);
    costs.push_back(
        std::make_unique<FoldedCost>(models, s, law, priors_of_session(models, s, priors), by));
    problem.AddResidualBlock(costs.back().get(), nullptr, blocks);
  }
  ceres::Solver::Options options;
  // No session sees another's base.
  options.linear_solver_type =
      models.sessions() == 1 ? ceres::DENSE_QR : ceres::SPARSE_NORMAL_CHOLESKY;
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
  for (const auto& cost : costs) solution.folds.push_back(cost->last_fold());
  return solution;
}

}  // namespace armtrue
