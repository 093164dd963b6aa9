#include "armtrue/calibration/gross_poses.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/registration.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "calibration/likely_mistake.h"
#include "calibration/pose_influence.h"

namespace armtrue {
namespace {

constexpr int kMostPoses = 2000, kFewestPoses = 8, kMostRounds = 6;
constexpr double kImprobable = 1e-3;
constexpr double kTimesMiss = 4, kGap = 1.5;
// If poses scatter more than their replicates, the model lacks something, perhaps a steep effect.
constexpr double kLacking = 1.25, kGapOfLacking = 2.5;
constexpr double kWholePose = 0.5;  // share of the pose's error that each of its readings has
constexpr double kCommonShare = 0.1, kLargestShare = 0.25;  // of the poses
// Of the readings of a pose. A pose that is wrong moves half of the corners of its image, or more,
// at least along u or v; a single corner of many is none.
constexpr double kLeastShare = 0.25;

// One reading for each session, pose and channel.
struct Reduced {
  std::vector<int> rows;                  // of the campaign
  std::vector<std::vector<int>> like;     // the replicates of each, itself included
  std::vector<std::vector<int>> of_pose;  // indices into `rows`
  Campaign campaign;                      // every row a pose of its own
};

Eigen::Vector3d reading(const Campaign& campaign, int row) {
  return campaign.reads_one_number() ? Eigen::Vector3d(campaign.length(row), 0, 0)
                                     : campaign.position[row];
}

int nearest_to_median(const Campaign& campaign, const std::vector<int>& rows) {
  if (rows.size() < 3) return rows.front();
  Eigen::Vector3d middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (int row : rows) values.push_back(reading(campaign, row)[k]);
    middle[k] = median(std::move(values));
  }
  return *std::ranges::min_element(
      rows, {}, [&](int row) { return (reading(campaign, row) - middle).norm(); });
}

Reduced reduced(const Campaign& campaign) {
  std::map<std::array<int, 2>, std::map<int, std::vector<int>>> groups;
  for (int row = 0; row < campaign.rows(); ++row)
    groups[{campaign.session.empty() ? 0 : campaign.session[row], campaign.pose[row]}]
          [campaign.channel(row)]
              .push_back(row);
  Reduced result;
  for (const auto& [pose, channels] : groups) {
    std::vector<int>& own = result.of_pose.emplace_back();
    for (const auto& [channel, rows] : channels) {
      own.push_back(static_cast<int>(result.rows.size()));
      result.rows.push_back(nearest_to_median(campaign, rows));
      result.like.push_back(rows);
    }
  }
  return result;
}

// Rows of some poses of the reduced campaign. Each row counts as a separate pose, so that others do
// not raise its variance.
Campaign kept_of(const Reduced& all, const Campaign& campaign, const std::vector<bool>& gross) {
  std::vector<int> rows;
  for (size_t p = 0; p < all.of_pose.size(); ++p)
    if (!gross[p])
      for (int k : all.of_pose[p]) rows.push_back(all.rows[k]);
  Campaign kept = campaign.select(rows);
  std::vector<std::string> ids;
  for (int k = 0; k < std::ssize(rows); ++k) {
    ids.push_back(kept.pose_ids[kept.pose[k]] + "." + std::to_string(k));
    kept.pose[k] = k;
  }
  kept.pose_ids = ids;
  return kept;
}

bool is_share_of_pose(const std::vector<int>& off, const std::vector<int>& all) {
  return static_cast<double>(off.size()) >= kLeastShare * static_cast<double>(all.size());
}

// Comparison of a pose with the fit without it.
struct Judged {
  double ratio = 0;           // u^2 before the division by s^2
  int size = 0;               // d
  double off = 0;             // m, mean over its rows that are off, or over all
  std::vector<int> rows_off;  // indices into Reduced::rows
};

// `fitted`: the robot without these poses. `tolerance`: within which a corrected pose fits [m].
std::vector<GrossPose> described(const Robot& fitted, const Campaign& campaign, const Reduced& all,
                                 const std::vector<Judged>& gross, double tolerance) {
  std::vector<GrossPose> list;
  std::vector<std::vector<int>> readings;
  for (const Judged& judged : gross) {
    GrossPose& pose = list.emplace_back();
    std::vector<int>& read = readings.emplace_back();
    pose.off = judged.off;
    for (int k : judged.rows_off) {
      read.push_back(all.rows[k]);
      pose.rows.insert(pose.rows.end(), all.like[k].begin(), all.like[k].end());
    }
    std::ranges::sort(pose.rows);
    pose.id = campaign.pose_ids[campaign.pose[read.front()]];
  }
  std::vector<std::vector<int>> rest;
  std::vector<size_t> of_rest;
  for (size_t k = 0; k < list.size(); ++k) {
    const auto mistake = likely_mistake(fitted, campaign, readings, k, list[k].off, tolerance);
    list[k].is_explained = mistake.has_value();
    list[k].likely = mistake.value_or(
        "the readings fit no other pose or target: a reflector that was bumped, a target that "
        "moved, or joint angles that are not those of this pose");
    if (mistake) continue;
    rest.push_back(readings[k]);
    of_rest.push_back(k);
  }
  for (const MovedThing& moved : moved_things(fitted, campaign, rest, tolerance))
    for (const size_t k : moved.poses) {
      list[of_rest[k]].is_explained = true;
      list[of_rest[k]].likely = moved.words;
    }
  return list;
}

struct Deleted {
  Eigen::VectorXd error;
  double square;
};

// See find_gross_poses(). Directions that hardly any other pose shows are no evidence: what the fit
// did not settle along them would count a thousand times.
Deleted deleted(const Eigen::MatrixXd& shown, const Eigen::VectorXd& residual,
                const Eigen::VectorXd& weight) {
  constexpr double kSmallestShareLeft = 1e-3;
  const Eigen::MatrixXd gram = shown * shown.transpose();
  const Eigen::VectorXd root = weight.cwiseMax(1e-12).cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
      Eigen::MatrixXd(root.asDiagonal() * gram * root.asDiagonal())};
  const Eigen::VectorXd left = 1 - eigen.eigenvalues().cwiseMax(0.0).array();
  const Eigen::Index others = (left.array() > kSmallestShareLeft).count();  // they are the first
  const Eigen::MatrixXd all_axes = root.cwiseInverse().asDiagonal() * eigen.eigenvectors();
  const Eigen::MatrixXd axes = all_axes.leftCols(others);
  const Eigen::MatrixXd alone = all_axes.rightCols(left.size() - others);
  const Eigen::VectorXd shared =
      residual - alone * (alone.transpose() * (weight.asDiagonal() * residual));
  const Eigen::VectorXd raised = left.head(others).cwiseInverse().array() - 1;
  const Eigen::MatrixXd c = axes * raised.asDiagonal() * axes.transpose();
  const Eigen::VectorXd error = shared + c * (weight.asDiagonal() * shared);
  const Eigen::MatrixXd s = Eigen::MatrixXd::Identity(c.rows(), c.cols()) + c;
  return {error, error.dot(s.ldlt().solve(error))};
}

// Images give cameras and boards their places, and rows that are poses of their own show no image.
Robot start_of(const Robot& robot, const Campaign& campaign, const IdentifiableSet& set) {
  if (!campaign.has_pixels()) return robot;
  Robot start = starting_robot(robot, campaign, set.kept);
  if (!start.nominal) start.nominal = robot.chain;
  return start;
}

class Search {
 public:
  Search(const Robot& robot, const Campaign& campaign)
      : campaign_(campaign),
        set_(require_identifiable(robot, campaign)),
        robot_(start_of(robot, campaign, set_)),
        all_(reduced(campaign)),
        gross_(all_.of_pose.size(), false) {}

  std::vector<GrossPose> found() {
    if (poses() < kFewestPoses || poses() > kMostPoses) return {};
    bool settled = false;
    for (int round = 0; round < kMostRounds && !settled; ++round) {
      judge();
      std::vector<bool> next = beyond();
      settled = next == gross_;
      gross_ = std::move(next);
    }
    if (std::ranges::none_of(gross_, [](bool is) { return is; })) return {};
    if (!settled) judge();
    drop_structure();
    return described();
  }

 private:
  int poses() const { return static_cast<int>(all_.of_pose.size()); }

  // The derivatives of each pose in coordinates in which the information of the fit is the unit
  // matrix. Sessions and targets have few of the coordinates.
  std::vector<PoseRows> shown(const SessionModels& models) const {
    const Eigen::Index p = models.unknowns();
    std::vector<PoseRows> poses;
    if (models.groups() > 1) {
      GroupedRows rows;
      for (const std::vector<int>& own : all_.of_pose) rows.add(own);
      const RootsOfGroups roots(models, fit_.inverse_root.sparseView());
      const SessionModels::At at = models.at(Eigen::VectorXd::Zero(p));
      const std::vector<double> weights(rows.row.size(), 1.0);
      for (int pose = 0; pose < rows.groups(); ++pose)
        poses.push_back(roots.rows_of(at, weights, rows, pose));
      return poses;
    }
    const Eigen::MatrixXd blocks = models.blocks();
    const Eigen::MatrixXd turned = blocks.leftCols(p) * fit_.inverse_root;
    for (const std::vector<int>& own : all_.of_pose) {
      const auto rows =
          Eigen::seqN(own.front() * models.row_size(), std::ssize(own) * models.row_size());
      poses.push_back({{}, turned(rows, Eigen::all), blocks.col(p)(rows)});
    }
    return poses;
  }

  void judge() {
    const Campaign kept = kept_of(all_, campaign_, gross_);
    // The effects of a robot that has some are near their values, and with their curves the
    // unknowns are hundreds.
    CalibrationOptions options{.statistics = FitStatistics::information};
    if (!robot_.effects.empty()) options.fold_by = FoldBy::normal_equations;
    fit_ = calibrate(robot_, kept, set_, options);
    const Campaign readings = campaign_.select(all_.rows);
    const SessionModels models(readings, fit_.robot, set_.kept, fit_.sigma, kAllEffects,
                               SessionModels::Split::by_target);
    if (models.unknowns() != fit_.inverse_root.rows())
      throw std::invalid_argument(campaign_.source + ": all poses of a session are off");
    const int size = models.row_size();
    const std::vector<PoseRows> rows_of_poses = shown(models);
    judged_.assign(poses(), {});
    size_t next_kept = 0;
    std::vector<Eigen::VectorXd> errors(all_.rows.size());
    for (size_t pose = 0; pose < judged_.size(); ++pose) {
      const std::vector<int>& own = all_.of_pose[pose];
      const int numbers = static_cast<int>(own.size()) * size;
      Eigen::VectorXd weight(numbers);
      for (int k = 0; k < std::ssize(own); ++k)
        weight.segment(k * size, size).setConstant(gross_[pose] ? 0.0 : fit_.weights[next_kept++]);
      const Deleted without =
          deleted(rows_of_poses[pose].rows, rows_of_poses[pose].residual, weight);
      judged_[pose].size = numbers;
      judged_[pose].ratio = without.square / numbers;
      for (int k = 0; k < std::ssize(own); ++k) {
        const double miss =
            fit_.sigma.position *
            without.error.segment(k * size, readings.reading_size().position).norm();
        errors[own[k]] = Eigen::VectorXd::Constant(1, miss);
      }
    }
    typical_miss_ =
        fit_.sigma.position * (readings.reads_one_number() ? kMedianOfNorm1 : kMedianOfNorm3);
    for (size_t pose = 0; pose < judged_.size(); ++pose) set_off(pose, errors);
  }

  void set_off(size_t pose, const std::vector<Eigen::VectorXd>& errors) {
    Judged& judged = judged_[pose];
    double sum = 0;
    for (int k : all_.of_pose[pose])
      if (const double miss = errors[k][0]; miss > kTimesMiss * typical_miss_) {
        judged.rows_off.push_back(k);
        sum += miss;
      }
    judged.off = judged.rows_off.empty() ? 0 : sum / static_cast<double>(judged.rows_off.size());
    if (!is_share_of_pose(judged.rows_off, all_.of_pose[pose])) judged.rows_off.clear();
  }

  // s^2, from the quantiles of chi-square over its degrees of freedom.
  double scale() const {
    std::vector<double> ratios;
    for (const Judged& judged : judged_) ratios.push_back(judged.ratio);
    double largest = 1e-12;
    for (double share : {0.5, 0.75, 0.9}) {
      const double at = quantile(ratios, share);
      const double size = judged_.front().size;
      largest = std::max(largest, at * size / chi_squared_quantile_above(1 - share, size));
    }
    return largest;
  }

  double p_value(size_t pose, double scale) const {
    const double size = judged_[pose].size;
    return fisher_f_above(judged_[pose].ratio / scale, size, 0.5 * size * poses());
  }

  bool lacks_something() const {
    const NoiseFloor floor = noise_floor(fit_.robot, campaign_, evaluate(fit_.robot, campaign_));
    return floor.source == NoiseFloor::Source::replicates &&
           fit_.sigma.position > kLacking * floor.position;
  }

  std::vector<bool> beyond() const {
    const double s2 = scale();
    std::vector<size_t> order(judged_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::stable_sort(order, std::greater<>{},
                             [&](size_t pose) { return judged_[pose].ratio; });
    const auto most = static_cast<size_t>(kLargestShare * poses());
    const double gap = lacks_something() ? kGapOfLacking : kGap;
    size_t count = 0;
    for (size_t k = 0; k < std::max<size_t>(1, most); ++k) {
      if (p_value(order[k], s2) * poses() > kImprobable) break;
      if (judged_[order[k]].ratio > gap * gap * judged_[order[k + 1]].ratio) count = k + 1;
    }
    std::vector<bool> result(judged_.size(), false);
    for (size_t k = 0; k < count; ++k) result[order[k]] = !judged_[order[k]].rows_off.empty();
    return result;
  }

  JointRows::ConstRow q(size_t pose) const {
    return campaign_.q[all_.rows[all_.of_pose[pose].front()]];
  }

  // Whether for some joint two of the four nearest poses are off too. The limit for `off` is the p
  // at which this has a small probability over all joints: joints * 6 p^2. They are off together
  // only if the others are off by a share of its error: an effect that moves this pose by forty
  // standard deviations does not move both neighbours by two.
  bool has_company(size_t pose, double s2) const {
    constexpr size_t kNearest = 4, kCompany = 2;
    constexpr double kPairs = 6, kShare = 0.2;
    const double least = kShare * kShare * judged_[pose].ratio;
    const double off_too = std::sqrt(kImprobable / (kPairs * joint_count(robot_.chain)));
    for (int joint = 0; joint < joint_count(robot_.chain); ++joint) {
      std::vector<std::pair<double, size_t>> others;
      for (size_t other = 0; other < judged_.size(); ++other)
        if (other != pose) others.emplace_back(std::abs(q(other)[joint] - q(pose)[joint]), other);
      std::ranges::sort(others);
      size_t company = 0;
      for (size_t k = 0; k < std::min(kNearest, others.size()); ++k)
        company +=
            judged_[others[k].second].ratio > least && p_value(others[k].second, s2) < off_too ? 1
                                                                                               : 0;
      if (company >= kCompany) return true;
    }
    return false;
  }

  void drop_structure() {
    const double s2 = scale();
    const Evaluation evaluation = evaluate(fit_.robot, campaign_);
    std::vector<bool> kept = gross_;
    for (size_t pose = 0; pose < judged_.size(); ++pose) {
      if (!gross_[pose]) continue;
      for (int k : judged_[pose].rows_off)
        for (int row : all_.like[k])
          if (evaluation.position[row] < kWholePose * judged_[pose].off && all_.like[k].size() > 1)
            kept[pose] = false;
      if (judged_[pose].off < kNoEffect && has_company(pose, s2)) kept[pose] = false;
      if (judged_[pose].rows_off.empty()) kept[pose] = false;
    }
    gross_ = kept;
  }

  std::vector<GrossPose> described() const {
    std::vector<Judged> gross;
    for (size_t pose = 0; pose < judged_.size(); ++pose)
      if (gross_[pose]) gross.push_back(judged_[pose]);
    std::vector<GrossPose> list =
        armtrue::described(fit_.robot, campaign_, all_, gross, kTimesMiss * typical_miss_);
    const auto explained = std::ranges::count(list, true, &GrossPose::is_explained);
    const double most = std::max(1.0, kCommonShare * poses());
    if (static_cast<double>(list.size()) > most && 2 * explained < std::ssize(list)) return {};
    return list;
  }

  const Campaign& campaign_;
  const IdentifiableSet set_;
  const Robot robot_;
  const Reduced all_;
  std::vector<bool> gross_;
  CalibrationResult fit_;
  std::vector<Judged> judged_;
  double typical_miss_ = 0;
};

}  // namespace

std::vector<GrossPose> find_gross_poses(const Robot& robot, const Campaign& campaign) {
  if (campaign.poses() > kMostPoses) return {};
  try {
    return Search(robot, campaign).found();
  } catch (const std::invalid_argument&) {
    return {};  // too few readings, of which calibrate() says so, or a session without a good one
  }
}

std::vector<GrossPose> find_gross_held_out(const Robot& robot, const Campaign& held_out) {
  constexpr double kFar = 8;         // times as far as predicted, and as the others
  constexpr double kMost = 0.5;      // of the poses: the others show what is usual
  constexpr size_t kMostNamed = 50;  // each is compared with every other pose
  if (held_out.poses() > kMostPoses) return {};
  const Reduced all = reduced(held_out);
  const Campaign readings = held_out.select(all.rows);
  const std::vector<double> misses = position_errors(robot, readings);
  std::vector<double> deviations;
  for (const Prediction& prediction : predict(robot, readings))
    deviations.push_back(std::max(kFinestReading, prediction.deviation));
  std::vector<double> sizes;  // of each pose, RMS over its readings
  for (const std::vector<int>& own : all.of_pose)
    sizes.push_back(
        std::sqrt(mean_of(own, [&](int k) { return std::pow(misses[k] / deviations[k], 2); })));
  const double usual = std::max(1.0, median(sizes));
  std::vector<Judged> far;
  for (size_t pose = 0; pose < sizes.size(); ++pose) {
    if (sizes[pose] <= kFar * usual) continue;
    Judged& judged = far.emplace_back();
    for (int k : all.of_pose[pose])
      if (misses[k] > kTimesMiss * usual * deviations[k]) judged.rows_off.push_back(k);
    judged.off = mean_of(judged.rows_off, [&](int k) { return misses[k]; });
    if (!is_share_of_pose(judged.rows_off, all.of_pose[pose])) far.pop_back();
  }
  if (static_cast<double>(far.size()) > std::max(1.0, kMost * static_cast<double>(sizes.size())))
    return {};
  if (far.size() > kMostNamed) far.resize(kMostNamed);
  std::vector<GrossPose> gross =
      described(robot, held_out, all, far, kTimesMiss * usual * median(deviations));
  std::erase_if(gross,
                [](const GrossPose& pose) { return !pose.is_explained && pose.off < kNoEffect; });
  return gross;
}

std::vector<int> rows_of(const std::vector<GrossPose>& gross) {
  std::vector<int> rows;
  for (const GrossPose& pose : gross) rows.insert(rows.end(), pose.rows.begin(), pose.rows.end());
  std::ranges::sort(rows);
  return rows;
}

Campaign without_gross(const Campaign& campaign, const std::vector<GrossPose>& gross) {
  if (gross.empty()) return campaign;
  return without_rows(campaign, rows_of(gross));
}

Campaign without_gross(const Campaign& all, const std::vector<int>& training,
                       const std::vector<GrossPose>& gross) {
  std::vector<GrossPose> in_all = gross;
  if (!training.empty())
    for (GrossPose& pose : in_all)
      for (int& row : pose.rows) row = training[row];
  return without_gross(all, in_all);
}

}  // namespace armtrue
