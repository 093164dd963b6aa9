#pragma once

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Above this error at a contact, its place in the robot file is wrong: no arm errs as much [m].
inline constexpr double kFarContact = 0.02;

/// Which contacts with_contacts_fitted() places.
enum class FitContacts {
  all,       ///< each contact that is touched, read by a beam or seen in an image
  unplaced,  ///< of these, contacts without a place in the robot file, and those with a median
             ///< error of kFarContact or more. All cameras and boards are placed anew if one pair
             ///< of them is such; all contacts, if a beam on a plane with a place is
};

/// The robot with contacts placed where its own points p, without effects, touch them:
///     point         the mean of p
///     artefact      points alone: Umeyama's closed form; with faces: least squares (Levenberg)
///     plane         the smallest singular vector of p - mean
///     sphere        |p|^2 = 2 p.c + (radius^2 - |c|^2), linear in c and the bracket
///     beam          with_beams_placed()
///     camera, board with_cameras_placed()
/// Throws std::invalid_argument as match_contacts() and these two.
Robot with_contacts_fitted(Robot robot, const Campaign& campaign, FitContacts which);

/// The campaign with the configuration of each touch moved, by the smallest change of the joints,
/// so that the robot touches exactly (Newton's method). Touches out of reach are left out.
Campaign moved_onto_contacts(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
