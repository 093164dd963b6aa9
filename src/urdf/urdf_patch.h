#pragma once

#include <map>
#include <string>

#include "urdf/urdf_chain.h"

namespace armtrue {

/// The origins that turn the chain of a document into that of another robot.
struct ChainPatch {
  Robot robot;                          ///< with what is kept of the chain
  std::map<std::string, Pose> origins;  ///< that change, by joint
  FrameShift base, tool, tool_left_out;
};

/// `nominal` is the arm that robot_of() makes of the chain. Throws InputError if `robot` is another
/// arm.
ChainPatch patch_of(const UrdfChain& chain, const Robot& nominal, const Robot& robot,
                    const UrdfKept& kept, const std::string& file);

/// Throws InputError if the two robots differ by more than 1e-9 m or rad.
void require_same_arm(const Robot& wanted, const Robot& written, const std::string& file);

}  // namespace armtrue
