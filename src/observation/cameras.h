#pragma once

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/observation/contacts.h"

namespace armtrue {

/// The robot with cameras and boards placed where the images of its poses, without effects, show
/// them. The place of the board before the camera, H, comes from each image: the homography of four
/// corners that leaves the smallest median error of all (LMedS, Rousseeuw 1984), split into
/// rotation and translation (Zhang 2000) and refined by least squares of the better half of the
/// corners. With G the pose of the measured frame, or of a camera at rest its inverse, C the place
/// of the camera and B that of the board, G_i C H_i = B: rotations by Shah's closed form (2013),
/// the translations then are linear; fitted to all images, then twice to the half with the smaller
/// errors, three images at least. Throws as match_contacts(), and std::invalid_argument if a camera
/// has fewer than three images of a board that show four corners.
Robot with_cameras_placed(Robot robot, const Campaign& campaign, FitContacts which);

}  // namespace armtrue
