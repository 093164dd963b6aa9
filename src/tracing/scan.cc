#include "tracing/scan.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <string>

#include "calibration/pose_influence.h"
#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

using RowMajorXf = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A whitened column below this is a driver that did not move but for rounding: no length or angle
// that could be told by it is possible, and its inverse is no number.
constexpr double kMinNorm = 1e-10;
// Less than this of a candidate's own norm left after projection is rounding, not evidence.
constexpr double kMinLeft = 1e-5;
// A direction among a candidate's columns that is less than this (squared) of its largest.
// Of many coefficients some combination is always weak, and would take any value.
constexpr double kMinDirection = 1e-6, kMinOfFineCurve = 1e-4;
constexpr int kCandidatesPerBlock = 64;
constexpr double kPossibleVariation = 0.02;  // m or rad: a larger one is no effect but a mistake
constexpr double kSameScore = 0.01;          // EBIC; less is rounding and the end of an iteration

// What decides the values of a candidate in every context.
std::string value_key(const Effect& effect) {
  const Shape& shape = effect.shape;
  std::string key = to_string(effect.driver) + "|" + to_string(shape) + "|" +
                    std::to_string(static_cast<int>(shape.basis)) + "|" +
                    std::to_string(shape.count) + "|" + std::to_string(shape.at) + "|" +
                    std::to_string(shape.tau) + "|" + std::to_string(shape.low[0]) + "|" +
                    std::to_string(shape.high[0]) + "|" + std::to_string(shape.low[1]) + "|" +
                    std::to_string(shape.high[1]);
  if (effect.driver.kind == DriverKind::moment || effect.driver.involves(DriverKind::force))
    key += "|" + effect.parameter;
  return key;
}

bool same(const Context& a, const Context& b) {
  return a.q == b.q && a.arrival == b.arrival && a.time_s == b.time_s &&
         a.payload_kg == b.payload_kg && a.motor_torque_nm == b.motor_torque_nm &&
         a.force_n == b.force_n && a.temperature_c == b.temperature_c;
}

}  // namespace

CandidateScan::CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                             const Campaign& campaign) {
  std::vector<Context> moments;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Context context = campaign.context(row);
    if (moments.empty() || !same(context, moments.back())) moments.push_back(context);
    moment_of_row_.push_back(static_cast<int>(moments.size()) - 1);
  }

  std::vector<BoundEffect> sources;  // of values, each once
  std::vector<int> first_value;      // of each source
  int value_count = 0;
  std::map<std::string, int> source_of_key;
  std::vector<std::map<int, int>> column_of_value(kTargetParameters);
  for (const Candidate& candidate : candidates) {
    BoundEffect bound(candidate.effect, robot, campaign.temperature_names);
    const auto [place, is_new] =
        source_of_key.try_emplace(value_key(candidate.effect), static_cast<int>(sources.size()));
    if (is_new) {
      first_value.push_back(value_count);
      value_count += bound.value_count();
    }
    std::vector<Term> terms;
    for (const BoundEffect::Term& term : bound.terms()) {
      const int value = first_value[place->second] + term.value;
      column_of_value[term.parameter].try_emplace(value, 0);
      terms.push_back({term.coefficient, term.parameter, value});  // the column is filled in below
    }
    candidates_.push_back(candidate);
    terms_.push_back(std::move(terms));
    coefficient_count_.push_back(bound.coefficient_count());
    if (is_new) sources.push_back(std::move(bound));
  }
  for (auto& columns : column_of_value) {
    first_column_.push_back(static_cast<int>(value_of_column_.size()));
    for (auto& [value, column] : columns) {
      column = static_cast<int>(value_of_column_.size());
      value_of_column_.push_back(value);
    }
  }
  first_column_.push_back(static_cast<int>(value_of_column_.size()));
  for (auto& terms : terms_)
    for (Term& term : terms) term.column = column_of_value[term.parameter][term.column];

  bool needs_frames = false, needs_jacobian = false;
  for (const BoundEffect& source : sources) {
    needs_frames |= source.needs_frames();
    needs_jacobian |= source.needs_jacobian();
  }
  const ChainEvaluator chain(robot.chain);
  values_.resize(static_cast<int>(moments.size()), value_count);
  for_ordered_blocks<int>(
      static_cast<int>(moments.size()), 64,
      [&](int begin, int end) {
        Eigen::VectorXd values(value_count);
        ArmFrames frames;
        PoseJacobian jacobian;
        for (int moment = begin; moment < end; ++moment) {
          if (needs_frames) frames = chain.link_frames(moments[moment].q);
          if (needs_jacobian) chain.pose(moments[moment].q, jacobian);
          for (size_t s = 0; s < sources.size(); ++s)
            sources[s].values(moments[moment], &frames, &jacobian, values.data() + first_value[s]);
          values_.row(moment) = values.cast<float>();
        }
        return 0;
      },
      [](int) {});
}

Eigen::MatrixXd CandidateScan::columns(const Linearization& fit, int candidate) const {
  const int size = fit.row_size();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(fit.rows() * size, coefficient_count_[candidate]);
  for (const Term& term : terms_[candidate]) {
    const auto values = values_.col(value_of_column_[term.column]);
    for (int row = 0; row < fit.rows(); ++row)
      columns.col(term.coefficient).segment(row * size, size) +=
          static_cast<double>(values[moment_of_row_[row]]) *
          fit.jacobian().col(term.parameter).segment(row * size, size);
  }
  return columns;
}

double CandidateScan::variation(int candidate, const Eigen::VectorXd& coefficients) const {
  std::map<int, Eigen::VectorXd> offsets;
  for (const Term& term : terms_[candidate]) {
    auto& offset =
        offsets.try_emplace(term.parameter, Eigen::VectorXd::Zero(values_.rows())).first->second;
    offset +=
        coefficients[term.coefficient] * values_.col(value_of_column_[term.column]).cast<double>();
  }
  double largest = 0;
  for (const auto& [parameter, offset] : offsets) {
    // The model has no constant that takes up the mean of a scale.
    const double constant = parameter == kInstrumentScale ? 0 : offset.mean();
    largest = std::max(largest, std::sqrt((offset.array() - constant).square().mean()));
  }
  return largest;
}

bool CandidateScan::is_possible(int candidate, const Eigen::VectorXd& coefficients) const {
  if (candidates_[candidate].only_positive && coefficients.size() == 1 && coefficients[0] <= 0)
    return false;
  return variation(candidate, coefficients) < kPossibleVariation;
}

std::vector<int> best_first(const std::vector<CandidateScore>& scores) {
  std::vector<int> order(scores.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::round(scores[a].score / kSameScore) > std::round(scores[b].score / kSameScore);
  });
  return order;
}

// Sums over the rows of each moment of d(row)/d(parameter) . columns(row): moments x columns.
template <typename Columns>
Eigen::MatrixXd ProjectedCandidates::moment_sums(int parameter, const Columns& columns) const {
  const int size = fit_.row_size();
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(columns.cols(), scan_.values_.rows());
  const auto derivative = fit_.jacobian().col(parameter);
  for (int row = 0; row < fit_.rows(); ++row)
    for (int axis = 0; axis < size; ++axis)
      if (derivative[row * size + axis] != 0)
        sums.col(scan_.moment_of_row_[row]) +=
            derivative[row * size + axis] * columns.row(row * size + axis).transpose();
  return sums.transpose();
}

ProjectedCandidates::ProjectedCandidates(const CandidateScan& scan, const Linearization& fit)
    : scan_(scan),
      fit_(fit),
      on_basis_(fit.basis().cols(), static_cast<int>(scan.value_of_column_.size())),
      slopes_(static_cast<int>(scan.value_of_column_.size())),
      grams_(scan.candidates_.size()) {
  const int moments = static_cast<int>(scan.values_.rows());
  // Transposed once, so that the rows of a reading lie side by side.
  Eigen::MatrixXd target(fit.basis().rows(), fit.basis().cols() + 1);
  target << fit.basis(), fit.residual();
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_row = target;
  std::vector<Eigen::VectorXd> squares(kTargetParameters);
  for_ordered_blocks<int>(
      kTargetParameters, 1,
      [&](int parameter, int) {
        const int first = scan.first_column_[parameter];
        const int count = scan.first_column_[parameter + 1] - first;
        if (count == 0) return 0;
        const Eigen::MatrixXd sums = moment_sums(parameter, by_row);
        const Eigen::Index rank = fit.basis().cols();
        for (int begin = 0; begin < count; begin += 256) {
          const int end = std::min(count, begin + 256);
          Eigen::MatrixXd values(moments, end - begin);
          for (int k = begin; k < end; ++k)
            values.col(k - begin) =
                scan.values_.col(scan.value_of_column_[first + k]).cast<double>();
          on_basis_.middleCols(first + begin, end - begin).noalias() =
              sums.leftCols(rank).transpose() * values;
          slopes_.segment(first + begin, end - begin).noalias() =
              values.transpose() * sums.col(rank);
        }
        squares[parameter] = Eigen::VectorXd::Zero(moments);
        for (int row = 0; row < fit.rows(); ++row)
          squares[parameter][scan.moment_of_row_[row]] +=
              fit.jacobian()
                  .col(parameter)
                  .segment(row * fit.row_size(), fit.row_size())
                  .squaredNorm();
        return 0;
      },
      [](int) {});

  for_ordered_blocks<int>(
      static_cast<int>(scan.candidates_.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          const auto& terms = scan.terms_[candidate];
          const int k = scan.coefficient_count_[candidate];
          const bool one_parameter = std::all_of(terms.begin(), terms.end(), [&](const auto& term) {
            return term.parameter == terms.front().parameter;
          });
          if (!one_parameter) {
            const Eigen::MatrixXd whole = scan.columns(fit, candidate);
            grams_[candidate].noalias() = whole.transpose() * whole;
            continue;
          }
          Eigen::MatrixXd values(moments, k);
          for (const auto& term : terms)
            values.col(term.coefficient) =
                scan.values_.col(scan.value_of_column_[term.column]).cast<double>();
          grams_[candidate].noalias() =
              values.transpose() * squares[terms.front().parameter].asDiagonal() * values;
        }
        return 0;
      },
      [](int) {});
}

Eigen::MatrixXd ProjectedCandidates::on_basis(int candidate) const {
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(on_basis_.rows(), scan_.coefficient_count_[candidate]);
  for (const auto& term : scan_.terms_[candidate])
    result.col(term.coefficient) += on_basis_.col(term.column);
  return result;
}

ProjectedCandidates::Solution ProjectedCandidates::solve(int candidate,
                                                         const Eigen::MatrixXd& projected,
                                                         const Eigen::MatrixXd& returned) const {
  const int k = scan_.coefficient_count_[candidate];
  Eigen::MatrixXd gram = grams_[candidate];
  const Eigen::VectorXd own = gram.diagonal();
  gram.noalias() -= projected.transpose() * projected;
  if (returned.size() > 0) gram.noalias() += returned.transpose() * returned;

  // Principal directions, in units of what is left of each column; what is next to nothing of the
  // largest is left out.
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(k);
  double most_left = 0;
  for (int c = 0; c < k; ++c) {
    if (own[c] <= kMinNorm * kMinNorm) continue;
    const double left = std::sqrt(std::max(0.0, gram(c, c)) / own[c]);
    most_left = std::max(most_left, left);
    if (left >= kMinLeft) unit[c] = 1 / std::sqrt(gram(c, c));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit.asDiagonal() * gram *
                                                             unit.asDiagonal());
  const Eigen::VectorXd& values = eigen.eigenvalues();  // smallest first
  const double share = scan_.candidates_[candidate].fine ? kMinOfFineCurve : kMinDirection;
  const auto rank = (values.array() > share * values[k - 1]).count();
  return {values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal() *
              eigen.eigenvectors().rightCols(rank).transpose() * unit.asDiagonal(),
          static_cast<int>(rank), most_left};
}

// BIC charges ln n for a coefficient, as if each were as likely to be large as one equation leaves
// it: too much for the six components of a base or tool, of which one cause moves a few much and
// the rest little. Under the normal prior of the width that makes the readings most likely, at most
// BIC's, they cost k (1 + ln(fall / k)) (local empirical Bayes of Liang et al., JASA 103, 2008). A
// curve on one parameter has no such excuse: what its coefficients chase cheaply is blunders.
double ProjectedCandidates::ebic_fall(const std::string& parameter, double log_choices,
                                      int degrees_of_freedom, double gain,
                                      double residual_norm) const {
  if (degrees_of_freedom == 0) return -std::numeric_limits<double>::infinity();
  const double left = std::max(1e-12, 1.0 - gain / residual_norm);
  const double fall = -fit_.residual_freedom() * std::log(left);
  const double k = degrees_of_freedom;
  double charge = k * std::log(fit_.residual_freedom());
  if (is_group(parameter))
    charge = std::min(charge, fall <= k ? fall : k * (1 + std::log(fall / k)));
  return fall - charge - 2.0 * log_choices;
}

std::vector<CandidateScore> ProjectedCandidates::scores(const Linearization::Loss& loss,
                                                        bool with_residual) const {
  const double norm = (with_residual ? fit_.residual_norm() : 0.0) + loss.residual.squaredNorm();
  std::vector<CandidateScore> scores(scan_.candidates_.size());
  for_ordered_blocks<int>(
      static_cast<int>(scores.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          const Eigen::MatrixXd projected = on_basis(candidate);
          const Eigen::MatrixXd returned = loss.span.transpose() * projected;
          const Solution solution = solve(candidate, projected, returned);
          Eigen::VectorXd slope = returned.transpose() * loss.residual;
          if (with_residual)
            for (const auto& term : scan_.terms_[candidate])
              slope[term.coefficient] += slopes_[term.column];
          CandidateScore& score = scores[candidate];
          score.degrees_of_freedom = solution.degrees_of_freedom;
          score.left = solution.left;
          const Eigen::VectorXd whitened = solution.whitening * slope;
          score.coefficients = solution.whitening.transpose() * whitened;
          score.gain = whitened.squaredNorm();
          const Candidate& of = scan_.candidates_[candidate];
          score.score = ebic_fall(of.effect.parameter, of.log_choices, score.degrees_of_freedom,
                                  score.gain, norm);
        }
        return 0;
      },
      [](int) {});
  return scores;
}

std::vector<CandidateScore> ProjectedCandidates::scores() const {
  return scores({Eigen::MatrixXd(fit_.basis().cols(), 0), Eigen::VectorXd(0)}, true);
}

std::vector<CandidateScore> ProjectedCandidates::scores_without(
    const std::vector<int>& effects) const {
  return scores(fit_.without(effects), true);
}

std::vector<CandidateScore> ProjectedCandidates::imitations(int effect) const {
  const Linearization::Loss loss = fit_.without({effect});
  const double whole = std::max(1e-300, loss.residual.squaredNorm());
  std::vector<CandidateScore> imitations = scores(loss, false);
  for (CandidateScore& one : imitations) one.gain = std::clamp(one.gain / whole, 0.0, 1.0);
  return imitations;
}

Eigen::MatrixXd ProjectedCandidates::directions(int candidate) const {
  const Eigen::MatrixXd projected = on_basis(candidate);
  const Eigen::MatrixXd own = scan_.columns(fit_, candidate) - fit_.basis() * projected;
  return own * solve(candidate, projected, {}).whitening.transpose();
}

CandidateScore ProjectedCandidates::score_of(const std::vector<int>& effects,
                                             const std::string& parameter,
                                             double log_choices) const {
  const Linearization::Loss loss = fit_.without(effects);
  CandidateScore score;
  score.degrees_of_freedom = static_cast<int>(loss.span.cols());
  score.gain = loss.residual.squaredNorm();
  score.score = ebic_fall(parameter, log_choices, score.degrees_of_freedom, score.gain,
                          fit_.residual_norm() + score.gain);
  return score;
}

// The fit has bent itself to the residual, and bends itself to every draw anew. So what it took is
// given back first, pose by pose: draws of the bare residual would scatter too little, the more so
// the fewer the poses and the more alike the readings of a pose err.
Eigen::VectorXd ProjectedCandidates::leverage_corrected_residual_by_pose() const {
  Eigen::VectorXd residual = fit_.residual();
  const int size = fit_.row_size();
  const RowsByPose rows = rows_by_pose(fit_.pose());
  for_ordered_blocks<int>(
      rows.poses(), 32,
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

std::vector<double> ProjectedCandidates::best_of_flipped(int flips, std::uint64_t seed) const {
  const Eigen::VectorXd residual = leverage_corrected_residual_by_pose();
  // One sign for each pose in each draw; the same for every candidate. What flips together is
  // summed first. A rank among draws needs no more digits than float has, once the projection has
  // been done in double.
  const std::vector<int>& pose_of_row = fit_.pose();
  const int poses = 1 + *std::max_element(pose_of_row.begin(), pose_of_row.end());
  std::vector<int> pose_of_moment(scan_.values_.rows());
  for (int row = 0; row < fit_.rows(); ++row)
    pose_of_moment[scan_.moment_of_row_[row]] = pose_of_row[row];
  std::mt19937_64 random(seed);
  Eigen::MatrixXf signs(poses, flips);
  for (int f = 0; f < flips; ++f)
    for (int pose = 0; pose < poses; ++pose) signs(pose, f) = random() >> 63 ? 1.0f : -1.0f;

  const int size = fit_.row_size();
  Eigen::MatrixXd basis_by_pose = Eigen::MatrixXd::Zero(poses, fit_.basis().cols());
  for (int row = 0; row < fit_.rows(); ++row)
    basis_by_pose.row(pose_of_row[row]) +=
        residual.segment(row * size, size).transpose() * fit_.basis().middleRows(row * size, size);
  const Eigen::MatrixXf flipped_on_basis = basis_by_pose.transpose().cast<float>() * signs;
  const Eigen::RowVectorXf norms =
      static_cast<float>(residual.squaredNorm()) - flipped_on_basis.colwise().squaredNorm().array();

  // Of every column, its product with every draw of the residual.
  RowMajorXf slopes(slopes_.size(), flips);
  for_ordered_blocks<int>(
      kTargetParameters, 1,
      [&](int parameter, int) {
        const int first = scan_.first_column_[parameter];
        const int count = scan_.first_column_[parameter + 1] - first;
        if (count == 0) return 0;
        const Eigen::VectorXd products = moment_sums(parameter, residual);
        for (int begin = 0; begin < count; begin += 256) {
          const int width = std::min(256, count - begin);
          Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, width);
          for (int k = 0; k < width; ++k) {
            const auto values = scan_.values_.col(scan_.value_of_column_[first + begin + k]);
            for (int moment = 0; moment < values.size(); ++moment)
              by_pose(pose_of_moment[moment], k) +=
                  static_cast<double>(values[moment]) * products[moment];
          }
          by_pose.noalias() -= basis_by_pose * on_basis_.middleCols(first + begin, width);
          slopes.middleRows(first + begin, width).noalias() =
              by_pose.transpose().cast<float>() * signs;
        }
        return 0;
      },
      [](int) {});

  Eigen::VectorXd best = Eigen::VectorXd::Constant(flips, -std::numeric_limits<double>::infinity());
  for_ordered_blocks<Eigen::VectorXd>(
      static_cast<int>(grams_.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        Eigen::VectorXd block_best =
            Eigen::VectorXd::Constant(flips, -std::numeric_limits<double>::infinity());
        // exp(-best / freedom): what a gain must at least reach is known without its logarithm.
        Eigen::VectorXd to_beat =
            Eigen::VectorXd::Constant(flips, std::numeric_limits<double>::infinity());
        for (int candidate = begin; candidate < end; ++candidate) {
          const Solution solution = solve(candidate, on_basis(candidate), {});
          if (solution.degrees_of_freedom == 0) continue;
          RowMajorXf slope = RowMajorXf::Zero(scan_.coefficient_count_[candidate], flips);
          for (const auto& term : scan_.terms_[candidate])
            slope.row(term.coefficient) += slopes.row(term.column);
          // In units in which the slopes are near one: columns differ by orders of magnitude.
          const Eigen::VectorXd unit = grams_[candidate].diagonal().cwiseSqrt();
          const Eigen::VectorXd inverse =
              (unit.array() > kMinNorm).select(unit.cwiseInverse(), 0.0);
          slope = inverse.cast<float>().asDiagonal() * slope;
          const Eigen::MatrixXf whitening = (solution.whitening * unit.asDiagonal()).cast<float>();
          Eigen::RowVectorXf gains = Eigen::RowVectorXf::Zero(flips);
          for (const auto& axis : whitening.rowwise())  // few and short: no matter for blocks
            gains += axis.lazyProduct(slope).cwiseAbs2();
          const auto& parameter = scan_.candidates_[candidate].effect.parameter;
          const double log_choices = scan_.candidates_[candidate].log_choices;
          const double of_choices = std::exp(-2.0 * log_choices / fit_.residual_freedom());
          for (int f = 0; f < flips; ++f) {
            if (gains[f] <= norms[f] * (1 - to_beat[f] * of_choices)) continue;
            const double score =
                ebic_fall(parameter, log_choices, solution.degrees_of_freedom, gains[f], norms[f]);
            if (score <= block_best[f]) continue;
            block_best[f] = score;
            to_beat[f] = std::exp(-score / fit_.residual_freedom());
          }
        }
        return block_best;
      },
      [&](const Eigen::VectorXd& block) { best = best.cwiseMax(block); });
  return {best.begin(), best.end()};
}

}  // namespace armtrue
