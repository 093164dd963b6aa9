#pragma once

#include "armtrue/calibration/identifiability.h"
#include "armtrue/kinematics/chain.h"
#include "armtrue/observation/session_models.h"

namespace armtrue {

/// The parameters `models.geometric()`, in that order of preference, whose derivatives at x = 0 are
/// independent of those before them: Gram and Schmidt's orthogonalisation, see
/// choose_identifiable().
///
/// What a group of rows has of its own moves no other row, so a basis of these columns is kept
/// group by group. The bases and zero offsets of further sessions come before all parameters. The
/// places of targets, where the models are split by them, come in their turn: with E the columns
/// before them, the part of a target's column that E and the targets before it leave depends on
/// its own rows and on two triangles: of E in the rows of the targets before it, without their
/// part, and of E in the rows of those after it.
///
/// Throws std::invalid_argument if the readings of a further session do not show what it has of its
/// own.
IdentifiableSet choose_columns(const SessionModels& models, const KinematicChain& chain);

}  // namespace armtrue
