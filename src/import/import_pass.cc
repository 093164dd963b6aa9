#include <fmt/format.h>

#include <vector>

#include "armtrue/import/import_io.h"
#include "armtrue/kinematics/pose.h"
#include "armtrue/text/number_text.h"
#include "import/imported_table.h"
#include "import/table_reader.h"

namespace armtrue {
namespace {

// Times of the kept rows [s]; from the first one on if they count from 1970 or are dates or times
// of day.
Eigen::VectorXd times_of(const TableReader& table, const std::vector<int>& kept) {
  const TableReader::Clock clock = table.clock();
  const PlainTime zero = clock.is_number ? PlainTime{} : clock.times[kept.front()];
  Eigen::VectorXd times(kept.size());
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    times[i] = clock.since(kept[i], zero);
    if (i > 0 && times[i] <= times[i - 1])
      table.fail(kept[i], "t",
                 "is not later than the row above; sort the rows by time and remove doubled ones");
  }
  if (clock.is_number && times[0] > kFrom1970) times.array() -= times[0];
  return times;
}

Path path_of(const TableReader& table, const std::vector<int>& kept) {
  Path path;
  path.time = times_of(table, kept);
  const auto count = static_cast<Eigen::Index>(kept.size());
  const bool has_joints = !table.joint_names().empty();
  if (table.has("x")) path.position.resize(3, count);
  if (table.has_orientation()) path.orientation.resize(3, count);
  if (has_joints) path.q.resize(table.joint_names().size(), count);
  if (table.has("fx")) path.force.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int r = kept[i];
    if (path.has_position()) path.position.col(i) = table.position(r);
    if (path.has_orientation())
      path.orientation.col(i) = abc_from_rotation(table.orientation(r).toRotationMatrix());
    if (has_joints) path.q.col(i) = table.joints(r);
    if (path.has_force())
      path.force.col(i) << table.number(r, "fx"), table.number(r, "fy"), table.number(r, "fz");
  }
  return path;
}

}  // namespace

ImportedPass import_pass(const std::string& path, const ImportOptions& options) {
  ImportedTable import = read_imported_table(path, options, TableRole::pass);
  import.names.check_all_found({&import.table});
  map_imported_table(import, options, TableRole::pass);
  if (import.table.has_markers)
    import.table.fail_header(
        "several points stand in each row, and a pass is of one; choose it with --marker");
  const TableReader table(import.table, import.mapping);
  std::vector<int> kept;
  for (int r = 0; r < table.rows(); ++r)
    if (!table.has("x") || !table.is_unmeasured(r)) kept.push_back(r);
  if (kept.size() < 2)
    import.table.fail_header("fewer than two rows have a point; export the record of the pass");
  ImportedPass result;
  result.path = path_of(table, kept);
  result.joints = table.joint_names();
  result.mapping = mapping_text(import.table, import.mapping);
  if (const size_t lost = table.rows() - kept.size(); lost > 0)
    result.warnings.push_back(
        fmt::format("{}: left out: {} without a measured point", path, counted(lost, "row")));
  return result;
}

}  // namespace armtrue
