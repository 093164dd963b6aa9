#include "import/covariance_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/io/covariance_column.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

std::string quantity_at(int row, int column) { return fmt::format("cov{}", 6 * row + column); }

}  // namespace

void require_whole_covariance(const PlainTable& table, const ColumnMapping& mapping) {
  std::string there;
  int count = 0;
  for (int k = 0; k < kCovarianceEntries; ++k)
    if (const MappedColumn* const column = mapping.find(fmt::format("cov{}", k))) {
      if (there.empty()) there = table.columns[column->column].name;
      ++count;
    }
  if (count == 0 || count == kCovarianceEntries) return;
  table.fail_header(fmt::format(
      "{} of the {} columns of a covariance stand here, such as '{}'; export the others too, or "
      "leave these out: --ignore '{}*'",
      count, kCovarianceEntries, there,
      there.substr(0, there.find_last_not_of("0123456789[]") + 1)));
}

std::string our_covariance_column(const std::string& quantity) {
  const int entry = read_whole_number(quantity.substr(3)).value(), row = entry / 6,
            column = entry % 6;
  return covariance_column(std::min(row, column), std::max(row, column));
}

PoseCovariance covariance_of(const TableReader& reader, int r) {
  constexpr double kRounded = 1e-6;  // relative
  PoseCovariance covariance;
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) covariance(i, k) = reader.number(r, quantity_at(i, k));
  for (int i = 0; i < 6; ++i)
    for (int k = i + 1; k < 6; ++k)
      if (const double a = covariance(i, k), b = covariance(k, i);
          std::abs(a - b) > kRounded * std::max(std::abs(a), std::abs(b)))
        reader.fail(r, quantity_at(k, i),
                    fmt::format("is not equal to its mirror image '{}', as a covariance is; are "
                                "these its columns? Correct the row, or leave them out with "
                                "--ignore",
                                reader.cell(r, quantity_at(i, k))));
  return covariance;
}

StatedBlocks known_blocks(const TableReader& reader) {
  StatedBlocks known;
  if (!reader.has(quantity_at(0, 0))) return known;
  for (int r = 0; r < reader.rows() && !(known.position && known.rotation); ++r) {
    if (reader.is_unmeasured(r)) continue;
    const PoseCovariance covariance = covariance_of(reader, r);
    known.position |= !covariance.leftCols<3>().isZero(0);
    known.rotation |= reader.has_orientation() && !covariance.rightCols<3>().isZero(0);
  }
  return known;
}

void add_covariance(const TableReader& reader, int r, const PoseCovariance& covariance,
                    const StatedBlocks& blocks, Campaign& campaign) {
  PoseCovariance stated = covariance;
  if (!blocks.position || !blocks.rotation) {
    stated.setIdentity();
    if (blocks.position) stated.topLeftCorner<3, 3>() = covariance.topLeftCorner<3, 3>();
    if (blocks.rotation) stated.bottomRightCorner<3, 3>() = covariance.bottomRightCorner<3, 3>();
  }
  if (!add_covariance(stated, blocks, campaign))
    reader.fail(r, quantity_at(blocks.position ? 0 : 3, blocks.position ? 0 : 3),
                "begins a covariance that is not positive definite: variances are above zero, and "
                "no covariance is beyond the root of the product of its two variances; correct or "
                "remove the row, or leave the covariances out with --ignore");
}

}  // namespace armtrue
