#pragma once

#include <urdf_model/model.h>

#include <string>

namespace armtrue {

inline bool is_fixed(const urdf::Joint& joint) { return joint.type == urdf::Joint::FIXED; }

/// Whether a link of the branch behind a joint moves against the link in front of it.
bool moves(const urdf::Joint& joint, const urdf::ModelInterface& model);

/// The end of the arm if no tip is named: of the only branch with driven joints, as far as each
/// link behind them has one child. Throws InputError, with the possible ends, where several
/// branches go on.
std::string only_end(const urdf::ModelInterface& model, const std::string& base,
                     const std::string& file);

/// Throws InputError if there is no link of this name, which `option` gave.
void require_link(const urdf::ModelInterface& model, const std::string& name, const char* option,
                  const std::string& file);

}  // namespace armtrue
