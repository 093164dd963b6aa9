#pragma once

#include "armtrue/calibration/identifiability.h"
#include "armtrue/kinematics/chain.h"
#include "armtrue/observation/session_models.h"

namespace armtrue {

/// The parameters `models.geometric()`, in that order of preference, whose derivatives at x = 0 are
/// independent of those before them: Gram and Schmidt's orthogonalisation, see
/// choose_identifiable().
///
/// The own unknowns of a group of rows move no other row, so their basis is kept by group. The
/// bases and zero offsets of further sessions come before all parameters. The places of targets, if
/// the models are split by them, come in the order of preference. With E the columns before them,
/// the part of a target's column that is orthogonal to E and to the targets before it depends on
/// its own rows and on two triangles: that of E in the rows of earlier targets, projected off their
/// columns, and that of E in the rows of later ones.
///
/// Throws std::invalid_argument if the readings of a further session do not show its own unknowns.
IdentifiableSet choose_columns(const SessionModels& models, const KinematicChain& chain);

}  // namespace armtrue
