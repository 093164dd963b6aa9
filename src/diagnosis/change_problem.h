#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "armtrue/diagnosis/change.h"
#include "armtrue/observation/reading_law.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/distributions.h"
#include "calibration/pose_influence.h"

namespace armtrue {

/// The readings of a campaign against the previous robot, the prior knowledge of its parameters,
/// and the hypotheses of possible moves: the base, the tool, one anchor of several, each contact,
/// beam, camera and board that is read, and every identified parameter of a link. See
/// detect_change() for the model.
class ChangeProblem {
 public:
  /// An error of the previous calibration, or a move since.
  struct Unknown {
    int parameter;    ///< index
    int first, last;  ///< sessions in which it acts
    /// Prior standard deviation about zero; infinite: no prior.
    double deviation = std::numeric_limits<double>::infinity();

    bool acts_in(int session) const { return first <= session && session <= last; }
  };

  /// A hypothesis: the unknowns that move together, under one name.
  struct Hypothesis {
    std::string what;
    std::vector<Unknown> moves;
  };

  /// Sums over the poses, with c the chi-square of a pose and e its number of equations.
  struct ChiSquares {
    double c = 0, e = 0, cc = 0, ce = 0, ee = 0;

    static ChiSquares of(double c, double e) { return {c, e, c * c, c * e, e * e}; }
    void add(const ChiSquares& other) {
      c += other.c;
      e += other.e;
      cc += other.cc;
      ce += other.ce;
      ee += other.ee;
    }
  };

  struct Fit {
    Eigen::VectorXd x;  ///< errors, then moves
    // Both from the last pass over the rows, before the last, very small step.
    Eigen::MatrixXd root;         ///< L with L L^T = information^-1 of x
    std::vector<double> weights;  ///< of the rows; empty if the law is Gaussian: 1
    double loss = 0;              ///< chi-square, or twice the negative log-likelihood
    // What complete() sets.
    Eigen::MatrixXd covariance;  ///< of x, for independent readings
    Eigen::MatrixXd by_pose;     ///< the same, clustered by pose
    ChiSquares chi_squares;
  };

  /// Both must outlive the problem.
  ChangeProblem(const Robot& previous, const Campaign& campaign, const ReadingSigma& sigma);

  int hypotheses() const { return static_cast<int>(hypotheses_.size()); }
  /// Number of equations; replicates of a pose and channel count once.
  double equations() const { return equations_; }

  /// The most likely errors of the previous parameters and moves, if the hypotheses `moved` are
  /// true together: Gauss-Newton on
  ///     sum over the rows of loss(|r|^2) / replicates + sum over unknowns of (x / deviation)^2,
  /// with new weights of the rows at every step. Every step adds up the rows in blocks over the
  /// threads of the machine: memory does not grow with their derivatives.
  Fit fit(const std::vector<int>& moved, const ReadingLaw& law) const;
  /// Fall of the loss with each hypothesis, from the fit without any, in one step with the weights
  /// of that fit. The true fall is larger, because rows that the hypothesis explains gain weight.
  std::vector<double> promised_falls(const ReadingLaw& law, const Fit& nothing) const;
  /// Sets the covariances and the chi-squares, in one more pass over the rows.
  void complete(const std::vector<int>& moved, Fit& fitted) const;

  /// Mean position error of the previous robot with the fitted moves and the fitted bases of
  /// several sessions, but with the previous values of all else [m].
  double mean_error(const std::vector<int>& moved, const Fit& fitted) const;

  // The fits below are complete.

  /// One of the moves with its changes, their standard deviations and intervals.
  Move described(const std::vector<int>& moved, size_t which, const Fit& fitted) const;
  /// See ChangeResult::stations.
  std::vector<Move> stations(const Fit& fitted) const;
  /// p-value of residuals this large, by Satterthwaite's chi-square distribution: with f degrees of
  /// freedom and the overdispersion c, loss / c is chi-squared with f / c degrees of freedom.
  double p_value(const std::vector<int>& moved, const Fit& fitted, double overdispersion) const;
  /// Ratio of the variance of the poses' chi-squares to that of independent readings whose
  /// residuals are as large in the mean, so that an arm that errs everywhere does not count as one
  /// that scatters; at least 1.
  double overdispersion(const Fit& fitted) const;
  /// Mean ratio of the variances of one of the moves, clustered by pose, to those of independent
  /// readings; at least 1.
  double widening(const std::vector<int>& moved, size_t which, const Fit& fitted) const;
  int poses() const { return rows_by_pose_.groups(); }
  /// Number of unknowns of the moves.
  int moves_in(const std::vector<int>& moved) const {
    return static_cast<int>(unknowns_of(moved).size() - errors_.size());
  }

 private:
  ParameterChange change_of(int parameter, double value, double deviation) const {
    const double half_width = student_t_975(poses() - 1) * deviation;
    return {parameter, value, deviation, {value - half_width, value + half_width}};
  }
  // Index of the first unknown of one of the moves.
  Eigen::Index first_of(const std::vector<int>& moved, size_t which) const;
  int sessions() const { return models_.sessions(); }
  // Whether each session has its own value.
  bool is_own(int parameter) const { return own_bases_ && std::ranges::count(own_, parameter) > 0; }
  // By the uncertainty where the file states it: it predicts readings, and `std` may be wider, see
  // widen_deviations().
  double deviation_of(int parameter) const;
  double deviation_of(int parameter, int session) const;
  // Sums over the rows, see change_fit.cc.
  struct Sums {
    Eigen::MatrixXd products;  // [J r]^T W [J r], upper half, (unknowns + 1) x (unknowns + 1)
    double loss = 0;
  };
  struct Models;
  struct Equations;
  Sums sums_of(const std::vector<Unknown>& unknowns, const ReadingLaw& law, bool weigh,
               Fit& fitted) const;
  // The sums of the errors and of some moves, from those of all_unknowns().
  Sums part_of(const Sums& all, const std::vector<int>& moved) const;
  Eigen::MatrixXd known_of(const std::vector<Unknown>& unknowns) const;
  void count_replicates();
  void enter_errors();
  void correlate_errors();
  void enter_hypotheses();
  void enter_hypothesis(const std::string& what, const std::vector<int>& parameters, int first,
                        int last);
  std::array<bool, 2> named_by_images() const;
  void enter_contact(const std::vector<int>& parameters, int first, int last);
  std::vector<Unknown> unknowns_of(const std::vector<int>& moved) const;
  std::vector<Unknown> all_unknowns() const;  // the moves of every hypothesis
  Eigen::VectorXd unknowns_of(int session, const std::vector<Unknown>& unknowns,
                              const Eigen::VectorXd& x) const;

  const Robot& previous_;
  const bool own_bases_;  // and other own parameters
  const Robot start_;
  const std::vector<int> own_;  // of a session
  const SessionModels models_;
  std::vector<std::vector<int>> columns_;  // of each session's model, by parameter; -1: none
  std::vector<double> shares_;             // of each row in its pose and channel
  std::vector<double> session_shares_;     // of each session in its poses; 1: they are its alone
  const GroupedRows rows_by_pose_;
  std::vector<Unknown> errors_;
  Eigen::MatrixXd correlated_;  // L^-1, L L^T the covariance of errors_; empty: independent
  std::vector<Hypothesis> hypotheses_;
  std::vector<Eigen::Index> first_of_moves_;  // of each hypothesis, within all_unknowns()
  Sums at_start_;                             // of all_unknowns() at x = 0, where all fits begin
  double equations_ = 0, degrees_of_freedom_ = 0;
};

}  // namespace armtrue
