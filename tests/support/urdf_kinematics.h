// Forward kinematics of a URDF by urdfdom and KDL. Shares no code with armtrue.
#pragma once

#include <kdl/chain.hpp>
#include <kdl/frames.hpp>
#include <string>
#include <vector>

namespace oracle {

struct UrdfJoint {
  std::string name;
  bool is_driven = false;
  double lower = 0, upper = 0;  // [rad or m]; +-pi of a joint without end
};

// How the numbers of a document are read.
enum class RightAngles {
  as_written,
  exact,  // an attitude within 1e-3 of one by right angles is that one: makers round pi/2
};

class UrdfArm {
 public:
  // Throws std::runtime_error if urdfdom does not take the text, or there is no way.
  UrdfArm(const std::string& text, const std::string& base, const std::string& tip,
          RightAngles right_angles = RightAngles::as_written);

  // The tip in the base. `q` holds the driven joints [rad or m].
  KDL::Frame pose(const std::vector<double>& q) const;
  // From the base to the tip.
  const std::vector<UrdfJoint>& joints() const { return joints_; }

 private:
  KDL::Chain chain_;
  std::vector<UrdfJoint> joints_;
};

}  // namespace oracle
