#include "armtrue/calibration/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kBlunderWeight = 0.05;  // under Student's t some 14 standard deviations

// The residuals of some rows, each divided by the ratio of its stated deviation to the median of
// these rows: as if all had the median deviation.
class MedianResiduals {
 public:
  MedianResiduals(const Campaign& campaign, const Evaluation& evaluation,
                  const std::vector<int>& rows)
      : campaign_(campaign),
        evaluation_(evaluation),
        position_(median_of(campaign.sigma_position, rows)),
        orientation_(median_of(campaign.sigma_orientation, rows)) {}

  Eigen::Matrix<double, 6, 1> at(int row) const {
    const size_t r = row;
    Eigen::Matrix<double, 6, 1> residual = evaluation_.residuals[r];
    if (position_) residual.head<3>() /= campaign_.sigma_position[r] / *position_;
    if (orientation_) residual.tail<3>() /= campaign_.sigma_orientation[r] / *orientation_;
    return residual;
  }

  /// Median deviations that the rows state.
  const std::optional<double>& position() const { return position_; }
  const std::optional<double>& orientation() const { return orientation_; }

 private:
  static std::optional<double> median_of(const std::vector<double>& deviations,
                                         const std::vector<int>& rows) {
    if (deviations.empty()) return std::nullopt;
    std::vector<double> own;
    own.reserve(rows.size());
    for (int row : rows) own.push_back(deviations[row]);
    return median(std::move(own));
  }

  const Campaign& campaign_;
  const Evaluation& evaluation_;
  std::optional<double> position_, orientation_;
};

// A number for the load of each row, payload and force: loads that differ by less than kSameLoad of
// the largest have one, because load cells scatter. Empty without loads.
std::vector<int> load_classes(const Campaign& campaign) {
  if (campaign.payload_kg.empty() && campaign.force_n.empty()) return {};
  constexpr double kSameLoad = 0.05;
  Eigen::Matrix4Xd load = Eigen::Matrix4Xd::Zero(4, campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row) {
    if (!campaign.payload_kg.empty()) load(0, row) = campaign.payload_kg[row];
    if (!campaign.force_n.empty()) load.col(row).tail<3>() = campaign.force_n[row];
  }
  load.row(0) /= std::max(1e-9, kSameLoad * load.row(0).cwiseAbs().maxCoeff());
  load.bottomRows<3>() /=
      std::max(1e-9, kSameLoad * load.bottomRows<3>().colwise().norm().maxCoeff());
  std::map<std::array<double, 4>, int> numbers;
  std::vector<int> classes;
  for (const auto& own : load.colwise()) {
    const Eigen::Array4d rounded = own.array().round();
    const std::array key{rounded[0], rounded[1], rounded[2], rounded[3]};
    classes.push_back(numbers.try_emplace(key, static_cast<int>(numbers.size())).first->second);
  }
  return classes;
}

// `use(rows, mean)` for the rows of each session, pose, channel and load, replicates of each other,
// and the mean of their residuals. `rows` increase.
template <typename Use>
void for_each_replicates(const Campaign& campaign, const MedianResiduals& residuals,
                         const std::vector<int>& rows, const Use& use) {
  std::vector<int> number(campaign.pose_ids.size(), -1);  // of the poses, as they appear
  std::vector<int> order;
  {
    std::vector<int> pose_of;
    pose_of.reserve(rows.size());
    int poses = 0;
    for (int row : rows) {
      int& own = number[campaign.pose[row]];
      if (own < 0) own = poses++;
      pose_of.push_back(own);
    }
    order = grouped_rows(pose_of).row;
  }
  for (int& row : order) row = rows[row];
  const std::vector<int> load = load_classes(campaign);
  const auto key = [&](int row) {
    return std::array{campaign.pose[row], campaign.channel(row),
                      campaign.session.empty() ? 0 : campaign.session[row],
                      load.empty() ? 0 : load[row]};
  };
  const auto end_of = [&](size_t begin, const auto& same) {
    size_t end = begin + 1;
    while (end < order.size() && same(order[begin], order[end])) ++end;
    return end;
  };
  const auto at = [&](size_t k) { return order.begin() + k; };
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    end = end_of(begin, [&](int a, int b) { return campaign.pose[a] == campaign.pose[b]; });
    if (end - begin > 1)
      std::stable_sort(at(begin), at(end), [&](int a, int b) { return key(a) < key(b); });
  }
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    end = end_of(begin, [&](int a, int b) { return key(a) == key(b); });
    const auto group = std::span<const int>(order).subspan(begin, end - begin);
    use(group, mean_of(group, [&](int row) { return residuals.at(row); }));
  }
}

std::optional<double> lack_of_fit_p(const Evaluation& evaluation, const Campaign& campaign,
                                    const std::vector<int>& rows, const NoiseFloor& floor,
                                    const std::array<double, 2>& determined, bool of_orientation) {
  if (floor.source == NoiseFloor::Source::none || floor.position <= 0) return std::nullopt;
  const bool turns = of_orientation && campaign.has_orientation() && floor.orientation > 0;
  const bool whitens =
      floor.source == NoiseFloor::Source::instrument && !campaign.whitening.empty();
  const MedianResiduals residuals(campaign, evaluation, rows);
  const auto by_noise = [&](Eigen::Matrix<double, 6, 1> residual) {
    residual.head<3>() /= floor.position;
    if (turns) residual.tail<3>() /= floor.orientation;
    return residual;
  };
  const auto white = [&](int row) -> Eigen::Matrix<double, 6, 1> {
    return campaign.whitening[row] * by_noise(residuals.at(row));
  };
  double between = 0, within = 0, groups = 0;
  const int numbers = turns ? 6 : 3;
  for_each_replicates(
      campaign, residuals, rows,
      [&](std::span<const int> group, const Eigen::Matrix<double, 6, 1>& mean) {
        const Eigen::Matrix<double, 6, 1> own = whitens ? mean_of(group, white) : by_noise(mean);
        between += static_cast<double>(group.size()) * own.head(numbers).squaredNorm();
        for (int row : group)
          within += (by_noise(residuals.at(row) - mean)).head(numbers).squaredNorm();
        ++groups;
      });
  const double axes = floor.axes + (turns ? 3 : 0);
  const double freedom = axes * groups - determined[0] - (turns ? determined[1] : 0);
  if (freedom < 1) return std::nullopt;
  if (floor.source == NoiseFloor::Source::instrument) return chi_squared_above(between, freedom);
  const double replicates = axes * (static_cast<double>(rows.size()) - groups);
  return fisher_f_above(between / freedom / (within / replicates),
                        freedom * floor.even_axes / floor.axes,
                        replicates * floor.even_axes / floor.axes);
}

// Of the readings of some rows, those of which more than one coordinate is read; single ones do not
// make a point. `rows` increase.
double share_of_points(const Campaign& campaign, const Evaluation& evaluation,
                       const std::vector<int>& rows) {
  if (!campaign.reads_one_number()) return 1;
  // A pixel is two numbers: the mean length of its noise, sqrt(pi / 2) per deviation, lies between
  // those of three and of one, sqrt(8 / pi) and sqrt(2 / pi).
  constexpr double kShareOfPixel = std::numbers::pi / 2 - 1;
  const std::vector<int>& first = evaluation.first_rows;
  if (first.empty()) return 0;
  double readings = 0, points = 0;
  for (size_t k = 0, begin = 0, end = 0; begin < rows.size(); ++k, begin = end) {
    while (end < rows.size() && (k + 1 == first.size() || rows[end] < first[k + 1])) ++end;
    readings += end > begin;
    if (end > begin + 1)
      points += campaign.kind(rows[begin]) == ReadingKind::pixel ? kShareOfPixel : 1;
  }
  return points / std::max(1.0, readings);
}

// Root of the mean variance of several axes and sessions, and how many axes of equal variance
// scatter as much: axes (mean variance)^2 / mean square of the variances (Satterthwaite 1946).
struct NoiseOfAxes {
  double deviation = 0, even_axes = 1;
};

// Deviations of replicates from their mean. An instrument may be worse along one axis, and in one
// session: a variance of several robust ones is that of all, a robust one of their mixture is less.
class Deviations {
 public:
  explicit Deviations(const Campaign& campaign)
      : campaign_(campaign),
        axes_(campaign.reading_size().position),
        of_session_(std::max<size_t>(1, campaign.session_names.size())) {}

  void add(int row, const Eigen::Matrix<double, 6, 1>& deviation) {
    Axes& own = of_session_[campaign_.session.empty() ? 0 : campaign_.session[row]];
    for (int i = 0; i < 6; ++i)
      if (i < axes_ || (i >= 3 && campaign_.has_orientation())) own[i].push_back(deviation[i]);
  }

  // Of the axes from `first` on. Sessions of fewer than kFewest deviations count as one.
  NoiseOfAxes noise(int first, int axes) const {
    double all = 0, sum = 0, squares = 0;
    const auto add = [&](const Axes& deviations) {
      for (int i = first; i < first + axes; ++i) {
        const auto count = static_cast<double>(deviations[i].size());
        const double variance = variance_of(deviations[i]);
        all += count;
        sum += count * variance;
        squares += count * variance * variance;
      }
    };
    Axes small;
    for (const Axes& own : of_session_)
      if (std::ssize(own[first]) >= kFewest)
        add(own);
      else
        for (int i = first; i < first + axes; ++i)
          small[i].insert(small[i].end(), own[i].begin(), own[i].end());
    add(small);
    return {std::sqrt(sum / all), squares > 0 ? axes * sum * sum / (all * squares) : axes};
  }

 private:
  // Most of the readings of a coarse scale agree, so that their robust deviation is none.
  static double variance_of(const std::vector<double>& deviations) {
    const double robust = robust_deviation(deviations);
    if (robust >= kFinestReading || deviations.empty()) return robust * robust;
    return std::inner_product(deviations.begin(), deviations.end(), deviations.begin(), 0.0) /
           static_cast<double>(deviations.size());
  }

  using Axes = std::array<std::vector<double>, 6>;
  static constexpr int kFewest = 30;  // a robust deviation of 30 errs by some 15 %

  const Campaign& campaign_;
  int axes_;  // of the position
  std::vector<Axes> of_session_;
};

double median_miss(const MedianResiduals& residuals, const std::vector<int>& rows) {
  std::vector<double> misses;
  misses.reserve(rows.size());
  for (int row : rows) misses.push_back(residuals.at(row).head<3>().norm());
  return median(std::move(misses));
}

NoiseFloor noise_floor_of(const Robot& robot, const Campaign& campaign,
                          const Evaluation& evaluation, const std::vector<int>& rows) {
  NoiseFloor floor;
  floor.axes = campaign.reading_size().position;
  floor.even_axes = floor.axes;
  floor.points = share_of_points(campaign, evaluation, rows);
  Deviations deviations(campaign);
  const MedianResiduals residuals(campaign, evaluation, rows);
  floor.median_sigma = residuals.position().value_or(0);
  double replicates = 0, agree = 0;
  for_each_replicates(campaign, residuals, rows,
                      [&](std::span<const int> group, const Eigen::Matrix<double, 6, 1>& mean) {
                        const double m = static_cast<double>(group.size());
                        if (m < 2) return;
                        floor.degrees_of_freedom += floor.axes * static_cast<int>(m - 1);
                        for (int row : group) {
                          const Eigen::Matrix<double, 6, 1> deviation = residuals.at(row) - mean;
                          deviations.add(row, std::sqrt(m / (m - 1)) * deviation);
                          agree += deviation.head<3>().norm() < kFinestReading;
                          ++replicates;
                        }
                      });
  constexpr double kOfCopies = 0.9;   // readings that are rounded agree less often in all axes
  constexpr int kMinReplicates = 20;  // degrees of freedom; fewer say less than the data sheet
  if (floor.degrees_of_freedom >= kMinReplicates) {
    const NoiseOfAxes noise = deviations.noise(0, floor.axes);
    floor.are_copies =
        agree > kOfCopies * replicates && median_miss(residuals, rows) >= kFinestReading;
    if (!floor.are_copies) {
      floor.source = NoiseFloor::Source::replicates;
      floor.position = noise.deviation;
      floor.even_axes = noise.even_axes;
      floor.degrees_of_freedom = static_cast<int>(
          kEfficiencyOfRobustDeviation * floor.degrees_of_freedom * floor.even_axes / floor.axes);
      if (campaign.has_orientation()) floor.orientation = deviations.noise(3, 3).deviation;
      return floor;
    }
  }
  floor.position = residuals.position().value_or(stated_position_noise(robot, campaign));
  if (floor.position <= 0) return floor;
  floor.source = NoiseFloor::Source::instrument;
  if (campaign.has_orientation())
    floor.orientation = residuals.orientation().value_or(robot.noise.orientation);
  return floor;
}

}  // namespace

std::vector<double> Evaluation::reading_errors() const {
  if (first_rows.empty()) return position;
  std::vector<double> errors;
  errors.reserve(first_rows.size());
  for (size_t k = 0; k < first_rows.size(); ++k) {
    const size_t end = k + 1 < first_rows.size() ? first_rows[k + 1] : position.size();
    double squares = 0;
    for (size_t row = first_rows[k]; row < end; ++row) squares += position[row] * position[row];
    errors.push_back(std::sqrt(squares));
  }
  return errors;
}

namespace {

// `use(row, residual)` for every row, on all cores.
template <typename Use>
void for_each_residual(const SessionModels& models, const Campaign& campaign, const Use& use) {
  for (int s = 0; s < models.sessions(); ++s) {
    const ObservationModel& model = models.model(s);
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    const Eigen::Matrix3d own_from_common = models.common_from_own(s).rotation.transpose();
    const std::vector<int>& rows = models.rows_of(s);
    for_ordered_blocks<int>(
        model.rows(), kRowsPerBlock,
        [&](int begin, int end) {
          std::vector<Eigen::Matrix<double, 6, 1>> part(end - begin);
          at.residuals(begin, part);
          for (int row = begin; row < end; ++row) {
            Eigen::Matrix<double, 6, 1>& residual = part[row - begin];
            if (!campaign.reads_one_number()) {
              residual.head<3>() = own_from_common * residual.head<3>();
              residual.tail<3>() = own_from_common * residual.tail<3>();
            }
            use(rows[row], residual);
          }
          return 0;
        },
        [](int) {});
  }
}

std::vector<Eigen::Matrix<double, 6, 1>> residuals_of(const Robot& robot,
                                                      const Campaign& campaign) {
  const SessionModels models(campaign, robot, {}, {1.0, 1.0});
  std::vector<Eigen::Matrix<double, 6, 1>> residuals(campaign.rows());
  for_each_residual(models, campaign, [&](size_t row, const Eigen::Matrix<double, 6, 1>& residual) {
    residuals[row] = residual;
  });
  return residuals;
}

}  // namespace

Evaluation evaluate(const Robot& robot, const Campaign& campaign) {
  Evaluation evaluation;
  evaluation.first_rows = campaign.first_rows_of_readings();
  evaluation.residuals = residuals_of(robot, campaign);
  evaluation.position.reserve(evaluation.residuals.size());
  if (campaign.has_orientation()) evaluation.orientation.reserve(evaluation.residuals.size());
  for (const Eigen::Matrix<double, 6, 1>& residual : evaluation.residuals) {
    evaluation.position.push_back(residual.head<3>().norm());
    if (campaign.has_orientation()) evaluation.orientation.push_back(residual.tail<3>().norm());
  }
  return evaluation;
}

std::vector<double> position_errors(const Robot& robot, const Campaign& campaign) {
  const SessionModels models(campaign, robot, {}, {1.0, 1.0});
  std::vector<double> errors(campaign.rows());
  for_each_residual(models, campaign, [&](size_t row, const Eigen::Matrix<double, 6, 1>& residual) {
    errors[row] = residual.head<3>().norm();
  });
  return errors;
}

std::vector<AxisErrors> axis_errors(const Evaluation& evaluation, const Campaign& campaign) {
  std::vector<AxisErrors> axes;
  for (int i = 0; i < campaign.reading_size().position; ++i) {
    const double first = evaluation.residuals.front()[i];
    AxisErrors axis{campaign.reads_one_number() ? 'l' : "xyz"[i], 0, first, first};
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

namespace {

enum class KindWord { points, distances, touches, beams, images };
constexpr std::array kKindWords{"points", "distances", "touches", "beams", kImages};

KindWord word_of(const Campaign& campaign, int row) {
  switch (campaign.kind(row)) {
    case ReadingKind::distance:
      return KindWord::distances;
    case ReadingKind::touch:
      return BeamName::is_one(campaign.contact_names[campaign.touch[row].contact])
                 ? KindWord::beams
                 : KindWord::touches;
    case ReadingKind::pixel:
      return KindWord::images;
    case ReadingKind::point:
    case ReadingKind::coordinate:
      break;
  }
  return KindWord::points;
}

}  // namespace

std::vector<KindErrors> errors_by_kind(const Evaluation& evaluation, const Campaign& campaign) {
  std::array<std::vector<double>, kKindWords.size()> all;
  const std::vector<double> errors = evaluation.reading_errors();
  const std::vector<int>& first = evaluation.first_rows;
  for (int k = 0; k < std::ssize(errors); ++k) {
    const int row = first.empty() ? k : first[k];
    std::vector<double>& own = all[static_cast<size_t>(word_of(campaign, row))];
    if (own.empty()) own.reserve(errors.size());
    own.push_back(errors[k]);
  }
  std::vector<KindErrors> kinds;
  for (size_t word = 0; word < all.size(); ++word)
    if (!all[word].empty()) kinds.push_back({kKindWords[word], std::move(all[word])});
  return kinds;
}

std::vector<double> image_errors(const Evaluation& evaluation, const Campaign& campaign) {
  for (KindErrors& one : errors_by_kind(evaluation, campaign))
    if (one.kind == kImages) return std::move(one.errors);
  return {};
}

double mean_reading_error(const Robot& robot, const Campaign& campaign) {
  return summarize(evaluate(robot, campaign).reading_errors()).mean;
}

PoseErrors errors_of(const Evaluation& evaluation, const Campaign& campaign) {
  PoseErrors errors;
  errors.position = summarize(evaluation.reading_errors());
  errors.axes = axis_errors(evaluation, campaign);
  errors.kinds = errors_by_kind(evaluation, campaign);
  errors.metre_per_pixel = campaign.metre_per_pixel;
  if (!evaluation.orientation.empty()) errors.orientation = summarize(evaluation.orientation);
  return errors;
}

PoseErrors errors_of(const Robot& robot, const Campaign& campaign) {
  return errors_of(evaluate(robot, campaign), campaign);
}

NoiseFloor noise_floor(const Robot& robot, const Campaign& campaign, const Evaluation& evaluation) {
  std::vector<int> rows(campaign.rows());
  std::iota(rows.begin(), rows.end(), 0);
  return noise_floor_of(robot, campaign, evaluation, rows);
}

NoiseFloor noise_floor_without(const std::vector<int>& blunders, const Robot& robot,
                               const Campaign& campaign) {
  const Campaign readings = without_rows(campaign, blunders);
  return noise_floor(robot, readings, evaluate(robot, readings));
}

double mean_error_of_noise(double deviation_per_axis, int axes) {
  if (axes == 2) return deviation_per_axis * std::sqrt(std::numbers::pi / 2);
  return deviation_per_axis * std::sqrt((axes == 1 ? 2 : 8) / std::numbers::pi);
}

double NoiseFloor::mean_error() const {
  return points * mean_error_of_noise(position, 3) +
         (1 - points) * mean_error_of_noise(position, 1);
}

double mean_error(const NoiseFloor& noise, const Campaign& campaign) {
  const std::vector<double>& own = campaign.sigma_position;
  if (own.empty()) return noise.mean_error();
  const double per_sigma =
      noise.position / (noise.median_sigma > 0 ? noise.median_sigma : median(own));
  std::vector<int> first = campaign.first_rows_of_readings();
  if (first.empty()) {
    const double mean = std::accumulate(own.begin(), own.end(), 0.0) / campaign.rows();
    return mean_error_of_noise(per_sigma * mean, campaign.reading_size().position);
  }
  first.push_back(campaign.rows());
  double sum = 0;
  for (size_t k = 0; k + 1 < first.size(); ++k)
    sum += mean_error_of_noise(per_sigma * own[first[k]], first[k + 1] - first[k]);
  return sum / static_cast<double>(first.size() - 1);
}

namespace {

// How many of so many numbers are left after so many unknowns took theirs.
double numbers_left(double numbers, double lost) {
  constexpr double kLeastLeft = 0.1;
  return std::max(kLeastLeft * numbers, numbers - lost);
}

// Root mean squares of residuals without blunders, in position and orientation.
class MeanSquares {
 public:
  explicit MeanSquares(const ReadingSize& size) : size_(size) {}
  void add(const Eigen::Matrix<double, 6, 1>& residual, double weight) {
    squares_ +=
        weight * Eigen::Array2d(residual.head<3>().squaredNorm(), residual.tail<3>().squaredNorm());
    ++rows_;
  }
  // `lost`: numbers that do not count, such as those that unknowns take up.
  InstrumentNoise roots(const std::array<double, 2>& lost) const {
    return {root(squares_[0], size_.position * rows_, lost[0]),
            root(squares_[1], size_.orientation * rows_, lost[1])};
  }

 private:
  static double root(double squares, double numbers, double lost) {
    return numbers > 0 ? std::sqrt(squares / numbers_left(numbers, lost)) : 0.0;
  }

  ReadingSize size_;
  Eigen::Array2d squares_ = Eigen::Array2d::Zero();
  double rows_ = 0;
};

// `rows`: those without blunders.
void set_scatter(const CalibrationResult& fit, const Campaign& campaign,
                 const Evaluation& evaluation, const std::vector<int>& rows, FitQuality& quality) {
  MeanSquares left(campaign.reading_size()), pure(campaign.reading_size());
  double between = 0, groups = 0;
  const MedianResiduals residuals(campaign, evaluation, rows);
  for_each_replicates(campaign, residuals, rows,
                      [&](std::span<const int> group, const Eigen::Matrix<double, 6, 1>& mean) {
                        const auto m = static_cast<double>(group.size());
                        for (int row : group) {
                          const Eigen::Matrix<double, 6, 1> residual = residuals.at(row);
                          left.add(residual, 1);
                          if (m > 1) pure.add(residual - mean, m / (m - 1));
                        }
                        between += m * mean.head<3>().squaredNorm();
                        ++groups;
                      });
  quality.left = left.roots(fit.determined);
  quality.pure = quality.noise.source == NoiseFloor::Source::replicates
                     ? pure.roots({0, 0})
                     : InstrumentNoise{quality.noise.position, quality.noise.orientation};
  if (groups == 0) return;
  const double numbers = campaign.reading_size().position * groups;
  const double variance = between / numbers_left(numbers, fit.determined[0]) -
                          quality.pure.position * quality.pure.position;
  quality.rest = std::sqrt(std::max(0.0, variance) * groups / static_cast<double>(rows.size()));
}

}  // namespace

std::optional<bool> FitQuality::leaves_noise() const {
  constexpr double kMayBeChance = 0.01;
  if (!lack_of_fit) return std::nullopt;
  return *lack_of_fit >= kMayBeChance;
}

FitQuality assess(const CalibrationResult& fit, const Campaign& campaign) {
  return assess(fit, campaign, evaluate(fit.robot, campaign));
}

FitQuality assess(const CalibrationResult& fit, const Campaign& campaign,
                  const Evaluation& evaluation) {
  FitQuality quality;
  std::vector<int> sound;
  sound.reserve(campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row)
    (fit.degrees_of_freedom > 0 && fit.weights_in_pose[row] < kBlunderWeight ? quality.blunders
                                                                             : sound)
        .push_back(row);
  quality.noise = noise_floor_of(fit.robot, campaign, evaluation, sound);
  quality.lack_of_fit =
      lack_of_fit_p(evaluation, campaign, sound, quality.noise, fit.determined, true);
  quality.lack_of_fit_in_position =
      lack_of_fit_p(evaluation, campaign, sound, quality.noise, fit.determined, false);
  set_scatter(fit, campaign, evaluation, sound, quality);
  return quality;
}

}  // namespace armtrue
