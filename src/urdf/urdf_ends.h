#pragma once

#include <urdf_model/model.h>

#include <string>

namespace armtrue {

inline bool is_fixed(const urdf::Joint& joint) { return joint.type == urdf::Joint::FIXED; }

/// Whether a link of the branch behind a joint moves against the link in front of it.
bool moves(const urdf::Joint& joint, const urdf::ModelInterface& model);

/// The end of the arm where nobody names it: along the branch with driven joints, and on as long as
/// one link follows the other. Throws InputError, with the ends, where the way branches.
std::string only_end(const urdf::ModelInterface& model, const std::string& base,
                     const std::string& file);

/// Throws InputError if there is no link of this name, which `option` gave.
void require_link(const urdf::ModelInterface& model, const std::string& name, const char* option,
                  const std::string& file);

}  // namespace armtrue
