#pragma once

#include <array>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

/// Below this p-value a calibration does not hold, and a move is significant.
inline constexpr double kChangeSignificance = 0.01;

/// If more than this share of the rows look like blunders, none is one.
inline constexpr double kMaxBlunders = 0.3;

/// The change of one parameter by a move.
struct ParameterChange {
  int parameter;  ///< index
  double value;   ///< [SI]
  double std;     ///< of `value`; contains the standard deviations of the previous calibration
  std::array<double, 2> ci95;
};

/// Something that has moved: one identified parameter of a link, `base` (the tracker moved or was
/// knocked), `anchor <name>` (one of several), `tool` (the tool or its targets were mounted again),
/// or `contact`, `beam`, `camera` or `board` with its name.
struct Move {
  std::string what;
  std::vector<std::string> sessions;     ///< sessions in which it has moved; empty: all
  std::vector<ParameterChange> changes;  ///< one; for base, tool and anchor all that are observable
  double delta_bic = 0;                  ///< fall of BIC by the move
  double p_value = 1;       ///< of the fall of chi-square, times the number of hypotheses
  double p_value_left = 1;  ///< of the residuals with all moves in the model, this one included
  /// Other moves that explain these readings as well in its place; best first.
  std::vector<Move> indistinguishable;
};

/// The result of detect_change().
struct ChangeResult {
  bool holds = true;
  double p_value = 1;         ///< of the hypothesis that nothing has moved; see detect_change()
  ReadingSigma sigma;         ///< standard deviation of the readings that the test used, per axis
  /// How many times that of the previous calibration the replicates scatter, where that is no
  /// chance (p < 0.001) and matters (1.5 times); else 1.
  double noisier = 1;
  std::vector<int> blunders;  ///< rows, left out of the test
  /// The moves that together explain the readings, in the order of discovery. Empty if the
  /// calibration holds or no move explains the residuals.
  std::vector<Move> moved;
  double p_value_left = 1;  ///< of the residuals with these moves in the model
  /// With several sessions: bases that the previous robot knows and that have moved.
  std::vector<Move> stations;
  double before = 0, after = 0;  ///< mean position error without and with the moves [m]
};

/// Tests whether a calibration still holds on a few new poses and, if not, finds which parameters
/// have moved.
///
/// Model. The new residuals against the previous robot, with its effects unchanged, are
///     r = J x + e.
/// x: the errors of the previous parameters, normal with the standard deviations of
/// `previous.uncertainty`, without it of `previous.std`, and taken as independent of each other
/// (strong correlations only make the test more cautious). e: normal with the `spread` that the
/// previous calibration left, or with the scatter of the new replicates if that is larger; without
/// replicates, with the standard deviation that the rows state (their median) if that is larger.
/// Replicates of a pose share the model error there, so together they count as one reading. A move
/// adds an unknown with no prior.
///
/// Test. `p_value` is two times the smaller of two p-values. The first is that of the chi-square of
/// r under that covariance. The second is that of its largest fall by any single move, because with
/// many readings the chi-square of all hardly shows a change of one parameter. The calibration
/// holds unless `p_value` is below kChangeSignificance. The spread is itself an estimate, from the
/// n poses and k unknowns of the previous calibration, so the first distribution is an F with axes
/// * n - k degrees of freedom in the denominator. If the chi-squares of the single poses, with the
/// best moves fitted, scatter more about their mean than those of independent readings do, the
/// distribution is rescaled by the overdispersion (Satterthwaite 1946), because an arm that comes
/// to rest elsewhere moves all readings of a pose. For the same reason the standard deviation of a
/// move is the larger of two: that of independent readings and that clustered by pose (see
/// calibrate()). Its interval is that of Student's t with poses - 1 degrees of freedom, and its
/// p-value the larger of that of chi-square and that of an F with as many.
///
/// Search. The model takes at most four moves. While the p-value of the residuals, or that of the
/// fall by the next move, is below kChangeSignificance, the move with the lowest BIC is added, and
/// each taken move is exchanged for another if that lowers BIC. At the end a move is dropped if the
/// p-value of its fall of chi-square, times the number of hypotheses, is not below
/// kChangeSignificance. If a hypothesis in the place of a taken move raises BIC by less than 6, the
/// two cannot be distinguished (Kass, Raftery, "Bayes factors", 1995: strong evidence).
///
/// Blunders are found under Student's t with 4 degrees of freedom, with the hypothesis (nothing or
/// one move) that is best under that distribution. So a move is not taken for blunders, nor
/// blunders for a move. If more than 30 % of the rows look like blunders, none counts as one.
///
/// Several sessions. Each has a base without a prior: an instrument that stands elsewhere is no
/// change of the robot. Any other parameter moves at the start of one session and stays. The zero
/// offsets of `previous.identify_per_session` move in one session alone, and have no prior in a
/// session that the previous robot does not know.
///
/// Touches, beams and images. A contact, a beam, a camera or a board may have been moved, as may
/// base and tool: each is one hypothesis, with the parameters that its readings show; those of a
/// camera hold its lens. Where the images show one thing at rest and one on the arm, these stand
/// for base and tool. The errors of the previous parameters then have the covariance of
/// `previous.uncertainty`, if it is stated.
///
/// A zero offset that calibration leaves to base or tool (A1.theta, A6.theta) shows as a move of
/// base or tool. In a session that the previous robot knows, its base is that of the session.
/// Throws std::invalid_argument if `previous.std` is empty, the spread of what was measured is not
/// above zero, or the readings of one of several sessions determine no more than its base.
ChangeResult detect_change(const Robot& previous, const ReadingSigma& spread,
                           const Campaign& campaign);

/// That the replicates scatter more than at the previous calibration, as a sentence: the test takes
/// that for noise, so a loose axis or an unsteady instrument hides changes. Empty if they do not.
std::string noisier_in_words(const ChangeResult& result);

}  // namespace armtrue
