#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/identification/observation.h"
#include "fold.h"

namespace armtrue {

/// The rows of each session, in the order of the file; sessions without rows are left out. All rows
/// where the campaign names no sessions.
std::vector<std::vector<int>> rows_by_session(const Campaign& campaign);

/// About `count` rows, evenly chosen, and of every session enough to place its base.
std::vector<int> thinned_rows(const Campaign& campaign, int count);

/// The robot where it stood at one row: its base is that of the row's session, or as it is if the
/// robot does not know the session.
Robot robot_at_row(const Robot& robot, const Campaign& campaign, int row);

/// Throws std::invalid_argument if the rows are of more than one session.
void require_one_session(const Campaign& training, const Campaign& held_out = {});

/// The readings of several sessions against one robot, with a base of its own in each: one
/// ObservationModel per session.
///
/// The unknowns x are those of the first session (geometric parameters, its base among them as far
/// as they are asked for, then coefficients), then the six of the base of each further session.
class SessionModels {
 public:
  /// `geometric`: as for ObservationModel, those of the base first.
  SessionModels(const Campaign& campaign, const Robot& robot, const std::vector<int>& geometric,
                const ReadingScale& scale, bool fit_effects = true);
  SessionModels(const SessionModels&) = delete;  // the models refer to the campaigns held here
  SessionModels& operator=(const SessionModels&) = delete;

  int sessions() const { return static_cast<int>(models_.size()); }
  const ObservationModel& model(int session) const { return models_[session]; }
  /// Rows of the campaign that make up a session's rows.
  const std::vector<int>& rows_of(int session) const { return rows_[session]; }
  const std::string& name(int session) const { return names_[session]; }

  /// A run of unknowns within x.
  struct Run {
    int first, count;
  };
  /// The runs of x that, joined, are the unknowns of one session's model: its base, then what is
  /// common to all. One run where there is only one session.
  const std::vector<Run>& runs(int session) const { return runs_[session]; }
  Eigen::VectorXd unknowns_of(int session, const Eigen::VectorXd& x) const;

  const Campaign& campaign() const { return campaign_; }
  int rows() const { return campaign_.rows(); }
  int row_size() const { return models_.front().row_size(); }
  int unknowns() const { return models_.front().unknowns() + 6 * (sessions() - 1); }
  int geometric_count() const { return models_.front().geometric_count(); }
  const std::vector<int>& geometric() const { return models_.front().geometric(); }
  /// Indices within x of the geometric unknowns, the bases of all sessions included.
  std::vector<int> geometric_unknowns() const;
  bool fits_effects() const { return models_.front().fits_effects(); }
  /// As ObservationModel; those of further sessions read `session day 2 base.x`.
  std::vector<std::string> unknown_names() const;
  double mean_square_value(int coefficient) const;

  /// The robot at x; with `sessions` if there are several.
  Robot robot_at(const Eigen::VectorXd& x) const;

  const ReadingScale& scale() const { return scale_; }
  void set_scale(const ReadingScale& scale);

  /// The law of the readings for one session's rows.
  ReadingLaw law_of(int session, const ReadingLaw& law) const;
  /// Squared norms of the whitened residuals, by row of the campaign: position, orientation.
  std::vector<Eigen::Vector2d> squared_norms(const Eigen::VectorXd& x) const;
  /// Whitened derivatives and residual of all rows at x = 0: (rows * row_size) x (unknowns + 1).
  Eigen::MatrixXd blocks() const;
  /// The factors of all sessions' folds joined: (unknowns + 1) x (unknowns + 1).
  Eigen::MatrixXd join(const std::vector<Eigen::MatrixXd>& factors) const;

 private:
  const Campaign& campaign_;
  Robot robot_;
  std::vector<std::string> names_;
  std::vector<std::vector<int>> rows_;
  std::vector<Campaign> campaigns_;  // one per session; empty if there is only one
  std::vector<ObservationModel> models_;
  std::vector<std::vector<Run>> runs_;
  std::vector<ReadingScale>
      ratio_;  // a model's scale is about its own median row, not the campaign's
  ReadingScale scale_;
};

}  // namespace armtrue
