#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "programs/fanuc/fanuc_flow.h"
#include "programs/fanuc/fanuc_registers.h"

namespace armtrue {

/// Position registers of a FANUC program as it runs. What it assigns is followed, element by
/// element: PR[5]=P[1], PR[5,3]=PR[5,3]+50, PR[7]=LPOS-LPOS. What no program assigns is as listed.
class FanucAssignments {
 public:
  /// What a position of /POS says; nothing if it may have another value.
  using PositionOf = std::function<std::optional<FanucRegister>(double)>;

  /// `text`, `statements`: as of fanuc_flow(); `listed` must outlive this.
  FanucAssignments(std::string_view text, const std::vector<Statement>& statements,
                   const ProgramFlow& flow, const FanucRegisters& listed, PositionOf position_of);

  /// A register before the statement that begins here; nothing if an element of it is not known.
  std::optional<FanucRegister> find(double number, size_t statement) const;

 private:
  // Element 0 says what the others are: an index of kinds_.
  static constexpr int kKind = 0, kNumbers = 6, kElements = 1 + kNumbers;
  using Element = std::pair<double, int>;  // of which register
  struct Assignment {
    size_t at = 0, statement = 0;
    FanucIndex to;
    size_t value = 0, end = 0;  // of the text; an empty one is not known
  };
  // What a register says beside its numbers.
  struct Kind {
    FanucRegister::Meaning meaning = FanucRegister::Meaning::not_said;
    std::string configuration;
    std::optional<int> frame, tool;
    auto operator<=>(const Kind&) const = default;
  };

  void read_statement(const Statement& statement);
  void read_call(const std::string& word, size_t at, TextCursor cursor);
  void assign_any_way(size_t at, const FanucIndex& to);
  bool follow_round(const ProgramFlow& flow);
  void set_elements(const Assignment& assignment,
                    std::map<Element, std::vector<ProgramFlow::Setting>>& settings);
  std::array<int, kElements> whole_value(const Assignment& assignment);
  int sum(const Assignment& assignment);
  std::array<int, kElements> elements_of(const FanucRegister& value);
  int element_before(const Element& element, size_t statement);
  std::optional<double> number_before(const Element& element, size_t statement) const;
  std::optional<Kind> kind_before(double number, size_t statement) const;
  int index_of_number(double value);
  int index_of_kind(const Kind& kind);

  std::string_view text_;
  const FanucRegisters& listed_;
  const PositionOf position_of_;
  std::vector<Assignment> assignments_;
  std::vector<std::pair<size_t, std::string>> calls_;  // programs that may assign registers
  std::set<double> named_;                             // registers
  std::vector<double> numbers_;
  std::vector<Kind> kinds_;
  std::map<double, int> of_numbers_;
  std::map<Kind, int> of_kinds_;
  std::map<Element, std::vector<ProgramFlow::Setting>> settings_;
  std::map<Element, ProgramFlow::Values> values_;  // of what the program assigns
};

}  // namespace armtrue
