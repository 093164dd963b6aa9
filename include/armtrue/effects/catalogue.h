#pragma once

#include <string>
#include <vector>

#include "armtrue/effects/effect.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// How many arms have an effect, which is its price in the search: one of few likely causes needs
/// less evidence than one of many unlikely ones.
enum class Usual { most_arms, some, rare };

/// One kind of effect that robots are known to have, for every joint that can have it.
struct CatalogueEntry {
  enum class Joint { none, own, previous, fixed };

  std::string name;
  std::string parameter;  ///< alpha, d, theta, r, beta (of each joint), target, anchor.zero (of
                          ///< each target or anchor), or base, base.rx, tool, instrument.range ...
  bool of_every_joint = false;  ///< the parameter is one of each joint
  std::vector<int> joints;      ///< 0-based; otherwise those of the arm whose parameter it is
  Driver driver;                ///< its joint is filled in as `driver_joint` says
  Joint driver_joint = Joint::none;
  Shape shape;
  bool only_positive = false;  ///< a negative coefficient would not be this effect (compliance)
  Usual usual = Usual::rare;
  std::string family;  ///< that its effects form together; empty: none
  double typical = 0;  ///< of a family: what a member typically adds to its parameter [m, rad]
  /// One sentence for the cell, in which {j} stands for the joint of the parameter, {k} for that of
  /// the driver: "axis {j} sags under gravity".
  std::string in_words;
  std::string separated_by;  ///< what to measure to tell it from its likes, in words
};

using Catalogue = std::vector<CatalogueEntry>;

/// The effects, without coefficients, that the catalogue allows on this robot.
std::vector<Effect> expand(const CatalogueEntry& entry, const Robot& robot);

}  // namespace armtrue
