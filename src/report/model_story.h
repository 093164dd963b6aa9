#pragma once

#include "report/page.h"

namespace armtrue {

/// The conditions for which a prediction is valid, and the effects that it leaves out. Keys:
/// assumed, not_applied.
void add_story(Page& page, const ModelStory& story);

/// Two lengths along the rows of a program [mm]; not a number where there is none.
Drawing rows_picture(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                     const std::string& after_name);

}  // namespace armtrue
