#pragma once

#include <Eigen/Core>
#include <string>

#include "report/page.h"

namespace armtrue {

/// The conditions for which a prediction is valid, and the effects that it leaves out. Keys:
/// assumed, not_applied.
void add_conditions(Page& page);

struct RowsText {
  std::string file = "rows", title = "Predicted error along the rows";
  std::string note = "Each row in the order of the program.", axis = "row";
  std::string before = "as it is", after;
  std::vector<std::string> names = {};  ///< of the rows, for a pointer; none if empty
};

/// Two lengths along the rows of a program [mm]; not finite where there is none.
Drawing rows_picture(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                     const RowsText& text);

}  // namespace armtrue
