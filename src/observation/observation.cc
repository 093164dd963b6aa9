#include "armtrue/observation/observation.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <utility>

#include "armtrue/effects/posture.h"
#include "armtrue/statistics/summary.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

// 0 where no row states a standard deviation.
double stated_median(const std::vector<double>& deviations) {
  return deviations.empty() ? 0.0 : median(deviations);
}

bool same_posture(const Campaign& campaign, int a, int b) {
  return campaign.q[a] == campaign.q[b] &&
         (campaign.payload_kg.empty() || campaign.payload_kg[a] == campaign.payload_kg[b]);
}

// For each row: the first row of the unbroken series of visits of its pose with its joint angles
// and payload.
std::vector<int> first_rows_of_posture(const Campaign& campaign) {
  constexpr int kNone = -1;
  std::vector<int> last_of_pose(campaign.pose_ids.size(), kNone);
  std::vector<int> first(campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row) {
    int& last = last_of_pose[campaign.pose[row]];
    const bool is_again = last != kNone && same_posture(campaign, row, last);
    first[row] = is_again ? first[last] : row;
    last = row;
  }
  return first;
}

// Writes the values of each effect to place(effect).
template <typename Place>
void evaluate(const std::vector<const BoundEffect*>& effects, const ChainEvaluator& chain,
              const Context& context, const Place& place) {
  ArmFrames frames;
  PoseJacobian jacobian;
  if (std::ranges::any_of(effects, &BoundEffect::needs_frames))
    frames = chain.link_frames(context.q);
  if (std::ranges::any_of(effects, &BoundEffect::needs_jacobian)) chain.pose(context.q, jacobian);
  for (const BoundEffect* effect : effects)
    effect->values(context, &frames, &jacobian, place(effect));
}

}  // namespace

ObservationModel::ObservationModel(const Campaign& campaign, const Robot& robot,
                                   std::vector<int> geometric, const ReadingSigma& sigma,
                                   int fitted_effects, const Pose& common_from_own)
    : campaign_(campaign),
      robot_(robot),
      geometric_(std::move(geometric)),
      targets_(match_targets(campaign, robot.chain)),
      anchors_(match_anchors(campaign, robot.chain)),
      contacts_(match_contacts(campaign, robot.chain)),
      sigma_(sigma),
      fitted_effects_(std::min(fitted_effects, static_cast<int>(robot.effects.size()))),
      common_from_own_(common_from_own),
      median_sigma_position_(stated_median(campaign.sigma_position)),
      median_sigma_orientation_(stated_median(campaign.sigma_orientation)) {
  for (const Touch& touch : campaign.touch)
    if (touch.contact >= 0) require_bound(touch);
  evaluate_effect_values(robot);
  choose_columns();
  find_replicates();
}

// The columns of the Jacobian that the unknowns need. Of base and tool, one rotation needs all
// three: turn_columns() mixes them.
void ObservationModel::choose_columns() {
  const ParameterLayout layout = layout_of(robot_.chain);
  ColumnSet needed;
  const auto need = [&](int parameter) {
    if (parameter >= layout.geometric) return;
    const bool turns =
        (parameter >= layout.tool + 3 && parameter < layout.couplings) ||
        (parameter >= kFirstBaseParameter + 3 && parameter < kFirstBaseParameter + 6);
    const int first = !turns                    ? parameter
                      : parameter < layout.tool ? kFirstBaseParameter + 3
                                                : layout.tool + 3;
    for (int k = first; k < first + (turns ? 3 : 1); ++k) needed.set(k);
  };
  for (int parameter : geometric_) need(parameter);
  for (int e = 0; e < fitted_effects_; ++e)
    for (const BoundEffect::Term& term : effects_[e].terms()) need(term.parameter);
  for (int k = 0; k < layout.geometric; ++k)
    if (needed[k]) columns_.push_back(k);
}

// The values of the drivers do not depend on the unknowns (see BoundEffect), so each is evaluated
// once per row; those that the posture decides are the same at every visit of a pose.
void ObservationModel::evaluate_effect_values(const Robot& robot) {
  int value_count = 0, coefficient_count = 0;
  for (const Effect& effect : robot.effects) {
    require_drivers(campaign_, effect);
    const BoundEffect& bound = effects_.emplace_back(effect, robot, campaign_.temperature_names);
    first_coefficient_.push_back(coefficient_count);
    first_value_.push_back(value_count);
    coefficient_count += bound.coefficient_count();
    if (std::ssize(effects_) == fitted_effects_) coefficient_count_ = coefficient_count;
    value_count += bound.value_count();
  }
  if (value_count == 0) return;
  effect_values_.resize(value_count, rows());
  std::vector<const BoundEffect*> all, of_visit;
  for (size_t e = 0; e < effects_.size(); ++e) {
    all.push_back(&effects_[e]);
    if (!is_of_posture(robot.effects[e])) of_visit.push_back(&effects_[e]);
  }
  const ChainEvaluator chain(robot.chain);
  const auto place = [&](const BoundEffect* effect, int row) {
    return &effect_values_(first_value_[effect - effects_.data()], row);
  };
  const auto evaluate_at = [&](const std::vector<const BoundEffect*>& own, int row) {
    if (!own.empty())
      evaluate(own, chain, campaign_.context(row),
               [&](const BoundEffect* effect) { return place(effect, row); });
  };
  const std::vector<int> first = first_rows_of_posture(campaign_);
  const auto for_rows = [&](const auto& take) {
    for_ordered_blocks<int>(
        rows(), kRowsPerBlock,
        [&](int begin, int end) {
          for (int row = begin; row < end; ++row) take(row);
          return 0;
        },
        [](int) {});
  };
  for_rows([&](int row) {
    if (first[row] == row) evaluate_at(all, row);
  });
  for_rows([&](int row) {
    const int before = first[row];
    if (before == row) return;
    effect_values_.col(row) = effect_values_.col(before);
    evaluate_at(of_visit, row);
  });
}

std::vector<std::string> ObservationModel::unknown_names() const {
  std::vector<std::string> names;
  for (int index : geometric_) names.push_back(parameter_name(robot_.chain, index));
  for (int e = 0; e < fitted_effects_; ++e)
    for (const std::string& coefficient : effects_[e].coefficient_names())
      names.push_back(robot_.effects[e].name + " " + to_string(robot_.effects[e].parameter) + " " +
                      coefficient);
  return names;
}

bool ObservationModel::same_prediction(int row, int other) const {
  const auto same = [&](const auto& of_rows) {
    return of_rows.empty() || of_rows[row] == of_rows[other];
  };
  return same(campaign_.pose) && same(campaign_.q) &&
         campaign_.channel(row) == campaign_.channel(other) && same(campaign_.sigma_position) &&
         same(campaign_.sigma_orientation) && same(campaign_.whitening) &&
         (effect_values_.rows() == 0 || effect_values_.col(row) == effect_values_.col(other));
}

size_t ObservationModel::hash_of_prediction(int row) const {
  // FNV-1a (Fowler, Noll, Vo), 64 bits, over hashes of the numbers instead of bytes.
  std::uint64_t hash = 14695981039346656037ULL;
  const auto add = [&](double number) {
    hash = (hash ^ std::hash<double>{}(number)) * 1099511628211ULL;
  };
  add(campaign_.pose[row]);
  add(campaign_.channel(row));
  for (double angle : campaign_.q[row]) add(angle);
  for (const std::vector<double>* stated :
       {&campaign_.sigma_position, &campaign_.sigma_orientation})
    if (!stated->empty()) add((*stated)[row]);
  if (!campaign_.whitening.empty())
    for (double number : campaign_.whitening[row].reshaped()) add(number);
  for (Eigen::Index value = 0; value < effect_values_.rows(); ++value)
    add(effect_values_(value, row));
  return hash;
}

void ObservationModel::find_replicates() {
  constexpr int kNone = -1;
  std::vector<int> number;
  number.reserve(rows());
  {
    std::vector<int> visits(campaign_.pose_ids.size()), last_of_pose(visits.size(), kNone);
    for (int pose : campaign_.pose) ++visits[pose];
    const auto hash = [&](int row) { return hash_of_prediction(row); };
    const auto same = [&](int row, int other) { return same_prediction(row, other); };
    std::unordered_map<int, int, decltype(hash), decltype(same)> number_of(0, hash, same);
    int count = 0;
    for (int row = 0; row < rows(); ++row) {
      const size_t pose = campaign_.pose[row];
      const int last = std::exchange(last_of_pose[pose], row);
      if (visits[pose] == 1)
        number.push_back(count);
      else if (last != kNone && same(row, last))  // most often; the map takes more time
        number.push_back(number[last]);
      else
        number.push_back(number_of.try_emplace(row, count).first->second);
      count = std::max(count, number.back() + 1);
    }
  }  // frees the maps before the groups take as much memory
  rows_by_prediction_ = grouped_rows(number);
  if (has_replicates()) prediction_ = std::move(number);
}

double ObservationModel::mean_square_value(int coefficient) const {
  double largest = 0;
  for (size_t e = 0; e < effects_.size(); ++e)
    for (const BoundEffect::Term& term : effects_[e].terms())
      if (first_coefficient_[e] + term.coefficient == coefficient)
        largest = std::max(largest,
                           effect_values_.row(first_value_[e] + term.value).squaredNorm() / rows());
  return largest;
}

Robot ObservationModel::robot_at(const Eigen::VectorXd& x) const {
  Robot robot = robot_;
  const int tool = layout_of(robot_.chain).tool;
  const int first_contact = first_contact_parameter(robot_.chain);
  const auto is_turn = [](int index, int first) { return index >= first + 3 && index < first + 6; };
  const auto turns_contact = [&](int index) {
    return index >= first_contact && is_turn((index - first_contact) % kParametersOfContact, 0);
  };
  for (int k = 0; k < geometric_count(); ++k)
    if (!is_turn(geometric_[k], kFirstBaseParameter) && !is_turn(geometric_[k], tool) &&
        !turns_contact(geometric_[k]))
      move_parameter(robot.chain, geometric_[k], x[k]);
  robot.chain.base.rotation =
      rotation_exp(turn_of(x, kFirstBaseParameter)) * robot_.chain.base.rotation;
  robot.chain.tool.rotation = rotation_exp(turn_of(x, tool)) * robot_.chain.tool.rotation;
  for (int c = 0; c < contact_count(robot.chain); ++c)
    robot.chain.contacts[c].place.rotation =
        robot_.chain.contacts[c].place.rotation *
        rotation_exp(turn_of(x, first_contact + kParametersOfContact * c));
  int k = geometric_count();
  for (int e = 0; e < fitted_effects_; ++e) {
    robot.effects[e].coefficients.resize(effects_[e].coefficient_count());
    for (int c = 0; c < effects_[e].coefficient_count(); ++c) {
      robot.effects[e].coefficients[c].name = effects_[e].coefficient_names()[c];
      robot.effects[e].coefficients[c].value += x[k++];
    }
  }
  return robot;
}

ReadingSigma ObservationModel::row_sigma(int row) const {
  ReadingSigma sigma = sigma_;
  if (median_sigma_position_ > 0)
    sigma.position *= campaign_.sigma_position[row] / median_sigma_position_;
  if (median_sigma_orientation_ > 0)
    sigma.orientation *= campaign_.sigma_orientation[row] / median_sigma_orientation_;
  return sigma;
}

void ObservationModel::whiten(int row, Eigen::Ref<Eigen::MatrixXd> of_row) const {
  if (campaign_.whitening.empty()) return;
  const Eigen::Matrix<double, 6, 6>& w = campaign_.whitening[row];
  if (of_row.rows() == 6) {
    const bool both = median_sigma_position_ > 0 && median_sigma_orientation_ > 0;
    const double ratio = both ? sigma_.position / median_sigma_position_ *
                                    median_sigma_orientation_ / sigma_.orientation
                              : 1.0;
    of_row.bottomRows<3>() = (w.bottomRightCorner<3, 3>() * of_row.bottomRows<3>() +
                              ratio * w.bottomLeftCorner<3, 3>() * of_row.topRows<3>())
                                 .eval();
  }
  of_row.topRows<3>() = (w.topLeftCorner<3, 3>() * of_row.topRows<3>()).eval();
}

NumbersOfRow ObservationModel::whitened(int row, Eigen::Matrix<double, 6, 1> residual) const {
  const ReadingSigma sigma = row_sigma(row);
  residual.head<3>() /= sigma.position;
  residual.tail<3>() /= sigma.orientation;
  const ReadingSize size = campaign_.reading_size();
  whiten(row, residual.head(size.all()));
  NumbersOfRow white(size.all());
  white << residual.head(size.position), residual.segment(3, size.orientation);
  return white;
}

Eigen::Vector3d ObservationModel::turn_of(const Eigen::VectorXd& x, int first_parameter) const {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (int k = 0; k < geometric_count(); ++k)
    if (geometric_[k] >= first_parameter + 3 && geometric_[k] < first_parameter + 6)
      turn[geometric_[k] - first_parameter - 3] = x[k];
  return turn;
}

ObservationModel::At ObservationModel::at(const Eigen::VectorXd& x) const { return At(*this, x); }

}  // namespace armtrue
