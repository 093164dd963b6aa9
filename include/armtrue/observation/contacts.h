#pragma once

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Above this error at a contact, its place in the robot file is wrong: no arm errs as much [m].
inline constexpr double kFarContact = 0.02;

/// Which contacts with_contacts_fitted() places.
enum class FitContacts {
  all,      ///< each contact that is touched
  unknown,  ///< of these, contacts without a place in the robot file, and those with a median error
            ///< of 20 mm or more
};

/// The robot with contacts placed where its own points, without effects, touch them: a point at
/// their mean, an artefact by Umeyama's closed form, a plane by the smallest singular vector of the
/// points, a sphere by |p|^2 = 2 p.c + (radius^2 - |c|^2), linear in c and the bracket;
/// cameras and boards by with_cameras_placed(). Throws as match_contacts().
Robot with_contacts_fitted(Robot robot, const Campaign& campaign, FitContacts which);

/// The campaign with each configuration moved, by the smallest change of the joints, so that the
/// robot touches exactly (Newton's method). Rows whose contact is out of reach are left out.
Campaign moved_onto_contacts(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
