#include "calibration/column_choice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/observation.h"
#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kLeftOfColumn = 1e-6;
constexpr double kMinShare = 1e-4;  // that is reported
constexpr int kFirstSession = 0;

// Whether of a column of length `norm` enough is `left` beside the columns kept before it.
bool is_independent(double norm, double left) {
  return norm > 1e-12 && left > kLeftOfColumn * norm;
}

// `place`: among the own parameters of the session.
[[noreturn]] void fail_of_session(const SessionModels& models, const KinematicChain& chain,
                                  int session, Eigen::Index place) {
  const int parameter = models.own(session)[place];
  const std::string readings = models.campaign().source + ": the readings of session '" +
                               models.name(session) + "' do not show ";
  if (parameter < kFirstLinkParameter)
    throw std::invalid_argument(readings +
                                "where its instrument stood; measure more poses in it, or leave it "
                                "out");
  throw std::invalid_argument(
      readings + "its own " + parameter_name(chain, parameter) +
      ", which its own base can imitate; take it out of identify_per_session, or measure more "
      "poses in the session");
}

// (rows * row_size) x unknowns, at x = 0.
Eigen::MatrixXd derivatives_of(const ObservationModel& model) {
  const int size = model.row_size(), unknowns = model.unknowns();
  Eigen::MatrixXd blocks(model.rows() * size, unknowns + 1);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(unknowns));
  for_ordered_blocks<int>(
      model.rows(), kRowsPerBlock,
      [&](int begin, int end) {
        for (int row = begin; row < end; ++row) at.block(row, blocks.middleRows(row * size, size));
        return 0;
      },
      [](int) {});
  return blocks.leftCols(unknowns);
}

// Columns one after another as an orthonormal basis Q and a triangle R, columns = Q R.
class OrthonormalBasis {
 public:
  OrthonormalBasis() = default;
  OrthonormalBasis(Eigen::Index rows, Eigen::Index columns)
      : basis_(rows, columns), triangle_(Eigen::MatrixXd::Zero(columns, columns)) {}

  int rank() const { return rank_; }
  Eigen::Index rows() const { return basis_.rows(); }
  auto basis() const { return basis_.leftCols(rank_); }

  // Takes from `column` its part in the span; returns the coordinates of the part.
  Eigen::VectorXd remove_from(Eigen::Ref<Eigen::VectorXd> column) const {
    const Eigen::VectorXd part = basis().transpose() * column;
    column -= basis() * part;
    return part;
  }
  // The same, twice: the second time removes rounding errors.
  Eigen::VectorXd remove_well_from(Eigen::Ref<Eigen::VectorXd> column) const {
    Eigen::VectorXd part = remove_from(column);
    return part + remove_from(column);
  }
  // `left`: of a column without its part of coordinates `part`.
  void add(const Eigen::VectorXd& part, const Eigen::VectorXd& left) {
    triangle_.col(rank_).head(rank_) = part;
    triangle_(rank_, rank_) = left.norm();
    basis_.col(rank_) = left.normalized();
    ++rank_;
  }
  // How much of each column makes up the part of coordinates `part`.
  Eigen::VectorXd shares(const Eigen::VectorXd& part) const {
    return triangle_.topLeftCorner(rank_, rank_).triangularView<Eigen::Upper>().solve(part);
  }

 private:
  Eigen::MatrixXd basis_, triangle_;
  int rank_ = 0;
};

// The triangle of `rows` and of the rows of `triangle`.
Eigen::MatrixXd folded(const Eigen::MatrixXd& triangle, const Eigen::MatrixXd& rows) {
  if (triangle.cols() == 0) return triangle;
  Eigen::MatrixXd stacked(triangle.rows() + rows.rows(), triangle.cols());
  stacked << triangle, rows;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  return qr.matrixQR().topRows(triangle.cols()).triangularView<Eigen::Upper>();
}

class ColumnChoice {
 public:
  ColumnChoice(const SessionModels& models, const KinematicChain& chain);
  IdentifiableSet choose();

 private:
  // The own columns of some rows: those of a session, or of a target.
  struct Own {
    std::vector<int> parameters;  // of those in the basis; empty of a session
    Eigen::Index first_row;
    OrthonormalBasis basis;
  };
  // A column that any row may have.
  struct Column {
    int parameter;
    int session;         // kFirstSession, or the further one whose own parameter it is
    Eigen::Index place;  // among the own parameters of that session
    Eigen::VectorXd derivatives;
  };
  struct TargetRows {
    Eigen::Index first_row = 0, rows = 0;
    std::vector<int> parameters;
    Eigen::MatrixXd derivatives;  // rows x parameters
  };

  void read_group(int group, Eigen::Index top, std::map<std::pair<int, int>, Column>& columns);
  void test(const Column& column);
  void choose_targets();
  void choose_target(const TargetRows& target, const Eigen::MatrixXd& head,
                     const Eigen::MatrixXd& later, Eigen::MatrixXd& before);
  bool is_shown(int parameter, double left) const;
  Eigen::VectorXd remove_own(Eigen::Ref<Eigen::VectorXd> column) const;
  Eigen::VectorXd project(Eigen::VectorXd& column, Eigen::VectorXd& part) const;
  void keep(const Column& column, const Eigen::VectorXd& of_own, const Eigen::VectorXd& part,
            const Eigen::VectorXd& left);
  void absorb(int parameter, std::vector<std::pair<int, double>> shares);
  int rank() const { return common_.rank() + rank_of_own_; }

  const SessionModels& models_;
  const KinematicChain& chain_;
  Eigen::Index rows_;
  std::vector<Column> columns_;  // in the order in which they are tested
  std::map<int, TargetRows> targets_;
  std::vector<Own> own_;
  int rank_of_own_ = 0;
  OrthonormalBasis common_;  // of columns that are kept, without what rows have of their own
  std::vector<const Column*> kept_;      // in the order of the basis
  std::vector<Eigen::VectorXd> in_own_;  // coordinates of each of them in the bases `own_`
  IdentifiableSet set_;
};

bool is_place_of_target(const KinematicChain& chain, int parameter) {
  return parameter >= layout_of(chain).targets && parameter < first_anchor_parameter(chain);
}

ColumnChoice::ColumnChoice(const SessionModels& models, const KinematicChain& chain)
    : models_(models), chain_(chain), rows_(Eigen::Index{models.rows()} * models.row_size()) {
  // Rows of a target lie together, of whatever session they are.
  std::vector<int> groups(models.groups());
  for (int g = 0; g < models.groups(); ++g) groups[g] = g;
  std::ranges::stable_sort(groups, {}, [&](int group) { return models.target_of(group); });
  std::map<std::pair<int, int>, Column> columns;  // by session and place
  Eigen::Index top = 0;
  for (int group : groups) {
    read_group(group, top, columns);
    top += Eigen::Index{models.model(group).rows()} * models.row_size();
  }
  for (auto& [key, column] : columns)
    if (column.session != kFirstSession) columns_.push_back(std::move(column));
  for (auto& [key, column] : columns)
    if (column.session == kFirstSession) columns_.push_back(std::move(column));
  common_ = OrthonormalBasis(rows_, std::ssize(columns_));
}

void ColumnChoice::read_group(int group, Eigen::Index top,
                              std::map<std::pair<int, int>, Column>& columns) {
  const Eigen::MatrixXd derivatives = derivatives_of(models_.model(group));
  const int session = models_.session_of(group), first_own = models_.first_own(1);
  Eigen::Index taken = 0;
  for (const SessionModels::Run& run : models_.runs(group)) {
    const auto own = derivatives.middleCols(taken, run.count);
    taken += run.count;
    const bool is_of_session = run.first >= first_own;
    const int parameter = is_of_session ? 0 : models_.geometric()[run.first];
    if (models_.is_split_by_target() && !is_of_session && is_place_of_target(chain_, parameter)) {
      TargetRows& target = targets_[models_.target_of(group)];
      if (target.rows == 0) target.first_row = top;
      target.rows += own.rows();
      target.derivatives.conservativeResize(target.rows, run.count);
      target.derivatives.bottomRows(own.rows()) = own;
      target.parameters.assign(models_.geometric().begin() + run.first,
                               models_.geometric().begin() + run.first + run.count);
    } else if (is_of_session && !models_.is_split_by_target()) {
      OrthonormalBasis basis(own.rows(), run.count);
      for (Eigen::Index k = 0; k < run.count; ++k) {
        Eigen::VectorXd left = own.col(k);
        const Eigen::VectorXd part = basis.remove_well_from(left);
        if (k >= own.rows() || !is_independent(own.col(k).norm(), left.norm()))
          fail_of_session(models_, chain_, session, k);
        basis.add(part, left);
      }
      rank_of_own_ += basis.rank();
      own_.push_back({{}, top, std::move(basis)});
    } else {
      for (int k = 0; k < run.count; ++k) {
        const int owner = is_of_session ? session : kFirstSession;
        Column& column = columns[{owner, run.first + k}];
        if (column.derivatives.size() == 0)
          column = {is_of_session ? -1 : models_.geometric()[run.first + k], owner, k,
                    Eigen::VectorXd::Zero(rows_)};
        column.derivatives.segment(top, own.rows()) = own.col(k);
      }
    }
  }
}

// Returns the coordinates of the part that rows have of their own, basis after basis.
Eigen::VectorXd ColumnChoice::remove_own(Eigen::Ref<Eigen::VectorXd> column) const {
  Eigen::VectorXd parts(rank_of_own_);
  Eigen::Index taken = 0;
  for (const Own& own : own_) {
    parts.segment(taken, own.basis.rank()) =
        own.basis.remove_from(column.segment(own.first_row, own.basis.rows()));
    taken += own.basis.rank();
  }
  return parts;
}

// Projects `column` off the columns kept so far. Returns its coordinates in the own bases of rows,
// and sets those in the common basis.
Eigen::VectorXd ColumnChoice::project(Eigen::VectorXd& column, Eigen::VectorXd& part) const {
  Eigen::VectorXd of_own = Eigen::VectorXd::Zero(rank_of_own_);
  part = Eigen::VectorXd::Zero(common_.rank());
  for (int twice = 0; twice < 2; ++twice) {  // the second time removes rounding errors
    of_own += remove_own(column);
    part += common_.remove_from(column);
  }
  return of_own;
}

void ColumnChoice::keep(const Column& column, const Eigen::VectorXd& of_own,
                        const Eigen::VectorXd& part, const Eigen::VectorXd& left) {
  common_.add(part, left);
  kept_.push_back(&column);
  in_own_.push_back(of_own);
}

void ColumnChoice::absorb(int parameter, std::vector<std::pair<int, double>> shares) {
  std::erase_if(shares, [](const auto& share) { return !(std::abs(share.second) > kMinShare); });
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) {
    return std::round(std::abs(a.second) * 1e6) >  // equal shares keep their order
           std::round(std::abs(b.second) * 1e6);
  });
  set_.absorbed.push_back({parameter, std::move(shares)});
}

// A place of the tool that the readings determine worse than a ruler would is chance, and no prior
// holds it: a tool that is vertical but for rounding may have any length.
bool ColumnChoice::is_shown(int parameter, double left) const {
  constexpr int kAxes = 3;
  constexpr double kOpen = 0.1;           // m, standard deviation
  constexpr double kTypicalNoise = 1e-4;  // m, where none is stated
  const int axis = parameter - layout_of(chain_).tool;
  if (axis < 0 || axis >= kAxes) return true;
  const double stated = models_.noise().position, noise = stated > 0 ? stated : kTypicalNoise;
  return models_.sigma().position * left * kOpen > noise;
}

void ColumnChoice::test(const Column& column) {
  Eigen::VectorXd left = column.derivatives, part;
  const double norm = left.norm();
  Eigen::VectorXd of_own = project(left, part);
  if (is_independent(norm, left.norm()) && is_shown(column.parameter, left.norm()) &&
      rank() < rows_) {
    keep(column, of_own, part, left);
    if (column.session == kFirstSession) set_.kept.push_back(column.parameter);
    return;
  }
  if (column.session != kFirstSession)
    fail_of_session(models_, chain_, column.session, column.place);
  std::vector<std::pair<int, double>> shares;
  if (norm > 1e-12) {
    const Eigen::VectorXd of_kept = common_.shares(part);
    for (size_t k = 0; k < kept_.size(); ++k) {
      const double share = of_kept[k];
      of_own -= share * in_own_[k];
      if (kept_[k]->session == kFirstSession) shares.emplace_back(kept_[k]->parameter, share);
    }
    Eigen::Index taken = 0;
    for (const Own& own : own_) {
      const Eigen::VectorXd of_target = own.basis.shares(of_own.segment(taken, own.basis.rank()));
      taken += own.basis.rank();
      for (size_t k = 0; k < own.parameters.size(); ++k)
        shares.emplace_back(own.parameters[k], of_target[k]);
    }
  }
  absorb(column.parameter, std::move(shares));
}

// `head`: the columns kept so far, in all rows. `later`: their triangle in the rows of the targets
// after this one. `before`: in those of the targets before it, without their part; this target's
// rows are added.
void ColumnChoice::choose_target(const TargetRows& target, const Eigen::MatrixXd& head,
                                 const Eigen::MatrixXd& later, Eigen::MatrixXd& before) {
  const Eigen::Index columns = head.cols();
  const Eigen::Index count = target.parameters.size();
  Eigen::MatrixXd of_head = head.middleRows(target.first_row, target.rows);
  Eigen::MatrixXd stacked(2 * columns + target.rows, columns);
  stacked << before, of_head, later;
  OrthonormalBasis all(stacked.rows(), columns + count), alone(target.rows, count);
  for (Eigen::Index k = 0; k < columns; ++k) {
    Eigen::VectorXd left = stacked.col(k);
    const Eigen::VectorXd part = all.remove_well_from(left);
    all.add(part, left);
  }
  Own own{{}, target.first_row, {}};
  for (Eigen::Index k = 0; k < count; ++k) {
    const double norm = target.derivatives.col(k).norm();
    Eigen::VectorXd left = Eigen::VectorXd::Zero(stacked.rows());
    left.segment(columns, target.rows) = target.derivatives.col(k);
    const Eigen::VectorXd part = all.remove_well_from(left);
    if (is_independent(norm, left.norm()) && rank() + alone.rank() < rows_) {
      all.add(part, left);
      Eigen::VectorXd left_alone = target.derivatives.col(k);
      const Eigen::VectorXd part_alone = alone.remove_well_from(left_alone);
      alone.add(part_alone, left_alone);
      own.parameters.push_back(target.parameters[k]);
      set_.kept.push_back(own.parameters.back());
      continue;
    }
    std::vector<std::pair<int, double>> shares;
    if (norm > 1e-12) {
      const Eigen::VectorXd of_all = all.shares(part);
      for (Eigen::Index c = 0; c < columns; ++c)
        if (const Column& kept = *kept_[c]; kept.session == kFirstSession)
          shares.emplace_back(kept.parameter, of_all[c]);
      // The targets before it take from its readings what those columns add to theirs.
      for (const Own& other : own_) {
        const Eigen::VectorXd moved =
            -head.middleRows(other.first_row, other.basis.rows()) * of_all.head(columns);
        const Eigen::VectorXd taken = other.basis.shares(other.basis.basis().transpose() * moved);
        for (size_t c = 0; c < other.parameters.size(); ++c)
          shares.emplace_back(other.parameters[c], taken[c]);
      }
      for (size_t c = 0; c < own.parameters.size(); ++c)
        shares.emplace_back(own.parameters[c], of_all[columns + c]);
    }
    absorb(target.parameters[k], std::move(shares));
  }
  const Eigen::MatrixXd on_basis = alone.basis().transpose() * of_head;
  of_head -= alone.basis() * on_basis;
  before = folded(before, of_head);
  rank_of_own_ += alone.rank();
  own.basis = std::move(alone);
  own_.push_back(std::move(own));
}

void ColumnChoice::choose_targets() {
  Eigen::MatrixXd head(rows_, std::ssize(kept_));
  for (size_t k = 0; k < kept_.size(); ++k) head.col(k) = kept_[k]->derivatives;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(head.cols(), head.cols());
  std::vector<Eigen::MatrixXd> later{none};  // of the last target first
  for (auto target = targets_.rbegin(); target != targets_.rend(); ++target)
    later.push_back(
        folded(later.back(), head.middleRows(target->second.first_row, target->second.rows)));
  Eigen::MatrixXd before = none;
  for (const auto& [number, target] : targets_) {
    later.pop_back();
    choose_target(target, head, later.back(), before);
  }
  // The columns kept before, without what the targets can imitate of them.
  const std::vector<const Column*> kept = std::exchange(kept_, {});
  in_own_.clear();
  common_ = OrthonormalBasis(rows_, std::ssize(columns_));
  for (const Column* column : kept) {
    Eigen::VectorXd left = column->derivatives, part;
    const Eigen::VectorXd of_own = project(left, part);
    keep(*column, of_own, part, left);
  }
}

IdentifiableSet ColumnChoice::choose() {
  std::map<int, const Column*> by_parameter;
  for (const Column& column : columns_)
    if (column.session == kFirstSession)
      by_parameter[column.parameter] = &column;
    else
      test(column);
  bool targets_are_chosen = false;
  for (int parameter : models_.geometric()) {
    if (const auto found = by_parameter.find(parameter); found != by_parameter.end()) {
      test(*found->second);
      continue;
    }
    if (!std::exchange(targets_are_chosen, true)) choose_targets();
    if (!targets_.contains((parameter - layout_of(chain_).targets) / 3)) absorb(parameter, {});
  }
  std::ranges::sort(set_.kept);
  return std::move(set_);
}

}  // namespace

IdentifiableSet choose_columns(const SessionModels& models, const KinematicChain& chain) {
  return ColumnChoice(models, chain).choose();
}

}  // namespace armtrue
