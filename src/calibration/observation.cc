#include "armtrue/calibration/observation.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "armtrue/kinematics/contact.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

// Rows that are evaluated together: whole vectors, and Jacobians that fit into the cache.
constexpr int kPosesAtOnce = 8;

void turn_columns(PoseJacobian& jacobian, int first, const Eigen::Matrix3d& turn) {
  if (turn.isIdentity(0.0)) return;
  const Eigen::Matrix<double, 6, 3> columns = jacobian.middleCols<3>(first);
  jacobian.middleCols<3>(first) = columns * turn;
}

// 0 where no row states a standard deviation.
double stated_median(const std::vector<double>& deviations) {
  return deviations.empty() ? 0.0 : median(deviations);
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
}

// Those that the unknowns need. Of base and tool a rotation comes with the other two: the blocks
// turn them into each other.
void ObservationModel::choose_columns() {
  const ParameterLayout layout = layout_of(robot_.chain);
  ColumnSet needed;
  const auto need = [&](int parameter) {
    if (parameter >= layout.geometric) return;
    const bool turns = parameter >= layout.tool + 3 ||
                       (parameter >= kBaseParameters + 3 && parameter < kBaseParameters + 6);
    const int first = !turns                    ? parameter
                      : parameter < layout.tool ? kBaseParameters + 3
                                                : layout.tool + 3;
    for (int k = first; k < first + (turns ? 3 : 1); ++k) needed.set(static_cast<size_t>(k));
  };
  for (int parameter : geometric_) need(parameter);
  for (int e = 0; e < fitted_effects_; ++e)
    for (const BoundEffect::Term& term : effects_[static_cast<size_t>(e)].terms())
      need(term.parameter);
  for (int k = 0; k < layout.geometric; ++k)
    if (needed[static_cast<size_t>(k)]) columns_.push_back(k);
}

// The values of the drivers do not depend on the unknowns (see BoundEffect), so each is evaluated
// once per row.
void ObservationModel::evaluate_effect_values(const Robot& robot) {
  int value_count = 0, coefficient_count = 0;
  bool needs_frames = false, needs_jacobian = false;
  for (const Effect& effect : robot.effects) {
    require_drivers(campaign_, effect);
    const BoundEffect& bound = effects_.emplace_back(effect, robot, campaign_.temperature_names);
    first_coefficient_.push_back(coefficient_count);
    first_value_.push_back(value_count);
    coefficient_count += bound.coefficient_count();
    if (static_cast<int>(effects_.size()) == fitted_effects_)
      coefficient_count_ = coefficient_count;
    value_count += bound.value_count();
    needs_frames |= bound.needs_frames();
    needs_jacobian |= bound.needs_jacobian();
  }
  if (value_count == 0) return;
  effect_values_.resize(value_count, rows());
  const ChainEvaluator chain(robot.chain);
  for (int row = 0; row < rows(); ++row) {
    const Context context = campaign_.context(row);
    ArmFrames frames;
    PoseJacobian jacobian;
    if (needs_frames) frames = chain.link_frames(context.q);
    if (needs_jacobian) chain.pose(context.q, jacobian);
    for (size_t e = 0; e < effects_.size(); ++e)
      effects_[e].values(context, &frames, &jacobian, &effect_values_(first_value_[e], row));
  }
}

std::vector<std::string> ObservationModel::unknown_names() const {
  std::vector<std::string> names;
  for (int index : geometric_) names.push_back(parameter_name(robot_.chain, index));
  for (int e = 0; e < fitted_effects_; ++e)
    for (const std::string& coefficient : effects_[e].coefficient_names())
      names.push_back(robot_.effects[e].name + " " + robot_.effects[e].parameter + " " +
                      coefficient);
  return names;
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
    if (!is_turn(geometric_[k], kBaseParameters) && !is_turn(geometric_[k], tool) &&
        !turns_contact(geometric_[k]))
      move_parameter(robot.chain, geometric_[k], x[k]);
  robot.chain.base.rotation =
      rotation_exp(turn_of(x, kBaseParameters)) * robot_.chain.base.rotation;
  robot.chain.tool.rotation = rotation_exp(turn_of(x, tool)) * robot_.chain.tool.rotation;
  for (size_t c = 0; c < robot.chain.contacts.size(); ++c)
    robot.chain.contacts[c].place.rotation =
        robot_.chain.contacts[c].place.rotation *
        rotation_exp(turn_of(x, first_contact + kParametersOfContact * static_cast<int>(c)));
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

Eigen::Vector3d ObservationModel::turn_of(const Eigen::VectorXd& x, int first_parameter) const {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (int k = 0; k < geometric_count(); ++k)
    if (geometric_[k] >= first_parameter + 3 && geometric_[k] < first_parameter + 6)
      turn[geometric_[k] - first_parameter - 3] = x[k];
  return turn;
}

ObservationModel::At ObservationModel::at(const Eigen::VectorXd& x) const { return At(*this, x); }

ObservationModel::At::At(const ObservationModel& model, const Eigen::VectorXd& x)
    : model_(model),
      robot_(model.robot_at(x)),
      layout_(layout_of(robot_.chain)),
      chain_(robot_.chain) {
  // exp(x + dx) = exp(Jl(x) dx) exp(x), and Jl(x) = Jr(-x).
  base_turn_ = inverse_right_jacobian(-model.turn_of(x, kBaseParameters)).inverse();
  tool_turn_ = inverse_right_jacobian(-model.turn_of(x, layout_.tool)).inverse();
  // exp(x + dx) = exp(x) exp(Jr(x) dx).
  const int first = first_contact_parameter(robot_.chain);
  for (int c = 0; c < static_cast<int>(robot_.chain.contacts.size()); ++c)
    contact_turns_.emplace_back(
        inverse_right_jacobian(model.turn_of(x, first + kParametersOfContact * c)).inverse());
}

Eigen::VectorXd ObservationModel::At::offsets(int row) const {
  Eigen::VectorXd offsets = Eigen::VectorXd::Zero(parameter_count(robot_.chain));
  for (size_t e = 0; e < model_.effects_.size(); ++e)
    for (const BoundEffect::Term& term : model_.effects_[e].terms())
      offsets[term.parameter] += robot_.effects[e].coefficients[term.coefficient].value *
                                 model_.effect_values_(model_.first_value_[e] + term.value, row);
  return offsets;
}

LineOfSight ObservationModel::At::line_of_sight(const Pose& frame) const {
  return {model_.common_from_own_ * instrument_place(robot_), upwards(robot_), frame.translation};
}

ObservationModel::At::Prediction ObservationModel::At::predict(int row,
                                                               PoseJacobian* jacobian) const {
  const JointVector& q = model_.campaign_.q[row];
  if (model_.effects_.empty())
    return predict(row, jacobian ? chain_.pose(q, *jacobian) : chain_.pose(q), {}, jacobian);
  const Eigen::VectorXd offset = offsets(row);
  const ParameterOffsets of_chain = offset.head(layout_.geometric);
  return predict(row, jacobian ? chain_.pose(q, of_chain, *jacobian) : chain_.pose(q, of_chain),
                 offset, jacobian);
}

template <bool kWithJacobian, typename Take>
void ObservationModel::At::for_each_prediction(int first, int count, const Take& take) const {
  std::array<Pose, kPosesAtOnce> frames;
  std::array<PoseJacobian, kWithJacobian ? kPosesAtOnce : 1> jacobians;
  std::vector<Eigen::VectorXd> all(model_.effects_.empty() ? 0 : kPosesAtOnce);
  std::vector<ParameterOffsets> of_chain(all.size());
  ColumnSet columns;
  for (int k : model_.columns_) columns.set(static_cast<size_t>(k));
  const std::span<const JointVector> q(model_.campaign_.q);
  const Eigen::VectorXd none;
  for (int begin = first; begin < first + count; begin += kPosesAtOnce) {
    const auto rows = static_cast<size_t>(std::min(kPosesAtOnce, first + count - begin));
    for (size_t k = 0; k < std::min(rows, all.size()); ++k) {
      all[k] = offsets(begin + static_cast<int>(k));
      of_chain[k] = all[k].head(layout_.geometric);
    }
    const auto of_rows = q.subspan(static_cast<size_t>(begin), rows);
    const auto moved = std::span<const ParameterOffsets>(of_chain).first(all.empty() ? 0 : rows);
    if constexpr (kWithJacobian)
      chain_.poses(of_rows, moved, std::span(frames).first(rows), std::span(jacobians).first(rows),
                   columns);
    else
      chain_.poses(of_rows, moved, std::span(frames).first(rows));
    for (size_t k = 0; k < rows; ++k) {
      const int row = begin + static_cast<int>(k);
      PoseJacobian* const jacobian = kWithJacobian ? &jacobians[k] : nullptr;
      take(row, predict(row, frames[k], all.empty() ? none : all[k], jacobian), jacobian);
    }
  }
}

ObservationModel::At::Prediction ObservationModel::At::predict(int row, const Pose& a_from_measured,
                                                               const Eigen::VectorXd& offset,
                                                               PoseJacobian* jacobian) const {
  Prediction predicted;
  predicted.scale = 1.0;
  predicted.frame = a_from_measured;
  Pose& frame = predicted.frame;
  if (offset.size() > 0) predicted.scale += offset[layout_.instrument_scale];
  if (!model_.targets_.empty()) {
    const int target = model_.targets_[model_.campaign_.target[row]];
    Eigen::Vector3d place = robot_.chain.targets[target].position;
    if (offset.size() > 0) place += offset.segment<3>(layout_.targets + 3 * target);
    const Eigen::Vector3d lever = frame.rotation * place;
    if (jacobian)
      for (int k : model_.columns_) {
        const Eigen::Vector3d turned = jacobian->col(k).tail<3>();
        jacobian->col(k).head<3>() += turned.cross(lever);
      }
    frame.translation += lever;
  }
  predicted.position = frame.translation - model_.common_from_own_.translation;
  const Campaign& campaign = model_.campaign_;
  const ReadingKind kind = campaign.kind(row);
  if (kind == ReadingKind::touch) {
    predict_touch(row, offset, predicted);
    return predicted;
  }
  if (offset.size() > 0 && kind != ReadingKind::distance) {
    const Eigen::Vector3d errors = offset.segment<3>(layout_.instrument_range);
    if (!errors.isZero(0)) predicted.off = line_of_sight(frame).derivatives() * errors;
  }
  switch (kind) {
    case ReadingKind::point:
      break;
    case ReadingKind::coordinate:
      predicted.direction = model_.common_from_own_.rotation.col(campaign.coordinate[row]->axis);
      predicted.position = {predicted.direction.dot(predicted.position), 0, 0};
      predicted.off = {predicted.direction.dot(predicted.off), 0, 0};
      break;
    case ReadingKind::distance: {
      const int number = model_.anchor_of(row);
      Eigen::Vector3d place = robot_.chain.anchors[number].position;
      predicted.zero = robot_.chain.anchors[number].zero;
      if (offset.size() > 0) {
        const int first = first_anchor_parameter(robot_.chain) + 4 * number;
        place += offset.segment<3>(first);
        predicted.zero += offset[first + 3];
      }
      const Eigen::Vector3d wire = frame.translation - model_.common_from_own_ * place;
      predicted.position = {wire.norm(), 0, 0};
      predicted.direction = wire.normalized();
      break;
    }
    case ReadingKind::touch:
      break;
  }
  return predicted;
}

Eigen::Matrix<double, 6, 1> ObservationModel::At::residual(int row,
                                                           const Prediction& predicted) const {
  const Campaign& campaign = model_.campaign_;
  Eigen::Matrix<double, 6, 1> residual = Eigen::Matrix<double, 6, 1>::Zero();
  const ReadingKind kind = campaign.kind(row);
  if (kind == ReadingKind::point) {
    residual.head<3>() =
        campaign.position[row] - (model_.common_from_own_.translation +
                                  predicted.scale * predicted.position + predicted.off);
  } else {
    residual[0] = campaign.length(row) - predicted.zero - predicted.scale * predicted.position[0] -
                  predicted.off[0];
  }
  if (campaign.has_orientation())
    residual.tail<3>() = rotation_log(campaign.orientation[row].toRotationMatrix() *
                                      predicted.frame.rotation.transpose());
  return residual;
}

Eigen::Matrix<double, 6, 1> ObservationModel::At::residual(int row) const {
  return residual(row, predict(row, nullptr));
}

void ObservationModel::At::set_instrument_column(int row, int parameter,
                                                 const Prediction& predicted, double sigma,
                                                 Eigen::Ref<Eigen::VectorXd> column) const {
  const ReadingKind kind = model_.campaign_.kind(row);
  const bool is_length = kind != ReadingKind::point;
  const int first_anchor = first_anchor_parameter(robot_.chain);
  column.setZero();
  if (parameter >= first_contact_parameter(robot_.chain)) {
    if (kind == ReadingKind::touch) column[0] = touch_column(row, parameter, predicted) / sigma;
  } else if (kind == ReadingKind::touch && layout_.is_of_instrument(parameter)) {
    return;
  } else if (parameter == layout_.instrument_scale) {
    const int size = is_length ? 1 : 3;
    column.head(size) = predicted.position.head(size) / sigma;
  } else if (layout_.is_of_instrument(parameter)) {
    if (kind == ReadingKind::distance) return;
    const Eigen::Vector3d motion =
        line_of_sight(predicted.frame).derivatives().col(parameter - layout_.instrument_range) /
        sigma;
    if (is_length)
      column[0] = predicted.direction.dot(motion);
    else
      column.head<3>() = motion;
  } else if (parameter >= first_anchor) {
    const int anchor = (parameter - first_anchor) / 4, which = (parameter - first_anchor) % 4;
    if (kind == ReadingKind::distance && anchor == model_.anchor_of(row))
      column[0] =
          (which == 3 ? 1.0
                      : -predicted.scale *
                            predicted.direction.dot(model_.common_from_own_.rotation.col(which))) /
          sigma;
  } else if (!model_.targets_.empty()) {
    const int target = (parameter - layout_.targets) / 3;
    const int axis = (parameter - layout_.targets) % 3;
    if (target != model_.targets_[model_.campaign_.target[row]]) return;
    const Eigen::Vector3d motion = predicted.frame.rotation.col(axis) * (predicted.scale / sigma);
    if (is_length)
      column[0] = predicted.direction.dot(motion);
    else
      column.head<3>() = motion;
  }
}

void ObservationModel::At::residuals(int first,
                                     std::span<Eigen::Matrix<double, 6, 1>> out) const {
  for_each_prediction<false>(first, static_cast<int>(out.size()),
                             [&](int row, const Prediction& predicted, const PoseJacobian*) {
                               out[static_cast<size_t>(row - first)] = residual(row, predicted);
                             });
}

void ObservationModel::At::block(int row, Eigen::Ref<Eigen::MatrixXd> out) const {
  PoseJacobian jacobian;
  const Prediction predicted = predict(row, &jacobian);
  write_block(row, predicted, jacobian, out);
}

void ObservationModel::At::blocks(int first, int count, Eigen::Ref<Eigen::MatrixXd> out) const {
  const int size = model_.row_size();
  for_each_prediction<true>(
      first, count, [&](int row, const Prediction& predicted, PoseJacobian* jacobian) {
        write_block(row, predicted, *jacobian, out.middleRows((row - first) * size, size));
      });
}

// `jacobian` is changed: only its columns in columns_ are read.
void ObservationModel::At::write_block(int row, const Prediction& predicted, PoseJacobian& jacobian,
                                       Eigen::Ref<Eigen::MatrixXd> out) const {
  const Eigen::Matrix<double, 6, 1> r = residual(row, predicted);
  const int size = model_.row_size();
  // A turn e of the model turns the residual by -Jr^-1(residual) e; near zero that is -e.
  if (size == 6 && r.tail<3>().squaredNorm() > 1e-6) {
    const Eigen::Matrix3d turn = inverse_right_jacobian(r.tail<3>());
    for (int k : model_.columns_)
      jacobian.col(k).tail<3>() = (turn * jacobian.col(k).tail<3>()).eval();
  }
  if (predicted.scale != 1.0)
    for (int k : model_.columns_) jacobian.col(k).head<3>() *= predicted.scale;
  const auto has = [&](int parameter) {
    return std::ranges::binary_search(model_.columns_, parameter);
  };
  if (has(kBaseParameters + 3)) turn_columns(jacobian, kBaseParameters + 3, base_turn_);
  if (has(layout_.tool + 3)) turn_columns(jacobian, layout_.tool + 3, tool_turn_);
  if (model_.campaign_.kind(row) != ReadingKind::point)
    for (int k : model_.columns_) jacobian(0, k) = predicted.direction.dot(jacobian.col(k).head<3>());

  const ReadingSigma sigma = model_.row_sigma(row);
  Eigen::Matrix<double, 6, 1> weight;
  weight.head<3>().setConstant(1.0 / sigma.position);
  weight.tail<3>().setConstant(1.0 / sigma.orientation);

  for (int k = 0; k < model_.geometric_count(); ++k)
    if (const int index = model_.geometric_[k]; index < layout_.geometric)
      for (int i = 0; i < size; ++i) out(i, k) = jacobian(i, index) * weight[i];
    else
      set_instrument_column(row, index, predicted, sigma.position, out.col(k));
  out.col(model_.unknowns()) = r.head(size).cwiseProduct(weight.head(size));
  const int first = model_.geometric_count();
  if (model_.coefficient_count_ > 0) out.middleCols(first, model_.coefficient_count_).setZero();
  Eigen::VectorXd of_reading(size);
  for (int e = 0; e < model_.fitted_effects_; ++e)
    for (const BoundEffect::Term& term : model_.effects_[e].terms()) {
      const double value = model_.effect_values_(model_.first_value_[e] + term.value, row);
      auto column = out.col(first + model_.first_coefficient_[e] + term.coefficient);
      if (term.parameter < layout_.geometric) {
        column += (jacobian.col(term.parameter).head(size).cwiseProduct(weight.head(size))) * value;
      } else {
        set_instrument_column(row, term.parameter, predicted, sigma.position, of_reading);
        column += of_reading * value;
      }
    }
  model_.whiten(row, out);
}

}  // namespace armtrue
