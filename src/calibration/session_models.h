#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/calibration/observation.h"
#include "calibration/fold.h"

namespace armtrue {

/// The readings of several sessions against one robot. Each session has its own base and, if asked
/// for, its own zero offsets. There is one ObservationModel per session, all in the R_A of
/// `robot.chain.base`, so that effects on the base act along the same axes in every session.
/// Anchors keep their places in the R_A of each session: they move with the instrument.
///
/// The unknowns x are those of the first session (the requested geometric parameters, then
/// coefficients), then the own parameters of each further session.
class SessionModels {
 public:
  /// `geometric`, `sigma`, `fitted_effects`: as for ObservationModel. The campaign is not copied
  /// unless it has several sessions: it must outlive the models.
  SessionModels(const Campaign& campaign, const Robot& robot, const std::vector<int>& geometric,
                const ReadingSigma& sigma, int fitted_effects = kAllEffects);
  SessionModels(const Campaign&& campaign, const Robot& robot, const std::vector<int>& geometric,
                const ReadingSigma& sigma, int fitted_effects = kAllEffects) = delete;
  SessionModels(const SessionModels&) = delete;  // the models refer to the campaigns held here
  SessionModels& operator=(const SessionModels&) = delete;

  int sessions() const { return static_cast<int>(models_.size()); }
  const ObservationModel& model(int session) const { return models_[session]; }
  /// Rows of the campaign that make up a session's rows.
  const std::vector<int>& rows_of(int session) const { return rows_[session]; }
  const std::string& name(int session) const { return names_[session]; }
  /// The R_A that the models share, from that of a session.
  const Pose& common_from_own(int session) const { return common_from_own_[session]; }

  /// Consecutive unknowns within x.
  struct Run {
    int first, count;
  };
  /// The runs of x that, joined, are the unknowns of one session's model. The runs of two sessions
  /// are equal or do not overlap. One run if there is only one session.
  const std::vector<Run>& runs(int session) const { return runs_[session]; }
  Eigen::VectorXd unknowns_of(int session, const Eigen::VectorXd& x) const;

  const Campaign& campaign() const { return campaign_; }
  int rows() const { return campaign_.rows(); }
  int row_size() const { return models_.front().row_size(); }
  int unknowns() const { return first_own(sessions()); }
  /// The own parameters of a session, without rotations of the base that its readings cannot
  /// observe; those of a further session stand in x from first_own(session) on.
  const std::vector<int>& own(int session) const { return own_[session]; }
  int first_own(int session) const {
    int first = models_.front().unknowns();
    for (int s = 1; s < session; ++s) first += static_cast<int>(own_[s].size());
    return first;
  }
  int geometric_count() const { return models_.front().geometric_count(); }
  const std::vector<int>& geometric() const { return models_.front().geometric(); }
  /// Indices within x of the geometric unknowns, those of all sessions included.
  std::vector<int> geometric_unknowns() const;
  int fitted_effects() const { return models_.front().fitted_effects(); }
  /// As ObservationModel; those of further sessions read `session day 2 base.x`.
  std::vector<std::string> unknown_names() const;
  double mean_square_value(int coefficient) const;

  /// The robot at x; with `sessions` if there are several.
  Robot robot_at(const Eigen::VectorXd& x) const;

  const InstrumentNoise& noise() const { return robot_.noise; }
  const ReadingSigma& sigma() const { return sigma_; }
  void set_sigma(const ReadingSigma& sigma);

  /// The law of the readings for one session's rows.
  ReadingLaw law_of(int session, const ReadingLaw& law) const;
  /// Squared norms of the whitened residuals, by row of the campaign: position, orientation.
  std::vector<Eigen::Vector2d> squared_norms(const Eigen::VectorXd& x) const;
  /// The models at one value of x, for reading rows from several threads.
  class At;
  At at(const Eigen::VectorXd& x) const;
  /// Whitened derivatives and residual of all rows at x = 0: (rows * row_size) x (unknowns + 1).
  Eigen::MatrixXd blocks() const;
  /// The factors of all sessions' folds joined: (unknowns + 1) x (unknowns + 1).
  Eigen::MatrixXd join(const std::vector<Eigen::MatrixXd>& factors) const;
  /// Their information J^T W J added up: unknowns x unknowns.
  Eigen::MatrixXd sum(const std::vector<Eigen::MatrixXd>& informations) const;

 private:
  // Copies the columns of one session's model to their places among the unknowns, the residual
  // last.
  void scatter(int session, const Eigen::Ref<const Eigen::MatrixXd>& block,
               Eigen::Ref<Eigen::MatrixXd> out) const;

  const Campaign& campaign_;
  Robot robot_;
  std::vector<std::vector<int>> own_;
  std::vector<std::string> names_;
  std::vector<std::vector<int>> rows_;
  std::vector<Pose> common_from_own_;
  std::vector<Campaign> campaigns_;  // one per session; empty if the one given will do
  std::vector<ObservationModel> models_;
  std::vector<std::vector<Run>> runs_;
  // Sigma of a model is that of its own median row, not of the campaign's: their ratio.
  std::vector<ReadingSigma> ratio_;
  ReadingSigma sigma_;
};

class SessionModels::At {
 public:
  const SessionModels& models() const { return models_; }
  /// Writes the whitened block of one row of the campaign: row_size() x (unknowns() + 1), the
  /// derivatives in the first columns, the residual in the last.
  void block(int row, Eigen::Ref<Eigen::MatrixXd> out) const;

 private:
  friend class SessionModels;
  At(const SessionModels& models, const Eigen::VectorXd& x);

  // Place of a row of the campaign in its session, if there are several.
  struct Place {
    int session, row;
  };
  const SessionModels& models_;
  std::vector<ObservationModel::At> sessions_;
  std::vector<Place> places_;
};

}  // namespace armtrue
