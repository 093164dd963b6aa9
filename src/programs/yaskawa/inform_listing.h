#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/pose.h"

// What a controller's own files say beside its jobs.

namespace armtrue {

/// Of RC.PRM or ALL.PRM, TOOL.CND and UFRAME.CND. Empty vectors: files of two controllers, which
/// say different things.
struct InformListing {
  std::map<int, std::vector<double>> pulses;        ///< per deg of S L U R B T; 1: of RB1
  std::map<int, std::vector<double>> tools, users;  ///< X Y Z Rx Ry Rz by number [mm, deg]

  /// Null if it is not stated.
  const std::vector<double>* pulses_of(int robot) const;
  std::optional<std::vector<double>> tool(int number) const;
  std::optional<std::vector<double>> user(int number) const;
};

/// The name of a text of text_of().
inline constexpr const char* kInformListing = "listing.CND";

/// By the name of a file: .PRM, .CND.
bool is_inform_listing(const std::string& name);
/// Adds what a file says, or what text_of() wrote.
void read_inform_listing(const std::string& text, InformListing& listing);
std::string text_of(const InformListing& listing);

}  // namespace armtrue
