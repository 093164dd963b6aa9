#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A parameter that this campaign cannot distinguish from the kept ones, and the kept ones that
/// imitate it.
struct AbsorbedParameter {
  int parameter;
  /// (parameter, share), largest first: a change of `parameter` by 1 does the same to the readings
  /// as changes of these by `share` (mixed units: m, rad). Empty if the parameter moves nothing
  /// that was measured.
  std::vector<std::pair<int, double>> absorbed_by;
};

/// The parameters that a campaign can identify; see choose_identifiable().
struct IdentifiableSet {
  std::vector<int> kept;  ///< in the order of parameter indices
  std::vector<AbsorbedParameter> absorbed;
  std::vector<int> by_small_angles;  ///< of `kept`: see with_tool_of_small_angles()
};

/// Chooses the geometric parameters that the campaign can identify among those that
/// `robot.identify` allows: `auto` (all, couplings only with a prior), `paper-25`, names, or
/// patterns such as `*.theta`, in their order. `-A3.d` takes away what earlier entries have named:
/// it stays as it is, and so does what would only imitate it.
///
/// Rank-revealing QR with columns of unit norm, taken in a fixed order of preference, so that the
/// set does not depend on a platform's rounding: base, anchors, targets, tool, then over all links
/// theta, alpha, d, r, and beta last, so that beta enters only where two axes are parallel
/// (Hayati), then the couplings and at the very end the anchors' zero errors. Of a prismatic joint
/// r stands in the place of theta; what places a positioner comes before the links. Anchors define
/// R_A: one anchor shows only the translation of the base, three show all of it; their other
/// coordinates are their places relative to each other. A column is absorbed if its part orthogonal
/// to the columns before it is shorter than 1e-6 of its norm; one of the place of the tool also if
/// the readings would leave it a standard deviation above 0.1 m. The columns are computed for the
/// ideal structure of the arm (link angles within 1 deg of a right angle count as right), because
/// near-parallel axes make a set ill-conditioned. The bases and own zero offsets of further
/// sessions are always unknowns beside the set.
///
/// Contacts come before all others: without an instrument they define R_A, and then absorb the
/// base. The rank is computed at configurations that touch exactly, so each one is first moved onto
/// its contact. Otherwise the errors of the robot file would make parameters look identifiable that
/// touches cannot show, such as the scale: an arm and contacts that are all larger by one factor
/// touch in the same configurations. If the readings do not show the scale, the longest length of
/// the links comes last, so that its nominal value sets the scale. Throws std::invalid_argument for
/// a name that the robot does not have, or a session whose readings cannot show its own parameters.
IdentifiableSet choose_identifiable(const Robot& robot, const Campaign& campaign);

/// The same; throws std::invalid_argument if it is empty, because there is nothing to fit then.
IdentifiableSet require_identifiable(const Robot& robot, const Campaign& campaign);

/// The length of a link whose nominal value sets the scale of a set, because touches do not show
/// the scale; nothing if the readings show it, or no length is to be identified.
std::optional<int> length_of_scale(const Robot& robot, const Campaign& campaign,
                                   const IdentifiableSet& set);

/// Parameters that these poses do not show, but that poses over the whole travel of the joints
/// would. Empty for images.
std::vector<int> lost_to_poses(const Robot& robot, const Campaign& campaign,
                               const IdentifiableSet& set);

/// Parameters of the tool that these readings show only together with others, such as its z where
/// it is vertical in all poses: they keep the value of the robot file.
std::vector<int> set_up_not_shown(const KinematicChain& chain, const IdentifiableSet& set);

/// `set` with those coordinates of the tool that it leaves out (set_up_not_shown()), but that the
/// small angles of the arm `fitted` show to a standard deviation of 0.1 m. A tool that is vertical
/// in all poses of the ideal arm is tilted a little on a real one, differently from pose to pose:
/// with a tilt of 1 mrad, an error of 150 mm of its z moves the readings by 0.15 mm.
IdentifiableSet with_tool_of_small_angles(const Robot& fitted, const Campaign& campaign,
                                          const IdentifiableSet& set);

/// A sentence that only small angles of the arm show a coordinate of the tool, with its value in
/// the file (`chain`), and by the readings with its standard deviation [m].
std::string shown_by_small_angles(const KinematicChain& chain, int parameter, double value,
                                  double deviation);

/// A sentence that the readings do not show a parameter of the tool, with the value that it keeps.
std::string not_shown(const KinematicChain& chain, int parameter);

/// The parameters that `robot.identify` names, identifiable or not. Throws std::invalid_argument
/// for an entry that is wrong, see why_not_identified().
std::vector<int> allowed_parameters(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
