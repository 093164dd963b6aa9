#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "armtrue/observation/fold.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

/// The readings of several sessions against one robot, with a base, and zero offsets if asked for,
/// of its own in each: one ObservationModel per group, all in the R_A of `robot.chain.base`, so
/// that a compliant base moves along the same axes of the robot in every session. Anchors keep
/// their places in the own R_A of each session: they are carried with the instrument.
///
/// The unknowns x are those of the first session (geometric parameters as far as they are asked
/// for, then coefficients), then the own parameters of each further session.
///
/// A group is the rows that the same unknowns move: those of a session or, split by target, those
/// of a target in a session. The place of a target moves no reading of another one. So each group
/// has a model of few unknowns, its own and those common to all, and cost grows with the number of
/// groups, not with its square or cube.
class SessionModels {
 public:
  enum class Split { by_session, by_target };

  /// `geometric`, `sigma`, `fitted_effects`: as for ObservationModel. Split by target only where
  /// the places of targets are most of the unknowns. One session that the robot does not list is
  /// not copied; in any case the campaign must outlive the models.
  SessionModels(const Campaign& campaign, const Robot& robot, const std::vector<int>& geometric,
                const ReadingSigma& sigma, int fitted_effects = kAllEffects,
                Split split = Split::by_session);
  SessionModels(const Campaign&& campaign, const Robot& robot, const std::vector<int>& geometric,
                const ReadingSigma& sigma, int fitted_effects = kAllEffects,
                Split split = Split::by_session) = delete;
  SessionModels(const SessionModels&) = delete;  // the models refer to the campaigns held here
  SessionModels& operator=(const SessionModels&) = delete;

  int groups() const { return static_cast<int>(models_.size()); }
  bool is_split_by_target() const { return by_target_; }
  const ObservationModel& model(int group) const { return models_[group]; }
  /// Rows of the campaign that make up a group's rows.
  const std::vector<int>& rows_of(int group) const { return rows_[group]; }
  int session_of(int group) const { return session_of_[group]; }
  /// The robot's target of a group; -1 if not split by target.
  int target_of(int group) const { return target_of_[group]; }
  /// Number of sessions; if not split by target, the groups are the sessions.
  int sessions() const { return static_cast<int>(names_.size()); }
  const std::string& name(int session) const { return names_[session]; }
  /// The R_A that the models share, from that of a session.
  const Pose& common_from_own(int session) const { return common_from_own_[session]; }

  /// Consecutive unknowns within x.
  struct Run {
    int first, count;
  };
  /// The runs of x that, joined, are the unknowns of one group's model. The runs of two groups are
  /// equal or do not overlap. One run if there is only one group.
  const std::vector<Run>& runs(int group) const { return runs_[group]; }
  Eigen::VectorXd unknowns_of(int group, const Eigen::VectorXd& x) const;
  /// All unknowns, divided by the groups that have them: those of one session, the place of one
  /// target, those common to all.
  std::vector<std::vector<Eigen::Index>> unknowns_by_groups() const;
  /// For each unknown of a group's model that of the first session in its place: itself, or, of the
  /// own parameters of a further session, the same parameter; -1 where the first has none.
  std::vector<int> in_first_session(int group) const;

  const Campaign& campaign() const { return campaign_; }
  int rows() const { return campaign_.rows(); }
  int row_size() const { return models_.front().row_size(); }
  int unknowns() const { return first_own(sessions()); }
  /// The own parameters of a session, without rotations of the base that its readings cannot
  /// observe; those of a further session stand in x from first_own(session) on.
  const std::vector<int>& own(int session) const { return own_[session]; }
  int first_own(int session) const {
    const ObservationModel& any = models_.front();
    int first = geometric_count() + any.unknowns() - any.geometric_count();
    for (int s = 1; s < session; ++s) first += static_cast<int>(own_[s].size());
    return first;
  }
  int geometric_count() const { return static_cast<int>(geometric_.size()); }
  const std::vector<int>& geometric() const { return geometric_; }
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

  /// The law of the readings, with the variances of one group's rows.
  ReadingLaw law_of(int group, const ReadingLaw& law) const;
  /// Squared norms of the whitened residuals, by row of the campaign: position, orientation.
  std::vector<Eigen::Vector2d> squared_norms(const Eigen::VectorXd& x) const;
  /// The models at one value of x, for reading rows from several threads.
  class At;
  At at(const Eigen::VectorXd& x) const;
  /// Whitened derivatives and residual of all rows at x = 0: (rows * row_size) x (unknowns + 1).
  Eigen::MatrixXd blocks() const;
  /// The factors of all groups' folds joined: (unknowns + 1) x (unknowns + 1).
  Eigen::MatrixXd join(const std::vector<Eigen::MatrixXd>& factors) const;

 private:
  void find_groups(Split split);
  Campaign readings_of(int group) const;
  void enter_model(int group, const Robot& alone, const Campaign& readings,
                   const ReadingSigma& sigma, int fitted_effects);
  void find_runs();
  // Copies the columns of one group's model to the columns of its unknowns in x; the residual stays
  // the last one.
  void scatter(int group, const Eigen::Ref<const Eigen::MatrixXd>& block,
               Eigen::Ref<Eigen::MatrixXd> out) const;

  const Campaign& campaign_;
  Robot robot_;
  std::vector<int> geometric_;
  // Of each session.
  std::vector<std::vector<int>> own_;
  std::vector<std::string> names_;
  std::vector<Pose> common_from_own_;
  // Of each group.
  bool by_target_ = false;
  // Whether the robot of a model has its target alone: copies of hundreds of targets for each of
  // hundreds of groups take a third of the time. Not where an effect moves a target.
  bool has_one_target_each_ = false;
  std::vector<std::vector<int>> rows_;
  std::vector<int> session_of_, target_of_;
  std::vector<Campaign> campaigns_;  // empty if the one given will do
  std::vector<ObservationModel> models_;
  std::vector<std::vector<Run>> runs_;
  // Sigma of a model is that of its own median row, not of the campaign's: their ratio.
  std::vector<ReadingSigma> ratio_;
  ReadingSigma sigma_;
};

class SessionModels::At {
 public:
  const SessionModels& models() const { return models_; }
  int group_of(int row) const { return places_.empty() ? 0 : places_[row].group; }
  /// As block(), with the columns of the row's group alone: row_size() x (model(group).unknowns() +
  /// 1).
  void own_block(int row, Eigen::Ref<Eigen::MatrixXd> out) const {
    groups_[group_of(row)].block(places_.empty() ? row : places_[row].row, out);
  }
  /// Writes the whitened block of one row of the campaign: row_size() x (unknowns() + 1), the
  /// derivatives in the first columns, the residual in the last.
  void block(int row, Eigen::Ref<Eigen::MatrixXd> out) const;
  /// Some rows of the campaign, those of one prediction together (ObservationModel::
  /// rows_by_prediction), in the order of the first of each.
  std::vector<std::vector<int>> replicates_among(std::span<const int> rows) const;
  /// The whitened residual of one row of the campaign.
  NumbersOfRow residual(int row) const {
    const int group = group_of(row), own = places_.empty() ? row : places_[row].row;
    return models_.model(group).whitened(own, groups_[group].residual(own));
  }

 private:
  friend class SessionModels;
  At(const SessionModels& models, const Eigen::VectorXd& x);

  // Where a row of the campaign stands, if there are several groups.
  struct Place {
    int group, row;
  };
  const SessionModels& models_;
  std::vector<ObservationModel::At> groups_;
  std::vector<Place> places_;
};

}  // namespace armtrue
