#pragma once

#include <array>
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
  enum class Joint { none, own, previous, next, fixed };

  std::string name;
  /// The parameter of each link, target, anchor or contact, or a single one such as base, base.rx
  /// or instrument.range; see parameter_of_catalogue().
  Parameter parameter;
  bool of_every_joint = false;  ///< the parameter is one of each joint
  std::vector<int> joints;      ///< 0-based, without external axes: whose parameter it is
  Driver driver;                ///< `driver_joint` says which joint it gets
  Joint driver_joint = Joint::none;
  Shape shape;
  /// Of a harmonic over a range: the least and the largest length of one cycle, between which it is
  /// searched [m]; 0: it is not searched.
  std::array<double, 2> cycle{};
  bool only_positive = false;  ///< a negative coefficient is impossible, as for a compliance
  /// Bound of what the effect adds to a length over a campaign, relative to that length in the
  /// robot file; below zero: the effect shortens the length; 0: no bound.
  double most_of_length = 0;
  Usual usual = Usual::rare;
  /// Name of the family that its effects form; empty: none. {j} in it stands for the joint of the
  /// parameter, {k} for that of the driver and {n} for the joint after that of the parameter: the
  /// effects then form a family for each of these joints.
  std::string family;
  /// The effects of the family occur together or not at all: none is a cause alone.
  bool only_together = false;
  /// The coefficients of the family have one sign, as those of one load.
  bool alike = false;
  /// Of a family: typical size of what a member adds to its parameter [m, rad].
  double typical = 0;
  /// One sentence for the operator of the cell, in which {j} stands for the joint of the parameter
  /// and {k} for that of the driver: "axis {j} sags under gravity".
  std::string in_words;
  std::string separated_by;  ///< measurement that separates it from similar effects, in words
};

using Catalogue = std::vector<CatalogueEntry>;

/// The effects of this entry on this robot, one for each parameter and joint; without coefficients.
std::vector<Effect> expand(const CatalogueEntry& entry, const Robot& robot);

}  // namespace armtrue
