#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "programs/statement.h"
#include "programs/text_cursor.h"

// What routines and instructions may change of the data that are handed to them.

namespace armtrue {

/// The routine or instruction that gets a datum, or a component of it, as a whole argument; empty
/// if it stands in an expression, which is only read. `at`: its name; `behind`: behind the name.
std::string rapid_receiver(std::string_view text, const Statement& statement, size_t at,
                           TextCursor behind);

/// The type of what stands behind the name of a datum of a type: its components (.trans.z) and
/// indices. Empty if it is not known.
std::string rapid_type_of_part(const std::string& type, TextCursor behind);

/// The routines of a program and of other modules.
class RapidRoutines {
 public:
  /// `text`: a module by masked().
  void read(std::string_view text, const std::vector<Statement>& statements);
  /// Once all are read: a routine also changes what those change to which it hands it on.
  void follow_calls();

  bool contains(const std::string& name) const { return routines_.contains(name); }
  /// The types of the arguments that a routine may change.
  std::set<std::string> changed_by(const std::string& name) const;
  /// Whether a routine or instruction may change an argument of a type, empty if that is not known.
  /// Moves and what RAPID itself defines to read do not. Any other one may change what it gets,
  /// but for a whole tool or work object: those mostly go to routines that move the arm.
  bool may_change(const std::string& receiver, const std::string& type) const;

 private:
  // A parameter that is no copy.
  struct Parameter {
    std::string type;
    bool is_changed = false;
    // To whom the routine hands it on, or what part of it.
    struct Handed {
      std::string receiver, type;
    };
    std::vector<Handed> handed;
  };
  using Parameters = std::map<std::string, Parameter>;

  void note(Parameter& parameter, std::string_view text, const Statement& statement, size_t at,
            TextCursor behind);

  std::map<std::string, std::vector<Parameters>> routines_;
};

}  // namespace armtrue
