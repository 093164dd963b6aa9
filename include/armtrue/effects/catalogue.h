#pragma once

#include <string>
#include <vector>

#include "armtrue/effects/effect.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// How many arms have an effect. The search charges an effect 2 ln N, with N the number of
/// candidates that are at least as usual: one of a few likely causes needs less evidence than one
/// of many unlikely ones.
enum class Usual { most_arms, some, rare };

/// One kind of effect that robots are known to have, on every joint that can have it.
struct CatalogueEntry {
  enum class Joint { none, own, previous, fixed };

  std::string name;
  /// Of each link, target or anchor, or one such as base, base.rx, instrument.range; see
  /// parameter_of_catalogue().
  Parameter parameter;
  bool of_every_joint = false;  ///< the parameter is one of each joint
  std::vector<int> joints;      ///< 0-based; otherwise those of the arm whose parameter it is
  Driver driver;                ///< `driver_joint` says which joint it gets
  Joint driver_joint = Joint::none;
  Shape shape;
  bool only_positive = false;  ///< a negative coefficient is impossible, as for a compliance
  Usual usual = Usual::rare;
  std::string family;  ///< name of the family that its effects form; empty: none
  /// Of a family: typical size of what a member adds to its parameter [m, rad].
  double typical = 0;
  /// One sentence for the operator of the cell, in which {j} stands for the joint of the parameter
  /// and {k} for that of the driver: "axis {j} sags under gravity".
  std::string in_words;
  std::string separated_by;  ///< measurement that separates it from similar effects, in words
};

using Catalogue = std::vector<CatalogueEntry>;

/// The effects, without coefficients, that the catalogue allows on this robot.
std::vector<Effect> expand(const CatalogueEntry& entry, const Robot& robot);

}  // namespace armtrue
