#include "import/column_units.h"

#include <fmt/format.h>

#include <algorithm>

#include "import/column_names.h"
#include "import/plain_cell.h"

namespace armtrue {
namespace {

UnitKind kind_of(const std::string& quantity) {
  const auto known = stated_quantity(quantity);
  return known ? known->kind : UnitKind::none;
}

const char* example_unit(UnitKind kind) {
  switch (kind) {
    case UnitKind::length:
    case UnitKind::encoder:
      return "mm";
    case UnitKind::angle:
      return "deg";
    case UnitKind::time:
      return "s";
    case UnitKind::mass:
      return "kg";
    case UnitKind::force:
      return "N";
    default:
      return "C";
  }
}

}  // namespace

void ColumnUnits::find(const std::string& quantity, MappedColumn& column) {
  const UnitKind kind = kind_of(quantity);
  if (kind == UnitKind::none || (quantity == "t" && is_clock_time(column.column))) return;
  const std::string& name = table_.columns[column.column].name;
  const std::string* const stated = names_.unit_of(name);
  std::string found;
  const bool is_doubted = names_.doubts_unit_of(name);
  const std::string& unit_row = table_.columns[column.column].unit_row;
  for (const std::string& text :
       {is_doubted ? std::string() : column_name(name).unit, is_doubted ? std::string() : unit_row,
        stated ? *stated : std::string()}) {
    if (text.empty() || text == "-") continue;
    const auto unit = find_unit(text);
    if (!unit || !fits_kind(kind, unit->kind) || !fits_robot(quantity, unit->kind))
      table_.fail_header(fmt::format(
          "the column '{}' has the unit '{}', which is none of {}; correct the header, or say "
          "--ignore '{}'",
          name, text, wanted_column(quantity), name));
    if (!found.empty() && find_unit(found)->factor != unit->factor)
      table_.fail_header(
          fmt::format("the column '{}' has two units, '{}' and '{}'; correct the one that is wrong",
                      name, found, text));
    found = text;
  }
  if (found.empty()) found = unit_for_all(kind_for_all(quantity, kind));
  if (found.empty() && is_doubted) refuse_doubted_unit(name);
  if (found.empty()) {
    std::string& columns = without_unit_[kind_for_all(quantity, kind)];
    columns += (columns.empty() ? "'" : ", '") + name + "'";
    return;
  }
  column.unit = found;
  column.factor = find_unit(found)->factor;
}

void ColumnUnits::refuse_doubted_unit(const std::string& name) const {
  table_.fail_header("the unit of the column '" + name +
                     "' is not certain, whatever its header states: some converters write rad "
                     "under the name of deg; compare a row with the pendant, then say "
                     "--angle-unit rad or --angle-unit deg");
}

// Whether a column needs no unit: it holds dates or times of day, or is empty. Throws InputError if
// it holds neither these nor numbers.
bool ColumnUnits::is_clock_time(int k) const {
  const size_t column = k;
  const auto first = std::ranges::find_if(
      table_.rows, [&](const PlainRow& row) { return !row.cells[column].empty(); });
  if (first == table_.rows.end()) return true;
  for (const DateOrder order : {DateOrder::day_first, DateOrder::month_first})
    if (plain_time(first->cells[column], order) || plain_date(first->cells[column], order))
      return true;
  if (decimal_evidence(first->cells[column]) == DecimalEvidence::no_number &&
      !plain_count(first->cells[column]))
    table_.fail(*first, k,
                "is neither a number nor a time such as 12:33:01.5 or 2024-05-03T12:33:01.5; "
                "write the times so, or leave them out with --ignore");
  return false;
}

std::string ColumnUnits::wanted_column(const std::string& quantity) const {
  for (const JointName& joint : joints_)
    if (options_.robot && joint.column == quantity) return joint.encoder();
  const std::string stated = names_.stated_unit(quantity);
  return stated.empty() ? our_column(quantity) : quantity + "_" + stated;
}

bool ColumnUnits::fits_robot(const std::string& quantity, UnitKind kind) const {
  if (joint_number(quantity) == 0) return true;
  if (!options_.robot && names_.stated_unit(quantity).empty()) return true;
  return wanted_column(quantity).ends_with("_mm") == (kind == UnitKind::length);
}

// The kind of a quantity for the options that state one unit for all lengths or all angles. Encoder
// values of an arm are angles, unless the robot or --column says otherwise; an external axis may be
// either.
UnitKind ColumnUnits::kind_for_all(const std::string& quantity, UnitKind kind) const {
  if (kind != UnitKind::encoder) return kind;
  const bool is_told = options_.robot || !names_.stated_unit(quantity).empty();
  if (!is_told && quantity.front() == 'e') return UnitKind::encoder;
  return wanted_column(quantity).ends_with("_mm") ? UnitKind::length : UnitKind::angle;
}

std::string ColumnUnits::unit_for_all(UnitKind kind) const {
  if (kind == UnitKind::length) return options_.length_unit;
  if (kind == UnitKind::angle) return options_.angle_unit;
  if (kind == UnitKind::time) return options_.time_unit;
  return "";
}

void ColumnUnits::refuse_missing() const {
  if (without_unit_.empty()) return;
  std::string names, remedies;
  for (const auto& [kind, columns] : without_unit_) {
    names += (names.empty() ? "" : ", ") + columns;
    const char* const option = kind == UnitKind::length  ? ", or --length-unit mm"
                               : kind == UnitKind::angle ? ", or --angle-unit deg"
                               : kind == UnitKind::time  ? ", or --time-unit s"
                                                         : "";
    const std::string first = columns.substr(0, columns.find("', '"));
    remedies += (remedies.empty() ? " --unit " : "; --unit ") + first +
                (first.size() == columns.size() ? "" : "'");
    remedies.insert(remedies.size() - 1, std::string("=") + example_unit(kind));
    remedies += option;
  }
  table_.fail_header("no unit is stated for the columns " + names +
                     "; write it into the header, or say which:" + remedies);
}

}  // namespace armtrue
