#include "armtrue/calibration/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "calibration/session_models.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kBlunderWeight = 0.05;  // under Student's t some 14 standard deviations

// Rows of one session, pose and channel, and their mean residual.
struct Replicates {
  std::span<const int> rows;         // within Grouped::order
  Eigen::Matrix<double, 6, 1> mean;  // of residuals as at_median() gives them
};

struct Grouped {
  std::vector<int> order;  // the rows, group by group
  std::vector<Replicates> groups;
};

// Ratio of each row's stated deviation to the median; 1 if the file states none.
std::vector<double> own_to_median(const std::vector<double>& deviations, int rows) {
  if (deviations.empty()) return std::vector<double>(static_cast<size_t>(rows), 1.0);
  const double middle = median(deviations);
  std::vector<double> ratios;
  for (double deviation : deviations) ratios.push_back(deviation / middle);
  return ratios;
}

// The residuals divided by those ratios: as if all rows had the median deviation.
std::vector<Eigen::Matrix<double, 6, 1>> at_median(const Campaign& campaign,
                                                   const Evaluation& evaluation) {
  const std::vector<double> position = own_to_median(campaign.sigma_position, campaign.rows());
  const std::vector<double> orientation =
      own_to_median(campaign.sigma_orientation, campaign.rows());
  std::vector<Eigen::Matrix<double, 6, 1>> residuals = evaluation.residuals;
  for (size_t row = 0; row < residuals.size(); ++row) {
    residuals[row].head<3>() /= position[row];
    residuals[row].tail<3>() /= orientation[row];
  }
  return residuals;
}

// By pose, channel and session.
Grouped replicates_of(const Campaign& campaign,
                      const std::vector<Eigen::Matrix<double, 6, 1>>& residuals) {
  Grouped grouped{grouped_rows(campaign.pose).row, {}};
  const auto key = [&](int row) {
    return std::array{campaign.pose[static_cast<size_t>(row)], campaign.channel(row),
                      campaign.session.empty() ? 0 : campaign.session[static_cast<size_t>(row)]};
  };
  std::vector<int>& order = grouped.order;
  const auto end_of = [&](size_t begin, const auto& same) {
    size_t end = begin + 1;
    while (end < order.size() && same(order[begin], order[end])) ++end;
    return end;
  };
  const auto at = [&](size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    end = end_of(begin, [&](int a, int b) {
      return campaign.pose[static_cast<size_t>(a)] == campaign.pose[static_cast<size_t>(b)];
    });
    if (end - begin > 1)
      std::stable_sort(at(begin), at(end), [&](int a, int b) { return key(a) < key(b); });
  }
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    end = end_of(begin, [&](int a, int b) { return key(a) == key(b); });
    Replicates& group = grouped.groups.emplace_back();
    group.rows = std::span<const int>(order).subspan(begin, end - begin);
    group.mean.setZero();
    for (int row : group.rows) group.mean += residuals[static_cast<size_t>(row)];
    group.mean /= static_cast<double>(group.rows.size());
  }
  return grouped;
}

std::optional<double> lack_of_fit_p(const Evaluation& evaluation, const Campaign& campaign,
                                    const NoiseFloor& floor,
                                    const std::array<double, 2>& determined, bool of_orientation) {
  if (floor.source == NoiseFloor::Source::none || floor.position <= 0) return std::nullopt;
  const bool turns = of_orientation && campaign.has_orientation() && floor.orientation > 0;
  double ratio = 0, groups = 0;
  const Grouped grouped = replicates_of(campaign, at_median(campaign, evaluation));
  for (const Replicates& group : grouped.groups) {
    const auto readings = static_cast<double>(group.rows.size());
    ratio += readings * (group.mean.head<3>() / floor.position).squaredNorm();
    if (turns) ratio += readings * (group.mean.tail<3>() / floor.orientation).squaredNorm();
    ++groups;
  }
  const double unknowns = determined[0] + (turns ? determined[1] : 0);
  const double freedom = (floor.axes + (turns ? 3 : 0)) * groups - unknowns;
  if (freedom < 1) return std::nullopt;
  if (floor.source == NoiseFloor::Source::instrument) return chi_squared_above(ratio, freedom);
  return fisher_f_above(ratio / freedom, freedom, floor.degrees_of_freedom);
}

}  // namespace

std::vector<double> Evaluation::reading_errors() const {
  if (first_rows.empty()) return position;
  std::vector<double> errors;
  errors.reserve(first_rows.size());
  for (size_t k = 0; k < first_rows.size(); ++k) {
    const size_t end = k + 1 < first_rows.size() ? static_cast<size_t>(first_rows[k + 1])
                                                 : position.size();
    double squares = 0;
    for (auto row = static_cast<size_t>(first_rows[k]); row < end; ++row)
      squares += position[row] * position[row];
    errors.push_back(std::sqrt(squares));
  }
  return errors;
}

Evaluation evaluate(const Robot& robot, const Campaign& campaign) {
  const SessionModels models(campaign, robot, {}, {1.0, 1.0});
  Evaluation evaluation;
  evaluation.first_rows = campaign.first_rows_of_readings();
  evaluation.residuals.resize(campaign.rows());
  for (int s = 0; s < models.sessions(); ++s) {
    const ObservationModel& model = models.model(s);
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    const Eigen::Matrix3d own_from_common = models.common_from_own(s).rotation.transpose();
    const std::vector<int>& rows = models.rows_of(s);
    for_ordered_blocks<int>(
        model.rows(), kRowsPerBlock,
        [&](int begin, int end) {
          std::vector<Eigen::Matrix<double, 6, 1>> part(static_cast<size_t>(end - begin));
          at.residuals(begin, part);
          for (int row = begin; row < end; ++row) {
            Eigen::Matrix<double, 6, 1>& residual = part[static_cast<size_t>(row - begin)];
            if (!campaign.has_distances()) {
              residual.head<3>() = own_from_common * residual.head<3>();
              residual.tail<3>() = own_from_common * residual.tail<3>();
            }
            evaluation.residuals[static_cast<size_t>(rows[static_cast<size_t>(row)])] = residual;
          }
          return 0;
        },
        [](int) {});
  }
  evaluation.position.reserve(evaluation.residuals.size());
  if (campaign.has_orientation()) evaluation.orientation.reserve(evaluation.residuals.size());
  for (const Eigen::Matrix<double, 6, 1>& residual : evaluation.residuals) {
    evaluation.position.push_back(residual.head<3>().norm());
    if (campaign.has_orientation()) evaluation.orientation.push_back(residual.tail<3>().norm());
  }
  return evaluation;
}

std::vector<AxisErrors> axis_errors(const Evaluation& evaluation, const Campaign& campaign) {
  std::vector<AxisErrors> axes;
  for (int i = 0; i < campaign.reading_size().position; ++i) {
    const double first = evaluation.residuals.front()[i];
    AxisErrors axis{campaign.has_distances() ? 'l' : "xyz"[i], 0, first, first};
    for (const auto& residual : evaluation.residuals) {
      axis.mean += residual[i];
      axis.min = std::min(axis.min, residual[i]);
      axis.max = std::max(axis.max, residual[i]);
    }
    axis.mean /= static_cast<double>(evaluation.residuals.size());
    axes.push_back(axis);
  }
  return axes;
}

PoseErrors errors_of(const Robot& robot, const Campaign& campaign) {
  const Evaluation evaluation = evaluate(robot, campaign);
  PoseErrors errors{summarize(evaluation.reading_errors()), std::nullopt,
                    axis_errors(evaluation, campaign)};
  if (!evaluation.orientation.empty()) errors.orientation = summarize(evaluation.orientation);
  return errors;
}

namespace {

// Of the readings, those of which all coordinates are read; single ones do not make a point.
double share_of_points(const Campaign& campaign, const Evaluation& evaluation) {
  if (!campaign.has_distances()) return 1;
  const std::vector<int>& first = evaluation.first_rows;
  if (first.empty()) return 0;
  double points = 0;
  for (size_t k = 0; k < first.size(); ++k)
    points += (k + 1 < first.size() ? first[k + 1] : campaign.rows()) - first[k] > 1;
  return points / static_cast<double>(first.size());
}

}  // namespace

NoiseFloor noise_floor(const Robot& robot, const Campaign& campaign, const Evaluation& evaluation) {
  NoiseFloor floor;
  floor.axes = campaign.reading_size().position;
  floor.points = share_of_points(campaign, evaluation);
  std::vector<double> position, orientation;
  const std::vector<Eigen::Matrix<double, 6, 1>> residuals = at_median(campaign, evaluation);
  const Grouped grouped = replicates_of(campaign, residuals);
  for (const Replicates& group : grouped.groups) {
    const double m = static_cast<double>(group.rows.size());
    if (m < 2) continue;
    floor.degrees_of_freedom += floor.axes * static_cast<int>(m - 1);
    for (int row : group.rows) {
      const Eigen::Matrix<double, 6, 1> deviation =
          std::sqrt(m / (m - 1)) * (residuals[row] - group.mean);
      for (int i = 0; i < floor.axes; ++i) position.push_back(deviation[i]);
      for (int i = 3; i < 6; ++i) orientation.push_back(deviation[i]);
    }
  }
  constexpr int kMinReplicates = 20;  // degrees of freedom; fewer say less than the data sheet
  if (floor.degrees_of_freedom >= kMinReplicates) {
    floor.source = NoiseFloor::Source::replicates;
    floor.position = robust_deviation(position);
    if (campaign.has_orientation()) floor.orientation = robust_deviation(orientation);
    return floor;
  }
  const bool own = !campaign.sigma_position.empty(), own_turn = !campaign.sigma_orientation.empty();
  floor.position = own ? median(campaign.sigma_position) : robot.noise.position;
  if (floor.position <= 0) return floor;
  floor.source = NoiseFloor::Source::instrument;
  if (campaign.has_orientation())
    floor.orientation = own_turn ? median(campaign.sigma_orientation) : robot.noise.orientation;
  return floor;
}

double mean_error_of_noise(double deviation_per_axis, int axes) {
  return deviation_per_axis * std::sqrt((axes == 1 ? 2 : 8) / std::numbers::pi);
}

double NoiseFloor::mean_error() const {
  return points * mean_error_of_noise(position, 3) +
         (1 - points) * mean_error_of_noise(position, 1);
}

namespace {

// Root mean squares of residuals without blunders, in position and orientation.
class MeanSquares {
 public:
  explicit MeanSquares(const ReadingSize& size) : size_(size) {}
  void add(const Eigen::Matrix<double, 6, 1>& residual, double weight) {
    squares_ += weight * Eigen::Array2d(residual.head<3>().squaredNorm(),
                                        residual.tail<3>().squaredNorm());
    ++rows_;
  }
  // `lost`: numbers that do not count, such as those that unknowns take up.
  InstrumentNoise roots(const std::array<double, 2>& lost) const {
    return {root(squares_[0], size_.position * rows_, lost[0]),
            root(squares_[1], size_.orientation * rows_, lost[1])};
  }

 private:
  static double root(double squares, double numbers, double lost) {
    constexpr double kLeastLeft = 0.1;
    return numbers > 0 ? std::sqrt(squares / std::max(kLeastLeft * numbers, numbers - lost)) : 0.0;
  }

  ReadingSize size_;
  Eigen::Array2d squares_ = Eigen::Array2d::Zero();
  double rows_ = 0;
};

void set_scatter(const CalibrationResult& fit, const Campaign& readings,
                 const Evaluation& evaluation, FitQuality& quality) {
  const auto residuals = at_median(readings, evaluation);
  const Grouped grouped = replicates_of(readings, residuals);
  MeanSquares left(readings.reading_size()), pure(readings.reading_size());
  for (const Replicates& group : grouped.groups) {
    const auto m = static_cast<double>(group.rows.size());
    for (int row : group.rows) {
      const Eigen::Matrix<double, 6, 1>& residual = residuals[static_cast<size_t>(row)];
      left.add(residual, 1);
      if (m > 1) pure.add(residual - group.mean, m / (m - 1));
    }
  }
  quality.left = left.roots(fit.determined);
  quality.pure = quality.noise.source == NoiseFloor::Source::replicates
                     ? pure.roots({0, 0})
                     : InstrumentNoise{quality.noise.position, quality.noise.orientation};
}

}  // namespace

FitQuality assess(const CalibrationResult& fit, const Campaign& campaign) {
  FitQuality quality;
  std::vector<int> sound;
  for (int row = 0; row < campaign.rows(); ++row)
    (fit.degrees_of_freedom > 0 && fit.weights_in_pose[row] < kBlunderWeight ? quality.blunders
                                                                             : sound)
        .push_back(row);
  std::optional<Campaign> part;
  if (!quality.blunders.empty()) part = campaign.select(sound);
  const Campaign& readings = part ? *part : campaign;
  const Evaluation evaluation = evaluate(fit.robot, readings);
  quality.noise = noise_floor(fit.robot, readings, evaluation);
  quality.lack_of_fit = lack_of_fit_p(evaluation, readings, quality.noise, fit.determined, true);
  quality.lack_of_fit_in_position =
      lack_of_fit_p(evaluation, readings, quality.noise, fit.determined, false);
  set_scatter(fit, readings, evaluation, quality);
  return quality;
}

}  // namespace armtrue
