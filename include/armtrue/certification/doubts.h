#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/certification/certificate.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Contradictions within the readings of repeated visits, a sentence with number and remedy each:
/// - readings that were copied: more visits than chance allows (p < 1e-4) read the same as another
///   visit of their pose in all digits; chance is computed from the step of the coordinates and the
///   scatter of the other visits. Or most poses have only such visits; or they are another visit
///   with fewer digits;
/// - visits that are not of their pose, see find_stray_visits(), unless one of the next two
///   explains them. What follows is then asked of the others;
/// - two nests of the reflector: the visits of a pose lie at two places, apart by the same vector
///   in the axes of the tool, and no direction of arrival of a joint tells which. The distances
///   between visits of a pose are then short or long, all long ones alike and three times the short
///   ones or more;
/// - a step between two visits, see find_visit_step();
/// - a stated noise of the instrument that is a hundredth of the scatter of the visits, or three
///   times that scatter or more (p < 1e-4). `noise`: per axis [m].
/// `evaluation` is that of the campaign, which has points. Without doubts: empty.
std::vector<std::string> doubts_of_visits(const Robot& robot, const Campaign& campaign,
                                          const Evaluation& evaluation,
                                          const std::optional<double>& noise);

/// Numbers of an armtrue-about/1 document that no instrument, fixture or arm has, and that another
/// unit would explain.
std::vector<std::string> doubts_of(const About& about);

/// Whether the type of a robot, as people state it, and the name of the robot file have numbers,
/// and none in common: a sentence, empty if not.
std::string doubt_of_type(const std::string& type, const std::string& robot);

}  // namespace armtrue
