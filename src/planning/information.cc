#include "planning/information.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <stdexcept>

#include "armtrue/observation/fold.h"
#include "linear_algebra/decompositions.h"
#include "planning/choose_by_exchange.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kCandidatesPerBlock = 64;

Eigen::MatrixXd with_identity(Eigen::MatrixXd gram) {
  gram.diagonal().array() += 1;
  return gram;
}

// L^-T of a small lower triangular factor L.
Eigen::MatrixXd upper_inverse(const Eigen::LLT<Eigen::MatrixXd>& root) {
  const Eigen::MatrixXd& lower = root.matrixLLT();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(lower.rows(), lower.cols());
  for (Eigen::Index j = 0; j < lower.cols(); ++j) {
    inverse(j, j) = 1 / lower(j, j);
    for (Eigen::Index i = 0; i < j; ++i) {
      double sum = 0;
      for (Eigen::Index k = i; k < j; ++k) sum += lower(j, k) * inverse(i, k);
      inverse(i, j) = -sum * inverse(j, j);
    }
  }
  return inverse;
}

double log_determinant(const Eigen::LLT<Eigen::MatrixXd>& llt) {
  return 2 * llt.matrixLLT().diagonal().array().log().sum();
}


}  // namespace

Eigen::MatrixXd upper_triangle(const Eigen::MatrixXd& rows) {
  const Eigen::Index columns = rows.cols();
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(std::max(rows.rows(), columns), columns);
  square.topRows(rows.rows()) = rows;
  return Eigen::HouseholderQR<Eigen::MatrixXd>(square)
      .matrixQR()
      .topRows(columns)
      .triangularView<Eigen::Upper>();
}

Eigen::MatrixXd divided_by(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& triangle) {
  return triangle.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(rows);
}

UnknownGroups::UnknownGroups(const SessionModels& candidates)
    : split_(candidates.is_split_by_target() ? SessionModels::Split::by_target
                                             : SessionModels::Split::by_session) {
  std::vector<int> groups_of(candidates.unknowns(), 0);
  for (int g = 0; g < candidates.groups(); ++g)
    for (const SessionModels::Run& run : candidates.runs(g))
      for (int k = run.first; k < run.first + run.count; ++k) ++groups_of[k];
  const auto is_own = [&](int k) { return candidates.groups() > 1 && groups_of[k] == 1; };
  for (int k = 0; k < candidates.unknowns(); ++k)
    if (!is_own(k)) common_.push_back(k);
  for (int g = 0; g < candidates.groups(); ++g) {
    std::vector<int>& own = own_.emplace_back();
    target_.push_back(candidates.target_of(g));
    for (const SessionModels::Run& run : candidates.runs(g))
      for (int k = run.first; k < run.first + run.count; ++k)
        if (is_own(k)) own.push_back(k);
  }
}

size_t UnknownGroups::group_of(const SessionModels& models, int group) const {
  const auto found = std::ranges::find(target_, models.target_of(group));
  if (found == target_.end())
    throw std::logic_error("a target that no candidate reads");
  return found - target_.begin();
}

GroupRows UnknownGroups::apart(const SessionModels& models, int group,
                               const Eigen::MatrixXd& rows) const {
  std::map<int, Eigen::Index> column;  // of each unknown
  for (const SessionModels::Run& run : models.runs(group))
    for (int k = run.first; k < run.first + run.count; ++k) column.emplace(k, column.size());
  const auto taken = [&](const std::vector<int>& unknowns) {
    Eigen::MatrixXd some = Eigen::MatrixXd::Zero(rows.rows(), std::ssize(unknowns));
    for (size_t k = 0; k < unknowns.size(); ++k)
      if (const auto found = column.find(unknowns[k]); found != column.end())
        some.col(k) = rows.col(found->second);
    return some;
  };
  return {taken(own_[group_of(models, group)]), taken(common_)};
}

GroupedDerivatives UnknownGroups::derivatives(const SessionModels& models) const {
  GroupedDerivatives all{std::vector<GroupRows>(groups()),
                         std::vector<std::vector<int>>(groups()), models.row_size()};
  for (int g = 0; g < models.groups(); ++g) {
    const ObservationModel& model = models.model(g);
    const int size = model.row_size(), p = model.unknowns();
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(p));
    Eigen::MatrixXd rows(model.rows() * size, p), row(size, p + 1);
    for (int i = 0; i < model.rows(); ++i) {
      at.block(i, row);
      rows.middleRows(i * size, size) = row.leftCols(p);
    }
    const size_t group = group_of(models, g);
    all.groups[group] = apart(models, g, rows);
    for (int i : models.rows_of(g)) all.pose_of_row[group].push_back(models.campaign().pose[i]);
  }
  return all;
}

GroupedDerivatives UnknownGroups::triangles(const SessionModels& models) const {
  GroupedDerivatives all{std::vector<GroupRows>(groups()), {}, 1};
  for (size_t g = 0; g < groups(); ++g)
    all.groups[g] = {Eigen::MatrixXd(0, std::ssize(own_[g])),
                     Eigen::MatrixXd(0, std::ssize(common_))};
  if (models.rows() == 0) return all;
  for (int g = 0; g < models.groups(); ++g) {
    const ObservationModel& model = models.model(g);
    const int p = model.unknowns();
    all.groups[group_of(models, g)] =
        apart(models, g,
              fold(model.at(Eigen::VectorXd::Zero(p)), model, ReadingLaw{}).factor.topLeftCorner(
                  p, p));
  }
  return all;
}

GroupedDerivatives UnknownGroups::of_one_group(const Eigen::MatrixXd& rows) const {
  GroupedDerivatives all;
  all.groups.push_back({Eigen::MatrixXd(rows.rows(), 0), rows});
  return all;
}

Scaling::Scaling(const GroupedDerivatives& rows, double weight) {
  const Eigen::Index common = rows.groups.front().common.cols();
  Eigen::MatrixXd left(0, common);
  for (const GroupRows& group : rows.groups) {
    const Eigen::Index own = group.own.cols();
    Eigen::MatrixXd both(group.own.rows(), own + common);
    both << group.own, group.common;
    const Eigen::MatrixXd triangle = weight * upper_triangle(both);
    own_.push_back(triangle.topLeftCorner(own, own));
    shared_.push_back(triangle.topRightCorner(own, common));
    Eigen::MatrixXd stacked(left.rows() + common, common);
    stacked << left, triangle.bottomRightCorner(common, common);
    left = upper_triangle(stacked);
  }
  common_ = std::move(left);
}

void Scaling::apply(GroupedDerivatives& rows) const {
  for (size_t g = 0; g < rows.groups.size(); ++g) {
    GroupRows& group = rows.groups[g];
    if (group.own.cols() > 0) {
      group.own = divided_by(group.own, own_[g]);
      group.common -= group.own * shared_[g];
    }
    group.common = divided_by(group.common, common_);
  }
}

Information::Information(GroupedDerivatives candidates, int poses, const GroupedDerivatives& known,
                         const GroupedDerivatives& aim)
    : poses_(poses) {
  const Eigen::Index common = candidates.groups.front().common.cols();
  common_ = kKnownFromStart * Eigen::MatrixXd::Identity(common, common);
  for (size_t g = 0; g < candidates.groups.size(); ++g) {
    GroupRows& of_group = candidates.groups[g];
    const Eigen::Index own = of_group.own.cols();
    std::vector<Eigen::Index>& first = first_.emplace_back(poses + 1, 0);
    for (int pose : candidates.pose_of_row[g]) first[pose + 1] += candidates.row_size;
    std::partial_sum(first.begin(), first.end(), first.begin());
    candidates_.push_back({of_group.own.transpose(), of_group.common.transpose()});
    of_group = {};
    blocks_.push_back({kKnownFromStart * Eigen::MatrixXd::Identity(own, own),
                       Eigen::MatrixXd::Zero(own, common)});
    const GroupRows& rows = known.groups[g];
    blocks_.back().own += rows.own.transpose() * rows.own;
    blocks_.back().shared += rows.own.transpose() * rows.common;
    common_ += rows.common.transpose() * rows.common;
  }
  if (aim.groups.empty()) return;
  aim_.common = Eigen::MatrixXd::Zero(common, common);
  for (const GroupRows& rows : aim.groups) {
    aim_.blocks.push_back({rows.own.transpose() * rows.own, rows.own.transpose() * rows.common});
    aim_.common += rows.common.transpose() * rows.common;
  }
}

Eigen::Block<const Eigen::MatrixXd> Information::columns_of(const Eigen::MatrixXd& columns,
                                                            size_t group, int candidate) const {
  const Eigen::Index first = first_[group][candidate];
  const Eigen::Index end = first_[group][candidate + 1];
  return columns.block(0, first, columns.rows(), end - first);
}

void Information::set_chosen(int candidate, bool chosen) {
  const double sign = chosen ? 1 : -1;
  for (size_t g = 0; g < blocks_.size(); ++g) {
    const auto own = columns_of(candidates_[g].own, g, candidate);
    const auto common = columns_of(candidates_[g].common, g, candidate);
    blocks_[g].own += sign * (own * own.transpose());
    blocks_[g].shared += sign * (own * common.transpose());
    common_ += sign * (common * common.transpose());
  }
}

// tr(A M^-1 A^T), `schur` the information of the common unknowns beside the own ones. With
// K = D^-1 F the common unknowns add tr(S^-1 (A_c^T A_c + sum K^T B)), B = A_o^T A_o K - 2 A_o^T
// A_c, of each group: S^-1 sees the symmetric part alone.
double Information::variance(const std::vector<Block>& blocks, const Eigen::MatrixXd& schur) const {
  double variance = 0;
  Eigen::Index owned = 0;
  for (const Block& block : blocks) owned += block.own.rows();
  Eigen::MatrixXd k(owned, schur.cols()), b(owned, schur.cols());
  Eigen::Index first = 0;
  for (size_t g = 0; g < blocks.size(); ++g) {
    const Eigen::Index size = blocks[g].own.rows();
    if (size == 0) continue;
    const Eigen::LLT<Eigen::MatrixXd> own(blocks[g].own);
    variance += own.solve(aim_.blocks[g].own).trace();
    auto k_of_group = k.middleRows(first, size);
    k_of_group = own.solve(blocks[g].shared);
    b.middleRows(first, size) =
        aim_.blocks[g].own.lazyProduct(k_of_group) - 2 * aim_.blocks[g].shared;
    first += size;
  }
  Eigen::MatrixXd common = aim_.common;
  common.noalias() += k.transpose() * b;
  return variance + Eigen::LLT<Eigen::MatrixXd>(schur).solve(common).trace();
}

// The values of the candidates, from decompositions of the information that all of them share.
class Information::Values {
 public:
  explicit Values(const Information& information)
      : of_(information), own_(of_.blocks_.size()), schur_(of_.common_) {
    for (size_t g = 0; g < own_.size(); ++g) {
      const Block& block = of_.blocks_[g];
      if (block.own.size() == 0) continue;
      has_own_ = true;
      own_[g].llt.compute(block.own);
      own_[g].shared = own_[g].llt.solve(block.shared).transpose();
      schur_ -= own_[g].shared * block.shared;
    }
    llt_.compute(schur_);
    before_adding_ = log_determinant(llt_);
    if (!is_aimed()) return;
    // If no group has unknowns of its own, the fall is tr((I + P^T P)^-1 P^T V P) (Woodbury).
    if (has_own_)
      variance_before_ = of_.variance(of_.blocks_, schur_);
    else
      aimed_ = llt_.matrixL().solve(llt_.matrixL().solve(of_.aim_.common).transpose());
  }

  // Of the candidates from `begin` on.
  void write(int begin, Eigen::Ref<Eigen::VectorXd> values) const {
    values.setZero();
    Some some{begin, {0}, {}};
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      Eigen::Index rows = some.first.back();
      for (size_t g = 0; g < own_.size(); ++g)
        rows += of_.columns_of(of_.candidates_[g].common, g, begin + static_cast<int>(k)).cols();
      some.first.push_back(rows);
    }
    some.all.resize(of_.common_.cols(), some.first.back());
    write_beside_own(some, values);
    if (is_aimed() && has_own_)
      write_falls_of_variance(some, values);
    else
      write_by_common(some, values);
  }

 private:
  struct Own {
    Eigen::LLT<Eigen::MatrixXd> llt;
    Eigen::MatrixXd shared;  // F^T D^-1
  };
  // Some candidates: G^T of each, its groups side by side.
  struct Some {
    int begin;                        // number of the first one
    std::vector<Eigen::Index> first;  // column of each, and one past
    Eigen::MatrixXd all;

    int count() const { return static_cast<int>(first.size()) - 1; }
    Eigen::Index size(int k) const { return first[k + 1] - first[k]; }
    auto of(int k) const { return all.middleCols(first[k], size(k)); }
  };

  bool is_aimed() const { return !of_.aim_.blocks.empty(); }

  // Writes G^T, and adds log det(I + E D^-1 E^T) of each group to `determinants`.
  void write_beside_own(Some& some, Eigen::Ref<Eigen::VectorXd> determinants) const {
    std::vector<Eigen::Index> next = some.first;
    Eigen::MatrixXd beside, p, gram, inverse;
    Eigen::LLT<Eigen::MatrixXd> root;
    for (size_t g = 0; g < own_.size(); ++g) {
      const std::vector<Eigen::Index>& first = of_.first_[g];
      const Eigen::Index start = first[some.begin];
      const Eigen::Index columns = first[some.begin + some.count()] - start;
      beside = of_.candidates_[g].common.middleCols(start, columns);
      const bool has_own = of_.blocks_[g].own.size() > 0;
      if (has_own) {
        const auto of_own = of_.candidates_[g].own.middleCols(start, columns);
        beside.noalias() -= own_[g].shared.lazyProduct(of_own);
        p = own_[g].llt.matrixL().solve(of_own);
      }
      for (int k = 0; k < some.count(); ++k) {
        const Eigen::Index at = first[some.begin + k] - start;
        const Eigen::Index rows = first[some.begin + k + 1] - start - at;
        if (rows == 0) continue;
        auto part = some.all.middleCols(next[k], rows);
        next[k] += rows;
        if (!has_own) {
          part = beside.middleCols(at, rows);
          continue;
        }
        const auto of_pose = p.middleCols(at, rows);
        gram = of_pose.transpose().lazyProduct(of_pose);
        gram.diagonal().array() += 1;
        root.compute(gram);
        inverse = upper_inverse(root);
        part = beside.middleCols(at, rows).lazyProduct(inverse);
        determinants[k] += log_determinant(root);
      }
    }
  }

  void write_falls_of_variance(const Some& some, Eigen::Ref<Eigen::VectorXd> values) const {
    std::vector<Block> after;
    for (int k = 0; k < some.count(); ++k) {
      after = of_.blocks_;
      for (size_t g = 0; g < own_.size(); ++g) {
        const auto e = of_.columns_of(of_.candidates_[g].own, g, some.begin + k);
        const auto c = of_.columns_of(of_.candidates_[g].common, g, some.begin + k);
        after[g].own += e * e.transpose();
        after[g].shared += e * c.transpose();
      }
      const auto beside_own = some.of(k);
      values[k] =
          variance_before_ - of_.variance(after, schur_ + beside_own * beside_own.transpose());
    }
  }

  // For a candidate of many rows log det(S + G^T G), whose time is linear in them, is cheaper than
  // log det(I + G S^-1 G^T). With an aim all take the latter.
  void write_by_common(Some& some, Eigen::Ref<Eigen::VectorXd> values) const {
    Eigen::MatrixXd gram;
    Eigen::LLT<Eigen::MatrixXd> root;
    std::vector<int> of_few_rows;
    for (int k = 0; k < some.count(); ++k) {
      if (is_aimed() || 3 * some.size(k) <= some.all.rows()) {
        of_few_rows.push_back(k);
        continue;
      }
      gram = schur_;
      gram.selfadjointView<Eigen::Lower>().rankUpdate(some.of(k));
      root.compute(gram);
      values[k] += log_determinant(root) - before_adding_;
    }
    if (of_few_rows.empty()) return;
    llt_.matrixL().solveInPlace(some.all);
    Eigen::MatrixXd seen;
    if (is_aimed()) seen = aimed_ * some.all;
    for (const int k : of_few_rows) {
      const auto one = some.of(k);
      gram = with_identity(one.transpose().lazyProduct(one));
      root.compute(gram);
      values[k] =
          is_aimed()
              ? root.solve(one.transpose() * seen.middleCols(some.first[k], some.size(k))).trace()
              : values[k] + log_determinant(root);
    }
  }

  const Information& of_;
  std::vector<Own> own_;
  bool has_own_ = false;
  Eigen::MatrixXd schur_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  double before_adding_ = 0, variance_before_ = 0;
  Eigen::MatrixXd aimed_;  // V = L^-1 A^T A L^-T
};

Eigen::VectorXd Information::values_of_adding() const {
  const Values of_candidates(*this);
  Eigen::VectorXd values(poses_);
  for_ordered_blocks<int>(
      poses_, kCandidatesPerBlock,
      [&](int begin, int end) {
        of_candidates.write(begin, values.segment(begin, end - begin));
        return 0;
      },
      [](int) {});
  return values;
}

}  // namespace armtrue
