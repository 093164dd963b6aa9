#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "diagnosis/change_problem.h"
#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kMaxSteps = 30;

}  // namespace

// The models of all sessions at one x, with a column for each unknown.
struct ChangeProblem::Models {
  Models(const ChangeProblem& problem, const std::vector<Unknown>& unknowns,
         const Eigen::VectorXd& x)
      : models(problem.models_) {
    for (int s = 0; s < models.sessions(); ++s) {
      at.push_back(models.model(s).at(problem.unknowns_of(s, unknowns, x)));
      std::vector<int>& columns = column.emplace_back(unknowns.size(), -1);
      for (size_t i = 0; i < unknowns.size(); ++i)
        if (unknowns[i].acts_in(s)) columns[i] = problem.columns_[s][unknowns[i].parameter];
    }
  }

  // Writes the derivatives of rows of a session, one after the other, then their residuals.
  // `of_model`: room for those of its model.
  void blocks(int session, int first, int count, Eigen::MatrixXd& of_model,
              Eigen::Ref<Eigen::MatrixXd> out) const {
    of_model.resize(out.rows(), models.model(session).unknowns() + 1);
    if (count == 1)
      at[session].block(first, of_model);
    else
      at[session].blocks(first, count, of_model);
    for (size_t i = 0; i < column[session].size(); ++i)
      if (const int from = column[session][i]; from >= 0)
        out.col(i) = of_model.col(from);
      else
        out.col(i).setZero();
    out.rightCols<1>() = of_model.rightCols<1>();
  }

  const SessionModels& models;
  std::vector<ObservationModel::At> at;  // of each session
  std::vector<std::vector<int>> column;  // of its model, by unknown; -1: none
};

// Of `fitted` it reads x; unless the law is Gaussian it sets the weights. `weigh` false: all are 1.
ChangeProblem::Sums ChangeProblem::sums_of(const std::vector<Unknown>& unknowns,
                                           const ReadingLaw& law, bool weigh, Fit& fitted) const {
  constexpr int kRowsAtOnce = 128, kMaxBlocks = 256;
  const Models models(*this, unknowns, fitted.x);
  const Eigen::Index columns = fitted.x.size() + 1;
  const int size = models_.row_size();
  const bool keeps_weights = law.degrees_of_freedom > 0;
  if (keeps_weights) fitted.weights.resize(models_.rows());
  Sums total{Eigen::MatrixXd::Zero(columns, columns), 0};
  for (int s = 0; s < sessions(); ++s) {
    const std::vector<int>& rows_of_session = models_.rows_of(s);
    const auto count = static_cast<int>(rows_of_session.size());
    for_ordered_blocks<Sums>(
        count, std::max(kRowsPerBlock, (count + kMaxBlocks - 1) / kMaxBlocks),
        [&](int begin, int end) {
          Sums sums{Eigen::MatrixXd::Zero(columns, columns), 0};
          Eigen::MatrixXd rows(kRowsAtOnce * size, columns), of_model;
          for (int first = begin; first < end; first += kRowsAtOnce) {
            const int last = std::min(end, first + kRowsAtOnce);
            models.blocks(s, first, last - first, of_model, rows.topRows((last - first) * size));
            for (int own = first; own < last; ++own) {
              const int row = rows_of_session[own];
              auto block = rows.middleRows((own - first) * size, size);
              const double squared_norm = block.rightCols<1>().squaredNorm();
              const double weight = weigh ? law.weight(squared_norm, size) : 1;
              if (keeps_weights) fitted.weights[row] = weight;
              sums.loss += shares_[row] * law.loss(squared_norm, size);
              if (const double factor = shares_[row] * weight; factor != 1)
                block *= std::sqrt(factor);
            }
            sums.products.selfadjointView<Eigen::Upper>().rankUpdate(
                rows.topRows((last - first) * size).transpose());
          }
          return sums;
        },
        [&](const Sums& sums) {
          total.products += sums.products;
          total.loss += sums.loss;
        });
  }
  return total;
}

ChangeProblem::Sums ChangeProblem::part_of(const Sums& all, const std::vector<int>& moved) const {
  std::vector<Eigen::Index> chosen(errors_.size());
  std::iota(chosen.begin(), chosen.end(), 0);
  for (int k : moved)
    for (int i = 0; i < std::ssize(hypotheses_[k].moves); ++i)
      chosen.push_back(first_of_moves_[k] + i);
  chosen.push_back(all.products.cols() - 1);
  return {all.products(chosen, chosen), all.loss};
}

std::vector<ChangeProblem::Unknown> ChangeProblem::all_unknowns() const {
  std::vector<int> all(hypotheses_.size());
  std::iota(all.begin(), all.end(), 0);
  return unknowns_of(all);
}

// K with K x ~ N(0, I): what is known of the unknowns before the readings.
Eigen::MatrixXd ChangeProblem::known_of(const std::vector<Unknown>& unknowns) const {
  const Eigen::Index count = std::ssize(unknowns), errors = correlated_.rows();
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) known(i, i) = 1 / unknowns[i].deviation;
  known.topLeftCorner(errors, errors) = correlated_;
  return known;
}

// The rows of a pose count with weight and share.
void ChangeProblem::complete(const std::vector<int>& moved, Fit& result) const {
  if (result.covariance.size() > 0) return;
  constexpr int kPosesPerBlock = 128, kMaxBlocks = 256;
  const std::vector<Unknown> unknowns = unknowns_of(moved);
  const Eigen::MatrixXd& root = result.root;
  result.covariance = root * root.transpose();
  const Models models(*this, unknowns, result.x);
  const int size = models_.row_size();
  const Eigen::Index count = result.x.size(), height = std::max<Eigen::Index>(256, 2 * count + 2);
  std::vector<std::pair<int, int>> place(models_.rows());  // session, row
  for (int s = 0; s < sessions(); ++s)
    for (int own = 0; own < std::ssize(models_.rows_of(s)); ++own)
      place[models_.rows_of(s)[own]] = {s, own};
  struct PoseSums {
    InfluenceSums influence;
    ChiSquares chi;
  } total;
  for_ordered_blocks<PoseSums>(
      poses(), std::max(kPosesPerBlock, (poses() + kMaxBlocks - 1) / kMaxBlocks),
      [&](int begin, int end) {
        PoseSums sums;
        Eigen::MatrixXd rows(height + size, count + 1), of_model;
        for (int pose = begin; pose < end; ++pose) {
          Eigen::Index filled = 0;
          double equations = 0;
          for (int k = rows_by_pose_.first[pose]; k < rows_by_pose_.first[pose + 1]; ++k) {
            if (filled >= height) {  // many readings: their triangle says the same
              const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows.topRows(filled));
              filled = count + 1;
              rows.topRows(filled) = qr.matrixQR().topRows(filled).triangularView<Eigen::Upper>();
            }
            const int row = rows_by_pose_.row[k];
            auto block = rows.middleRows(filled, size);
            models.blocks(place[row].first, place[row].second, 1, of_model, block);
            const double weight = result.weights.empty() ? 1 : result.weights[row];
            block *= std::sqrt(shares_[row] * weight);
            equations += shares_[row] * size;
            filled += size;
          }
          const Eigen::VectorXd residual = rows.col(count).head(filled);
          sums.influence.add(influence_of_pose(rows.topLeftCorner(filled, count) * root, residual));
          sums.chi.add(ChiSquares::of(residual.squaredNorm(), equations));
        }
        return sums;
      },
      [&](const PoseSums& sums) {
        total.influence.add(sums.influence);
        total.chi.add(sums.chi);
      });
  result.chi_squares = total.chi;
  const Eigen::MatrixXd known = known_of(unknowns) * root;
  result.by_pose =
      root * (total.influence.covariance(1, 1) + known.transpose() * known) * root.transpose();
}

// The sums of the rows and of what is known of the unknowns before.
struct ChangeProblem::Equations {
  Equations(const Sums& sums, const Eigen::MatrixXd& known, const Eigen::VectorXd& x)
      : loss(sums.loss) {
    const Eigen::Index count = x.size();
    const Eigen::MatrixXd upper = sums.products.topLeftCorner(count, count);
    Eigen::MatrixXd information = upper.selfadjointView<Eigen::Upper>();
    Eigen::VectorXd gradient = sums.products.col(count).head(count);
    const Eigen::VectorXd before = known * x;
    information += known.transpose() * known;
    gradient -= known.transpose() * before;
    loss += before.squaredNorm();
    root = inverse_root(information);
    step = root.transpose() * gradient;
  }
  // By which the step lowers the loss, were the model linear and the weights held.
  double promised() const { return step.squaredNorm(); }

  double loss;
  Eigen::MatrixXd root;  // of the inverse information
  Eigen::VectorXd step;  // in the coordinates of the root
};

ChangeProblem::Fit ChangeProblem::fit(const std::vector<int>& moved, const ReadingLaw& law) const {
  constexpr double kSettled = 1e-7;  // of the loss
  const std::vector<Unknown> unknowns = unknowns_of(moved);
  const Eigen::MatrixXd known = known_of(unknowns);
  Fit result;
  result.x = Eigen::VectorXd::Zero(std::ssize(unknowns));
  for (int step = 0;; ++step) {
    // The first step is one of least squares: where a parameter has moved, the residuals before it
    // say nothing about blunders.
    const Equations equations(
        step == 0 ? part_of(at_start_, moved) : sums_of(unknowns, law, true, result), known,
        result.x);
    result.x += equations.root * equations.step;
    if (step == 0) continue;
    // A last step so small that it is as good as linear is not looked at again.
    result.loss = equations.loss - equations.promised();
    result.root = equations.root;
    if (equations.promised() <= kSettled * (1 + equations.loss) || step == kMaxSteps) return result;
  }
}

std::vector<double> ChangeProblem::promised_falls(const ReadingLaw& law, const Fit& nothing) const {
  const std::vector<Unknown> all = all_unknowns();
  Fit there;
  there.x = Eigen::VectorXd::Zero(std::ssize(all));
  there.x.head(nothing.x.size()) = nothing.x;
  const Sums sums = sums_of(all, law, true, there);
  std::vector<double> falls;
  for (int k = 0; k < hypotheses(); ++k) {
    const std::vector<Unknown> unknowns = unknowns_of({k});
    falls.push_back(Equations(part_of(sums, {k}), known_of(unknowns),
                              there.x(Eigen::seqN(0, std::ssize(unknowns))))
                        .promised());
  }
  return falls;
}

}  // namespace armtrue
