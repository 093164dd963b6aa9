#include "search/scan.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kMaxVariation = 0.02;  // m or rad: more is a mistake, not an effect

// Two effects with the same key have the same values in every context.
std::string value_key(const Effect& effect) {
  const Shape& shape = effect.shape;
  std::string members;
  for (const Effect& member : effect.members) members += "|" + member.parameter + value_key(member);
  if (!members.empty()) return members;
  std::string key = to_string(effect.driver) + "|" + to_string(shape) + "|" +
                    std::to_string(static_cast<int>(shape.basis)) + "|" +
                    std::to_string(shape.count) + "|" + std::to_string(shape.at) + "|" +
                    std::to_string(shape.tau) + "|" + std::to_string(shape.low[0]) + "|" +
                    std::to_string(shape.high[0]) + "|" + std::to_string(shape.low[1]) + "|" +
                    std::to_string(shape.high[1]) + "|" + std::to_string(shape.low[2]) + "|" +
                    std::to_string(shape.high[2]);
  if (effect.driver.kind == DriverKind::moment || effect.driver.involves(DriverKind::force))
    key += "|" + effect.parameter;
  return key;
}

bool same(const Context& a, const Context& b) {
  return a.q == b.q && a.arrival == b.arrival && a.stroke == b.stroke && a.time_s == b.time_s &&
         a.payload_kg == b.payload_kg && a.motor_torque_nm == b.motor_torque_nm &&
         a.force_n == b.force_n && a.temperature_c == b.temperature_c;
}

}  // namespace

CandidateScan::CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                             const Campaign& campaign)
    : candidates_(candidates),
      links_(link_count(robot.chain)),
      max_scale_(campaign.has_distances() ? kMaxVariation : 1e-3) {
  std::vector<Context> contexts;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Context context = campaign.context(row);
    if (contexts.empty() || !same(context, contexts.back())) contexts.push_back(context);
    context_of_row_.push_back(static_cast<int>(contexts.size()) - 1);
  }

  std::vector<BoundEffect> sources;  // of values, each once
  std::vector<int> first_value;      // of each source, and one past the last
  int value_count = 0;
  std::map<std::string, int> source_of_key;
  std::vector<std::vector<Term>> terms_by_value;  // `column` is the value
  for (const Candidate& candidate : candidates) {
    BoundEffect bound(candidate.effect, robot, campaign.temperature_names);
    const auto [place, is_new] =
        source_of_key.try_emplace(value_key(candidate.effect), static_cast<int>(sources.size()));
    if (is_new) {
      first_value.push_back(value_count);
      value_count += bound.value_count();
    }
    std::vector<Term>& terms = terms_by_value.emplace_back();
    for (const BoundEffect::Term& term : bound.terms())
      terms.push_back({term.coefficient, term.parameter, first_value[place->second] + term.value});
    coefficient_count_.push_back(bound.coefficient_count());
    if (is_new) sources.push_back(std::move(bound));
  }
  first_value.push_back(value_count);
  share_columns(std::move(terms_by_value), static_cast<size_t>(parameter_count(robot.chain)));
  fill_values(sources, first_value, robot, contexts);
}

// Numbers the columns: one for each pair of parameter and value that occurs.
void CandidateScan::share_columns(std::vector<std::vector<Term>> terms_by_value,
                                  size_t parameters) {
  std::vector<std::map<int, int>> column_of_value(parameters);
  for (const auto& terms : terms_by_value)
    for (const Term& term : terms) column_of_value[term.parameter].try_emplace(term.column, 0);
  for (auto& columns : column_of_value) {
    first_column_.push_back(static_cast<int>(value_of_column_.size()));
    for (auto& [value, column] : columns) {
      column = static_cast<int>(value_of_column_.size());
      value_of_column_.push_back(value);
    }
  }
  first_column_.push_back(static_cast<int>(value_of_column_.size()));
  terms_ = std::move(terms_by_value);
  for (auto& terms : terms_)
    for (Term& term : terms) term.column = column_of_value[term.parameter][term.column];
}

void CandidateScan::fill_values(const std::vector<BoundEffect>& sources,
                                const std::vector<int>& first_value, const Robot& robot,
                                const std::vector<Context>& contexts) {
  bool needs_frames = false, needs_jacobian = false;
  for (const BoundEffect& source : sources) {
    needs_frames |= source.needs_frames();
    needs_jacobian |= source.needs_jacobian();
  }
  const ChainEvaluator chain(robot.chain);
  const int value_count = first_value.back();
  values_.resize(static_cast<int>(contexts.size()), value_count);
  for_ordered_blocks<int>(
      static_cast<int>(contexts.size()), 64,
      [&](int begin, int end) {
        Eigen::VectorXd values(value_count);
        ArmFrames frames;
        PoseJacobian jacobian;
        for (int k = begin; k < end; ++k) {
          if (needs_frames) frames = chain.link_frames(contexts[k].q);
          if (needs_jacobian) chain.pose(contexts[k].q, jacobian);
          for (size_t s = 0; s < sources.size(); ++s)
            sources[s].values(contexts[k], &frames, &jacobian, values.data() + first_value[s]);
          values_.row(k) = values.cast<float>();
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
          static_cast<double>(values[context_of_row_[row]]) *
          fit.jacobian().col(term.parameter).segment(row * size, size);
  }
  return columns;
}

double CandidateScan::share_of_possible(int candidate, const Eigen::VectorXd& coefficients) const {
  std::map<int, Eigen::VectorXd> offsets;
  for (const Term& term : terms_[candidate]) {
    auto& offset =
        offsets.try_emplace(term.parameter, Eigen::VectorXd::Zero(values_.rows())).first->second;
    offset +=
        coefficients[term.coefficient] * values_.col(value_of_column_[term.column]).cast<double>();
  }
  double largest = 0;
  const ParameterLayout layout(links_);
  for (const auto& [parameter, offset] : offsets) {
    // The model fits no constants of the instrument, so their mean counts as variation.
    const double constant = layout.is_of_instrument(parameter) ? 0 : offset.mean();
    const double most = parameter == layout.instrument_scale ? max_scale_ : kMaxVariation;
    largest = std::max(largest, std::sqrt((offset.array() - constant).square().mean()) / most);
  }
  return largest;
}

bool CandidateScan::is_possible(int candidate, const Eigen::VectorXd& coefficients) const {
  if (candidates_[candidate].only_positive && coefficients.size() == 1 && coefficients[0] <= 0)
    return false;
  return share_of_possible(candidate, coefficients) < 1;
}

}  // namespace armtrue
