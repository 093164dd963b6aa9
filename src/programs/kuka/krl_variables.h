#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/kinematics/pose.h"
#include "programs/kuka/krl_frame.h"
#include "programs/kuka/krl_steps.h"

namespace armtrue {

/// A value of a variable of KRL: a number, a point, or an FDAT.
struct KrlValue {
  std::optional<double> number;
  KrlFrame point;  ///< its values or its axes; where it stands in a text counts for nothing
  bool is_axes = false;
  std::optional<KrlFdat> fdat{};
};

/// A statement of the .src that gives a variable a value, NAME=.. or NAME.X=.., or that may change
/// it in a way that is not followed.
struct KrlChange {
  size_t begin = 0, end = 0;
  bool is_assignment = false;
};

/// Which value the variables of a KRL program have at its places, as far as constants make them:
/// XP2=XP1, XP2.Z=XP2.Z+100 (KUKA, KSS 8.x operating and programming instructions: variables and
/// declarations). What a data list declares counts only if nothing changes it, because a controller
/// keeps what the last run left.
class KrlVariables {
 public:
  /// `src`: the text of the .src, which must outlive follow().
  KrlVariables(std::string_view src, const KrlSteps& steps) : src_(src), steps_(steps.flow()) {}

  /// A variable that nothing changes.
  void add_constant(const std::string& name, const std::string& type, const KrlValue& value) {
    constants_[name] = value;
    types_[name] = type;
  }
  /// One that only these statements change. `declared`: what a data list gives it.
  void add(const std::string& name, const std::string& type, const std::vector<KrlChange>& changes,
           const KrlValue& declared) {
    variables_[name].changes = changes;
    variables_[name].declared = declared;
    types_[name] = type;
  }

  /// Whether any point of the program states an external axis: else none moves, and what a variable
  /// may keep of one counts for nothing.
  void set_has_external(bool has_external) { has_external_ = has_external; }

  /// Follows the values of all variables through the program; once.
  void follow();

  /// The product of points, XP1:fUp:{Z 50,..}, if all of them are known at a place with six numbers
  /// each. It is a frame: it states no S and T (KSS 8.x, geometric operator). A point with S, T or
  /// external axes behind the first factor would give them.
  static std::optional<Pose> product_of(const std::vector<std::optional<KrlValue>>& factors);

  /// The value at a place; nothing if it is not known.
  std::optional<KrlValue> value_at(const std::string& name, size_t place) const;
  /// What changes a variable; empty if nothing does, or more than these may.
  const std::vector<KrlChange>& changes_of(const std::string& name) const;
  /// The tool and base of an FDAT at a place, as far as they are known.
  std::optional<KrlFdat> fdat_at(const std::string& name, size_t place) const;
  /// A sum of products of numbers and variables.
  std::optional<double> number_at(std::string_view expression, size_t place) const;
  /// Whether a value leaves out components that other values of the variable state: the variable
  /// may keep them. Of E1 to E6, and `with_turn` of S and T.
  bool may_keep_more(const std::string& name, const KrlValue& value, bool with_turn) const;

 private:
  struct Variable {
    std::vector<KrlChange> changes;
    ProgramFlow::Values values;
    std::vector<int> set;  // by each change; of values_
    KrlValue declared;
    std::optional<KrlFdat> stays;  // of the declared FDAT: what no change alters
    // What its values state, with that of the data list.
    bool is_anything = false;  // a value is not known
    bool states_turn = false;
    std::array<bool, 6> states_external{};
    bool is_followed = false;
  };

  bool follow(const std::string& name, Variable& variable);
  void note_what_is_stated(Variable& variable) const;
  bool sets_coordinate(const KrlChange& change) const;
  std::optional<KrlValue> set_by(const std::string& name, const KrlChange& change) const;
  std::optional<KrlValue> fdat_set_by(const std::string& name, const std::string& component,
                                      TextCursor cursor, size_t place) const;
  void note_what_stays(Variable& variable) const;
  std::optional<KrlValue> point(TextCursor& cursor, const std::string& type, size_t place) const;
  std::optional<KrlValue> with_component(KrlValue value, const std::string& component,
                                         double number) const;
  std::optional<double> sum(TextCursor& cursor, size_t place) const;
  std::optional<double> take_named_number(TextCursor& cursor, size_t place) const;
  int number_of(const KrlValue& value);

  std::string_view src_;
  const ProgramFlow steps_;
  bool has_external_ = true;
  std::map<std::string, KrlValue> constants_;
  std::map<std::string, Variable> variables_;
  std::map<std::string, std::string> types_;
  std::vector<KrlValue> values_;
  std::map<std::vector<double>, int> numbers_;  // of the values, by what they are
};

}  // namespace armtrue
