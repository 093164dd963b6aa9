#pragma once

#include <array>
#include <string>
#include <vector>

#include "armtrue/calibration/observation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Probability below which a calibration is said not to hold, and a move to be shown.
inline constexpr double kChangeSignificance = 0.01;

/// How far one parameter has moved since the previous calibration, if only its hypothesis is true.
struct ParameterChange {
  int parameter;  ///< index
  double value;   ///< [m or rad]
  double std;     ///< of `value`, with what the previous calibration did not know
  std::array<double, 2> ci95;
};

/// What has moved: one identified parameter of a link, `base` (the tracker moved or was knocked),
/// `anchor <name>` (one of several) or `tool` (the tool or its targets were seated anew).
struct Move {
  std::string what;
  std::vector<std::string> sessions;     ///< in which it is moved; empty: in all
  std::vector<ParameterChange> changes;  ///< one; of base, tool and anchor all that is shown
  double delta_bic = 0;                  ///< fall of BIC by it; positive is better
  double p_value = 1;                    ///< of the fall of chi-square, times the number of moves
  double p_value_left = 1;               ///< of all that is left
  /// What these readings cannot tell from it, in its place; best first.
  std::vector<Move> indistinguishable;
};

struct ChangeResult {
  bool holds = true;
  double p_value = 1;         ///< of the residuals if nothing has moved
  ReadingSigma sigma;         ///< spread of the readings that was taken, per axis
  std::vector<int> blunders;  ///< rows that are off alone; they take no part
  /// What has moved, as all of it together explains the readings; in the order of discovery. Empty
  /// if the calibration holds or no move explains what is off.
  std::vector<Move> moved;
  double p_value_left = 1;  ///< of the residuals once these have moved
  /// Of several sessions: bases that the previous robot knows and that are elsewhere.
  std::vector<Move> stations;
  double before = 0, after = 0;  ///< mean position error, nothing and these moved [m]
};

/// Whether a calibration still holds on a few new poses and, if not, which parameters have moved.
///
/// The new residuals against the previous robot, its effects as they are, are taken as
/// r = J x + e: x the errors of the previous parameters, with the standard deviations in
/// `previous.std`, taken as independent of each other (their covariance is not in the file; what
/// correlates most makes the test only more cautious); e the `spread` that the previous calibration
/// left, or the scatter of the new replicates if that is larger. Replicates of a pose share what
/// the model lacks there, so together they count as one reading.
/// It holds unless the chi-square of r under that covariance has a probability below
/// kChangeSignificance. Where the poses' own chi-squares scatter by more than those of independent
/// readings, once the best moves are taken out, its law is widened by that (Satterthwaite 1946):
/// what comes to rest elsewhere moves all readings of a pose. For the same reason the standard
/// deviation of a move is that clustered by pose (see calibrate()) where that is the larger, its
/// interval Student's with one degree of freedom less than there are poses, and its probability
/// that of an F with as many. A move adds an unknown of which nothing is known. While what is left
/// is that improbable, and no more than four were taken, the best by BIC after Gauss-Newton is
/// taken; those taken are exchanged where another in their place is better, and in the end dropped
/// where the probability of their fall of chi-square, times the number of moves, is not below
/// kChangeSignificance. A move within 6 of one that was taken, in its place, cannot be told from it
/// (Kass, Raftery, "Bayes factors", 1995: strong evidence).
///
/// Blunders are found under Student's t with 4 degrees of freedom, in the hypothesis (nothing or
/// one move) that is best under that law, so that a change is not taken for blunders nor they for
/// it; if more than three in ten rows look like blunders, none is one.
///
/// Of several sessions each has a base of which nothing is known: an instrument that stands
/// elsewhere is no change of the robot. What else moves does so from one session on; the zero
/// offsets of `previous.identify_per_session` in one alone, and nothing is known of them in a
/// session that the previous robot does not know.
///
/// A zero offset that calibration leaves to base or tool (A1.theta, A6.theta) shows
/// as a move of base or tool. In a session that the previous robot knows its base is that of the
/// session. Throws std::invalid_argument if `previous.std` is empty, the spread of what was
/// measured is not above zero, or the readings of one of several sessions only place its base.
ChangeResult detect_change(const Robot& previous, const ReadingSigma& spread,
                           const Campaign& campaign);

}  // namespace armtrue
