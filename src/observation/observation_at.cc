#include <algorithm>
#include <array>
#include <type_traits>

#include "armtrue/kinematics/contact.h"
#include "armtrue/observation/observation.h"

namespace armtrue {
namespace {

// Rows that are evaluated together: a multiple of the length of SIMD vectors, and few enough that
// their Jacobians fit into the cache.
constexpr int kPosesAtOnce = 8;

template <typename Jacobian>
void turn_columns(Jacobian& jacobian, int first, const Eigen::Matrix3d& turn) {
  if (turn.isIdentity(0.0)) return;
  const Eigen::Matrix<double, 6, 3> columns = jacobian.template middleCols<3>(first);
  jacobian.template middleCols<3>(first) = columns * turn;
}

}  // namespace

ObservationModel::At::At(const ObservationModel& model, const Eigen::VectorXd& x)
    : model_(model),
      robot_(model.robot_at(x)),
      layout_(layout_of(robot_.chain)),
      chain_(robot_.chain) {
  for (size_t e = 0; e < model.effects_.size(); ++e)
    for (const BoundEffect::Term& term : model.effects_[e].terms())
      terms_.push_back({robot_.effects[e].coefficients[term.coefficient].value, term.parameter,
                        model.first_value_[e] + term.value});
  // exp(x + dx) = exp(Jl(x) dx) exp(x), and Jl(x) = Jr(-x).
  base_turn_ = inverse_right_jacobian(-model.turn_of(x, kFirstBaseParameter)).inverse();
  tool_turn_ = inverse_right_jacobian(-model.turn_of(x, layout_.tool)).inverse();
  // exp(x + dx) = exp(x) exp(Jr(x) dx).
  const int first = first_contact_parameter(robot_.chain);
  for (int c = 0; c < std::ssize(robot_.chain.contacts); ++c)
    contact_turns_.emplace_back(
        inverse_right_jacobian(model.turn_of(x, first + kParametersOfContact * c)).inverse());
  if (!model.has_replicates()) return;
  const GroupedRows& rows = model.rows_by_prediction_;
  predictions_.reserve(rows.groups());
  for_each_prediction<false>(
      rows.groups(), [&](int k) { return rows.rows(k).front(); },
      [&](int, int, const Prediction& predicted) { predictions_.push_back(predicted); });
}

Eigen::VectorXd ObservationModel::At::offsets(int row) const {
  Eigen::VectorXd offsets = Eigen::VectorXd::Zero(parameter_count(robot_.chain));
  if (terms_.empty()) return offsets;
  const double* const values = model_.effect_values_.col(row).data();
  for (auto term = terms_.begin(); term != terms_.end();) {
    // A series has many terms of one parameter: their sum stays in a register.
    const int parameter = term->parameter;
    double sum = offsets[parameter];
    for (; term != terms_.end() && term->parameter == parameter; ++term)
      sum += term->coefficient * values[term->value];
    offsets[parameter] = sum;
  }
  return offsets;
}

LineOfSight ObservationModel::At::line_of_sight(const Pose& frame) const {
  return {model_.common_from_own_ * instrument_place(robot_), upwards(robot_), frame.translation};
}

ObservationModel::At::Prediction ObservationModel::At::predict(int row,
                                                               PoseJacobian* jacobian) const {
  const JointVector& q = model_.campaign_.q[row];
  if (model_.effects_.empty())
    return predict(row, jacobian ? chain_.pose(q, *jacobian) : chain_.pose(q), {});
  const Eigen::VectorXd offset = offsets(row);
  const ParameterOffsets of_chain = offset.head(layout_.geometric);
  return predict(row, jacobian ? chain_.pose(q, of_chain, *jacobian) : chain_.pose(q, of_chain),
                 offset);
}

template <bool kWithJacobian, typename RowOf, typename Take>
void ObservationModel::At::for_each_prediction(int count, const RowOf& row_of,
                                               const Take& take) const {
  std::array<JointVector, kPosesAtOnce> q;
  std::array<Pose, kPosesAtOnce> frames;
  constexpr size_t kLanes = LaneJacobians::kCount;
  std::array<LaneJacobians, kWithJacobian ? kPosesAtOnce / kLanes : 0> jacobians;
  std::vector<Eigen::VectorXd> all(model_.effects_.empty() ? 0 : kPosesAtOnce);
  std::vector<ParameterOffsets> of_chain(all.size());
  ColumnSet columns;
  for (int k : model_.columns_) columns.set(k);
  const Eigen::VectorXd none;
  for (int begin = 0; begin < count; begin += kPosesAtOnce) {
    const int rows = std::min(kPosesAtOnce, count - begin);
    for (int k = 0; k < rows; ++k) {
      const int row = row_of(begin + k);
      q[k] = model_.campaign_.q[row];
      if (all.empty()) continue;
      all[k] = offsets(row);
      of_chain[k] = all[k].head(layout_.geometric);
    }
    const auto of_rows = std::span<const JointVector>(q).first(rows);
    const auto moved = std::span<const ParameterOffsets>(of_chain).first(all.empty() ? 0 : rows);
    if constexpr (kWithJacobian)
      chain_.poses(of_rows, moved, std::span(frames).first(rows),
                   std::span(jacobians).first((rows + kLanes - 1) / kLanes), columns);
    else
      chain_.poses(of_rows, moved, std::span(frames).first(rows));
    for (int k = 0; k < rows; ++k) {
      const int number = begin + k, row = row_of(number);
      const Prediction predicted = predict(row, frames[k], all.empty() ? none : all[k]);
      if constexpr (kWithJacobian) {
        auto jacobian = jacobians[k / kLanes][k % kLanes];
        take(number, row, predicted, jacobian);
      } else {
        take(number, row, predicted);
      }
    }
  }
}

ObservationModel::At::Prediction ObservationModel::At::predict(
    int row, const Pose& a_from_measured, const Eigen::VectorXd& offset) const {
  Prediction predicted;
  predicted.scale = 1.0;
  predicted.frame = a_from_measured;
  Pose& frame = predicted.frame;
  if (offset.size() > 0) predicted.scale += offset[layout_.instrument_scale];
  const Campaign& campaign = model_.campaign_;
  Eigen::Vector3d point = campaign.own_point(row);
  if (!model_.targets_.empty()) {
    const int target = model_.targets_[campaign.target[row]];
    point = robot_.chain.targets[target].position;
    if (offset.size() > 0) point += offset.segment<3>(layout_.targets + 3 * target);
  }
  predicted.lever = frame.rotation * point;
  frame.translation += predicted.lever;
  predicted.position = frame.translation - model_.common_from_own_.translation;
  const ReadingKind kind = campaign.kind(row);
  if (kind == ReadingKind::pixel) {
    predict_pixel(row, a_from_measured, offset, predicted);
    return predicted;
  }
  if (kind == ReadingKind::touch) {
    if (model_.reads_beam(row))
      predict_beam(row, a_from_measured, offset, predicted);
    else
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
    case ReadingKind::pixel:
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
  return predictions_.empty() ? residual(row, predict(row, nullptr))
                              : residual(row, predictions_[model_.prediction_of(row)]);
}

void ObservationModel::At::set_instrument_column(int row, int parameter,
                                                 const Prediction& predicted, double sigma,
                                                 Eigen::Ref<Eigen::VectorXd> column) const {
  const ReadingKind kind = model_.campaign_.kind(row);
  const bool is_length = kind != ReadingKind::point;
  const bool is_of_contact = kind == ReadingKind::touch || kind == ReadingKind::pixel;
  const int first_anchor = first_anchor_parameter(robot_.chain);
  column.setZero();
  if (parameter == layout_.arm_scale) return;  // its effects are terms of the lengths themselves
  if (parameter >= first_contact_parameter(robot_.chain)) {
    if (kind == ReadingKind::pixel)
      column[0] = pixel_column(row, parameter, predicted) / sigma;
    else if (kind == ReadingKind::touch)
      column[0] = touch_column(row, parameter, predicted) / sigma;
  } else if (is_of_contact && layout_.is_of_instrument(parameter)) {
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
  } else if (!model_.targets_.empty() && model_.reads_target(row)) {
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

void ObservationModel::At::residuals(int first, std::span<Eigen::Matrix<double, 6, 1>> out) const {
  if (!predictions_.empty()) {
    for (int k = 0; k < std::ssize(out); ++k) out[k] = residual(first + k);
    return;
  }
  for_each_prediction<false>(
      static_cast<int>(out.size()), [&](int k) { return first + k; },
      [&](int k, int row, const Prediction& predicted) { out[k] = residual(row, predicted); });
}

void ObservationModel::At::block(int row, Eigen::Ref<Eigen::MatrixXd> out) const {
  PoseJacobian jacobian;
  const Prediction predicted = predict(row, &jacobian);
  write_block(row, predicted, Turn::by_residual, jacobian, out);
}

void ObservationModel::At::blocks(int first, int count, Eigen::Ref<Eigen::MatrixXd> out) const {
  const int size = model_.row_size();
  for_each_prediction<true>(
      count, [&](int k) { return first + k; },
      [&](int k, int row, const Prediction& predicted, auto& jacobian) {
        write_block(row, predicted, Turn::by_residual, jacobian, out.middleRows(k * size, size));
      });
}

void ObservationModel::At::blocks_of_predictions(int first, int count,
                                                 Eigen::Ref<Eigen::MatrixXd> out) const {
  const int size = model_.row_size();
  const GroupedRows& rows = model_.rows_by_prediction_;
  for_each_prediction<true>(
      count, [&](int k) { return rows.rows(first + k).front(); },
      [&](int k, int row, const Prediction& predicted, auto& jacobian) {
        const Turn turn = rows.rows(first + k).size() > 1 ? Turn::none : Turn::by_residual;
        write_block(row, predicted, turn, jacobian, out.middleRows(k * size, size));
      });
}

// `jacobian` is changed: only its columns in columns_ are read.
template <typename Jacobian>
void ObservationModel::At::write_block(int row, const Prediction& predicted, Turn kind,
                                       Jacobian& jacobian, Eigen::Ref<Eigen::MatrixXd> out) const {
  const Eigen::Matrix<double, 6, 1> r = residual(row, predicted);
  const int size = model_.row_size();
  if (!predicted.lever.isZero(0))
    for (int k : model_.columns_) {
      const Eigen::Vector3d turned = jacobian.col(k).template tail<3>();
      jacobian.col(k).template head<3>() += turned.cross(predicted.lever);
    }
  // A turn e of the model turns the residual by -Jr^-1(residual) e; near zero that is -e.
  if (kind == Turn::by_residual && size == 6 && r.tail<3>().squaredNorm() > 1e-6) {
    const Eigen::Matrix3d turn = inverse_right_jacobian(r.tail<3>());
    for (int k : model_.columns_)
      jacobian.col(k).template tail<3>() = (turn * jacobian.col(k).template tail<3>()).eval();
  }
  if (predicted.scale != 1.0)
    for (int k : model_.columns_) jacobian.col(k).template head<3>() *= predicted.scale;
  const auto has = [&](int parameter) {
    return std::ranges::binary_search(model_.columns_, parameter);
  };
  if (has(kFirstBaseParameter + 3)) turn_columns(jacobian, kFirstBaseParameter + 3, base_turn_);
  if (has(layout_.tool + 3)) turn_columns(jacobian, layout_.tool + 3, tool_turn_);
  if (model_.campaign_.kind(row) != ReadingKind::point)
    for (int k : model_.columns_)
      jacobian(0, k) = predicted.direction.dot(jacobian.col(k).template head<3>());

  const ReadingSigma sigma = model_.row_sigma(row);
  Eigen::Matrix<double, 6, 1> weight;
  weight.head<3>().setConstant(1.0 / sigma.position);
  weight.tail<3>().setConstant(1.0 / sigma.orientation);

  const auto copy = [&](auto rows, int k, int index) {
    for (int i = 0; i < rows; ++i) out(i, k) = jacobian(i, index) * weight[i];
  };
  constexpr std::integral_constant<int, 6> kWholePose;  // a loop that the compiler unrolls
  for (int k = 0; k < model_.geometric_count(); ++k)
    if (const int index = model_.geometric_[k]; index >= layout_.geometric)
      set_instrument_column(row, index, predicted, sigma.position, out.col(k));
    else if (size == kWholePose)
      copy(kWholePose, k, index);
    else
      copy(size, k, index);
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
