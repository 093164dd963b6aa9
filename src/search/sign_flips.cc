// The null run of the search: sign flips by pose.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "calibration/pose_influence.h"
#include "search/ebic.h"
#include "search/projection.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kRowsAtOnce = 128, kFlipsAtOnce = 256;  // bound the memory of one task
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One sign for each pose and draw, the same for all candidates: poses x flips.
Eigen::MatrixXf random_signs(int poses, int flips, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXf signs(poses, flips);
  for (int f = 0; f < flips; ++f)
    for (int pose = 0; pose < poses; ++pose) signs(pose, f) = random() >> 63 ? 1.0f : -1.0f;
  return signs;
}

}  // namespace

// The residuals e with flipped signs, as the candidates see them, X2^T e = X^T (e - Q Q^T e): they
// are projected off the model once for all candidates.
// float is precise enough for a rank among draws, once the projection was done in double.
struct ProjectedCandidates::Draws {
  Eigen::VectorXd residual;       // e before its signs flip
  Eigen::MatrixXd basis_by_pose;  // of each pose the sum of e_i times row i of Q: poses x rank
  RowMajor<float> slopes;         // X2^T e: columns x flips
  Eigen::RowVectorXf norms;       // |e - Q Q^T e|^2: flips
};

Eigen::VectorXd ProjectedCandidates::leverage_corrected_residual_by_pose() const {
  Eigen::VectorXd residual = fit_.residual();
  const int size = fit_.row_size();
  const GroupedRows rows = grouped_rows(fit_.pose());
  for_ordered_blocks<int>(
      rows.groups(), 32,
      [&](int begin, int end) {
        for (int pose = begin; pose < end; ++pose) {
          std::vector<Eigen::Index> own;
          for (int k = rows.first[pose]; k < rows.first[pose + 1]; ++k)
            for (int axis = 0; axis < size; ++axis)
              own.push_back(static_cast<Eigen::Index>(rows.row[k]) * size + axis);
          residual(own) =
              leverage_corrected_residual(fit_.basis()(own, Eigen::all), residual(own)).eval();
        }
        return 0;
      },
      [](int) {});
  return residual;
}

ProjectedCandidates::Draws ProjectedCandidates::draw(int flips, std::uint64_t seed) const {
  const std::vector<int>& pose_of_row = fit_.pose();
  const int poses = 1 + *std::max_element(pose_of_row.begin(), pose_of_row.end());
  const int size = fit_.row_size();
  Draws draws{leverage_corrected_residual_by_pose(),
              Eigen::MatrixXd::Zero(poses, fit_.basis().cols()),
              RowMajor<float>(slopes_.size(), flips), Eigen::RowVectorXf(flips)};
  // Rows of a pose flip together, so their products are summed before the draws.
  for (int row = 0; row < fit_.rows(); ++row)
    draws.basis_by_pose.row(pose_of_row[row]) +=
        draws.residual.segment(row * size, size).transpose() *
        fit_.basis().middleRows(row * size, size);
  const Eigen::MatrixXf signs = random_signs(poses, flips, seed);
  for (int begin = 0; begin < flips; begin += kFlipsAtOnce)
    draw_block(signs.middleCols(begin, std::min(kFlipsAtOnce, flips - begin)), begin, draws);
  return draws;
}

// The products of some columns with the residual that come from their rests, which are beside the
// model: poses x columns.
Eigen::MatrixXf ProjectedCandidates::pulls_by_pose(const SomeColumns& some,
                                                   Eigen::Index poses) const {
  Eigen::MatrixXf pulls = Eigen::MatrixXf::Zero(poses, some.count);
  const int size = fit_.row_size();
  for (int k = 0; k < some.count; ++k) {
    const auto own = some.values.pulls().col(scan_.value_of_column_[some.first + k]);
    for (int row = 0; row < fit_.rows(); ++row)
      pulls(fit_.pose()[row], k) +=
          static_cast<float>(fit_.jacobian()
                                 .col(some.parameter)
                                 .segment(row * size, size)
                                 .dot(own.segment(row * size, size).cast<double>()));
  }
  return pulls;
}

// Some draws from the `begin`-th on, one for each column of `signs`.
void ProjectedCandidates::draw_block(const Eigen::MatrixXf& signs, int begin, Draws& draws) const {
  const std::vector<int>& pose_of_row = fit_.pose();
  const Eigen::VectorXd& residual = draws.residual;
  const int size = fit_.row_size();
  const Eigen::Index flips = signs.cols();
  const Eigen::MatrixXd on_basis = draws.basis_by_pose.transpose() * signs.cast<double>();
  draws.norms.segment(begin, flips) =
      (residual.squaredNorm() + fit_.replicates().rest.squaredNorm() -
       on_basis.colwise().squaredNorm().array())
          .cast<float>();

  RowMajor<float> flipped(residual.size(), flips);
  for_ordered_blocks<int>(
      fit_.rows(), kRowsAtOnce,
      [&](int first, int last) {
        const Eigen::MatrixXd explained =
            fit_.basis().middleRows(first * size, (last - first) * size) * on_basis;
        for (int k = first * size; k < last * size; ++k)
          flipped.row(k) = (residual[k] * signs.row(pose_of_row[k / size]).cast<double>() -
                            explained.row(k - first * size))
                               .cast<float>();
        return 0;
      },
      [](int) {});

  for_each_product(flipped, [&](const SomeColumns& some, const auto& products) {
    auto slopes = draws.slopes.block(some.first, begin, some.count, flips);
    slopes = products.transpose();
    if (some.values.differ())
      slopes.noalias() += pulls_by_pose(some, signs.rows()).transpose() * signs;
  });
}

// The best score of some candidates in each draw.
Eigen::VectorXd ProjectedCandidates::best_of_block(const Draws& draws, int begin, int end) const {
  const Eigen::Index flips = draws.norms.size();
  const double freedom = fit_.residual_freedom();
  Eigen::VectorXd best = Eigen::VectorXd::Constant(flips, -kInfinity);
  // exp(-best / freedom): tells without a logarithm whether a gain can beat the best score.
  Eigen::VectorXd to_beat = Eigen::VectorXd::Constant(flips, kInfinity);
  for (int candidate = begin; candidate < end; ++candidate) {
    const Solution& solution = solutions_[candidate];
    if (solution.degrees_of_freedom == 0 || take_nearly_all(solution.degrees_of_freedom)) continue;
    if (scan_.candidates_[candidate].only_together) continue;  // no step of a search adds it
    RowMajor<float> slope = RowMajor<float>::Zero(scan_.coefficient_count_[candidate], flips);
    for (const auto& term : scan_.terms_[candidate])
      slope.row(term.coefficient) += draws.slopes.row(term.column);
    // Scaled to columns of unit length: their norms differ by orders of magnitude.
    const Eigen::VectorXd unit = squared_norms_[candidate].cwiseSqrt();
    const Eigen::VectorXd inverse =
        (unit.array() > kMinColumnNorm).select(unit.cwiseInverse(), 0.0);
    slope = inverse.cast<float>().asDiagonal() * slope;
    const Eigen::MatrixXf whitening = (solution.whitening * unit.asDiagonal()).cast<float>();
    Eigen::RowVectorXf gains = Eigen::RowVectorXf::Zero(flips);
    for (const auto& axis : whitening.rowwise())  // too few and short for a blocked product
      gains += axis.lazyProduct(slope).cwiseAbs2();
    const double log_choices = scan_.candidates_[candidate].log_choices;
    const EbicFall fall(is_shrunken(scan_.candidates_[candidate].effect), log_choices,
                        solution.degrees_of_freedom, freedom);
    const double of_choices = std::exp(-2.0 * log_choices / freedom);
    for (Eigen::Index f = 0; f < flips; ++f) {
      if (gains[f] <= draws.norms[f] * (1 - to_beat[f] * of_choices)) continue;
      const double score = fall(gains[f], draws.norms[f]);
      if (score <= best[f]) continue;
      best[f] = score;
      to_beat[f] = std::exp(-score / freedom);
    }
  }
  return best;
}

std::vector<double> ProjectedCandidates::best_of_flipped(int flips, std::uint64_t seed) const {
  const Draws draws = draw(flips, seed);
  Eigen::VectorXd best = Eigen::VectorXd::Constant(flips, -kInfinity);
  for_ordered_blocks<Eigen::VectorXd>(
      static_cast<int>(grams_.size()), kCandidatesPerBlock,
      [&](int begin, int end) { return best_of_block(draws, begin, end); },
      [&](const Eigen::VectorXd& block) { best = best.cwiseMax(block); });
  return {best.begin(), best.end()};
}

}  // namespace armtrue
