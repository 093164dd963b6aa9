#include "search/scan.h"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>

#include "armtrue/effects/posture.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

// Two effects with the same key have the same values in every context.
std::string value_key(const Effect& effect) {
  const Shape& shape = effect.shape;
  std::string members;
  for (const Effect& member : effect.members)
    members += "|" + to_string(member.parameter) + value_key(member);
  if (!members.empty()) return members;
  std::string key = to_string(effect.driver) + "|" + to_string(shape) + "|" +
                    std::to_string(static_cast<int>(shape.basis)) + "|" +
                    std::to_string(shape.count);
  const auto add = [&](double number) {  // all its bits: places between two readings may be close
    key += "|" + std::to_string(std::bit_cast<std::uint64_t>(number));
  };
  add(shape.at);
  add(shape.tau);
  std::ranges::for_each(shape.low, add);
  std::ranges::for_each(shape.high, add);
  const bool by_own_length =  // of a wire, from its anchor
      effect.driver.kind == DriverKind::range && effect.parameter.owner == Owner::anchor;
  if (effect.driver.kind == DriverKind::moment || effect.driver.involves(DriverKind::force) ||
      is_arm_scale(effect.parameter) || by_own_length)
    key += "|" + to_string(effect.parameter);
  return key;
}

bool same(const Context& a, const Context& b) {
  return a.q == b.q && a.arrival == b.arrival && a.stroke == b.stroke && a.time_s == b.time_s &&
         a.session == b.session &&
         a.payload_kg == b.payload_kg && a.motor_torque_nm == b.motor_torque_nm &&
         a.force_n == b.force_n && a.temperature_c == b.temperature_c;
}

// Each reading's context; returns the first reading of each. Of postures those of the whole
// campaign that are equal share one, of visits those one after the other.
std::vector<int> contexts_of(const Campaign& campaign, int part, ScanValues& values) {
  std::vector<int> first;
  std::map<std::vector<double>, int> known;
  for (int row = 0; row < campaign.rows(); ++row) {
    const Context context = campaign.context(row);
    const int next = static_cast<int>(first.size());
    int number = next;
    if (part == CandidateScan::kPosture) {
      std::vector<double> key(context.q.begin(), context.q.end());
      key.push_back(context.payload_kg);
      number = known.try_emplace(std::move(key), next).first->second;
    } else if (row > 0 && same(context, campaign.context(row - 1))) {
      --number;
    }
    if (number == next) {
      first.push_back(row);
      values.readings_of_context.push_back(0);
    }
    values.context_of_reading.push_back(number);
    ++values.readings_of_context[number];
  }
  return first;
}

}  // namespace

CandidateScan::CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                             const Campaign& campaign)
    : candidates_(candidates),
      layout_(layout_of(robot.chain)),
      max_scale_(campaign.reads_one_number() ? kMaxVariation : 1e-3) {
  std::vector<Source> sources;
  std::array<int, kParts> value_count{};
  std::map<std::string, size_t> source_of_key;
  std::vector<std::vector<Term>> terms_by_value;  // `column` is the value
  for (const Candidate& candidate : candidates) {
    BoundEffect bound(candidate.effect, robot, campaign.temperature_names);
    const auto [place, is_new] =
        source_of_key.try_emplace(value_key(candidate.effect), sources.size());
    std::vector<Term>& terms = terms_by_value.emplace_back();
    coefficient_count_.push_back(bound.coefficient_count());
    const std::vector<BoundEffect::Term> own = bound.terms();
    if (is_new) {
      const int part = is_of_posture(candidate.effect) ? kPosture : kVisit;
      const int values = bound.value_count();
      sources.push_back({std::move(bound), part, value_count[part]});
      value_count[part] += values;
    }
    const Source& source = sources[place->second];
    part_.push_back(source.part);
    for (const BoundEffect::Term& term : own)
      terms.push_back({term.coefficient, term.parameter, source.first_value + term.value});
  }
  std::array<std::vector<int>, kParts> readings;  // one of each context
  for (int part = 0; part < kParts; ++part)
    readings[part] = contexts_of(campaign, part, parts_[part]);
  find_periodograms(terms_by_value, campaign, readings[kPosture]);
  share_columns(std::move(terms_by_value), parameter_count(robot.chain));
  for (int part = 0; part < kParts; ++part) {
    parts_[part].values.resize(std::ssize(readings[part]), value_count[part]);
    fill_values(sources, part, robot, campaign, readings[part]);
  }
}

// The cycles of a parameter with one joint angle, where nodes make products with them cheaper.
void CandidateScan::find_periodograms(const std::vector<std::vector<Term>>& terms_by_value,
                                      const Campaign& campaign, const std::vector<int>& readings) {
  constexpr size_t kMinContexts = 200;  // fewer cost no more than the nodes about a frequency
  if (readings.size() < kMinContexts) return;
  struct Cycles {
    int joint;
    std::map<int, double> frequency_of_sine;  // by its value
  };
  std::map<int, Cycles> of_parameter;
  for (size_t k = 0; k < candidates_.size(); ++k) {
    const Effect& effect = candidates_[k].effect;
    if (candidates_[k].frequency_resolution == 0 || !is_of_one_angle(effect) ||
        terms_by_value[k].size() != 2)
      continue;
    const Term& sine = terms_by_value[k].front();
    Cycles& cycles =
        of_parameter.try_emplace(sine.parameter, Cycles{effect.driver.joint, {}}).first->second;
    if (cycles.joint == effect.driver.joint)
      cycles.frequency_of_sine[sine.column] = effect.shape.harmonic;
  }
  for (const auto& [parameter, cycles] : of_parameter) {
    Eigen::VectorXd angles(std::ssize(readings));
    for (Eigen::Index k = 0; k < angles.size(); ++k)
      angles[k] = campaign.q[readings[k]][cycles.joint];
    const auto [least, most] = std::ranges::minmax_element(
        cycles.frequency_of_sine, {}, [](const auto& frequency) { return frequency.second; });
    Periodogram periodogram{CycleNodes(angles, least->second, most->second), {}};
    if (2 * periodogram.nodes.count() > std::ssize(cycles.frequency_of_sine)) continue;
    for (const auto& [sine, n] : cycles.frequency_of_sine)
      periodogram.near_of_sine[sine] = periodogram.nodes.near(n);
    periodograms_.emplace(parameter, std::move(periodogram));
  }
}

// Numbers the columns: one for each pair of parameter and value that occurs.
void CandidateScan::share_columns(std::vector<std::vector<Term>> terms_by_value,
                                  size_t parameters) {
  std::vector<std::array<std::map<int, int>, kParts>> column_of_value(parameters);
  for (size_t k = 0; k < terms_by_value.size(); ++k)
    for (const Term& term : terms_by_value[k])
      column_of_value[term.parameter][part_[k]].try_emplace(term.column, 0);
  const auto next = [&] { return static_cast<int>(value_of_column_.size()); };
  for (size_t parameter = 0; parameter < parameters; ++parameter) {
    const auto periodogram = periodograms_.find(static_cast<int>(parameter));
    first_column_.push_back(next());
    const auto add = [&](int part, bool of_periodogram) {
      for (auto& [value, column] : column_of_value[parameter][part]) {
        const bool is_of_it = part == kPosture && periodogram != periodograms_.end() &&
                              periodogram->second.has(value);
        if (is_of_it != of_periodogram) continue;
        column = next();
        value_of_column_.push_back(value);
      }
    };
    add(kPosture, false);
    if (periodogram != periodograms_.end()) periodogram->second.first = next();
    add(kPosture, true);
    first_visit_column_.push_back(next());
    add(kVisit, false);
  }
  first_column_.push_back(static_cast<int>(value_of_column_.size()));
  terms_ = std::move(terms_by_value);
  for (size_t k = 0; k < terms_.size(); ++k)
    for (Term& term : terms_[k])
      term.column = column_of_value[term.parameter][part_[k]][term.column];
}

void CandidateScan::fill_values(const std::vector<Source>& sources, int part, const Robot& robot,
                                const Campaign& campaign, const std::vector<int>& readings) {
  Eigen::MatrixXf& all = parts_[part].values;
  std::vector<const Source*> own;
  bool needs_frames = false, needs_jacobian = false;
  for (const Source& source : sources) {
    if (source.part != part) continue;
    own.push_back(&source);
    needs_frames |= source.bound.needs_frames();
    needs_jacobian |= source.bound.needs_jacobian();
  }
  const ChainEvaluator chain(robot.chain);
  for_ordered_blocks<int>(
      static_cast<int>(readings.size()), 64,
      [&](int begin, int end) {
        Eigen::VectorXd values(all.cols());
        ArmFrames frames;
        PoseJacobian jacobian;
        for (int k = begin; k < end; ++k) {
          const Context context = campaign.context(readings[k]);
          if (needs_frames) frames = chain.link_frames(context.q);
          if (needs_jacobian) chain.pose(context.q, jacobian);
          for (const Source* source : own)
            source->bound.values(context, &frames, &jacobian, values.data() + source->first_value);
          all.row(k) = values.cast<float>();
        }
        return 0;
      },
      [](int) {});
}

Eigen::MatrixXd CandidateScan::columns_at_readings(const Linearization& fit, int candidate) const {
  const int size = fit.row_size();
  const Replicates& replicates = fit.replicates();
  const ScanValues& part = parts_[part_[candidate]];
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(replicates.readings() * size, coefficient_count_[candidate]);
  for (const Term& term : terms_[candidate]) {
    const auto values = part.values.col(value_of_column_[term.column]);
    const auto derivative = fit.jacobian().col(term.parameter);
    for (int row = 0; row < fit.rows(); ++row)
      for (int k = replicates.first[row]; k < replicates.first[row + 1]; ++k) {
        const int reading = replicates.reading[k];
        columns.col(term.coefficient).segment(reading * size, size) +=
            replicates.share[k] * static_cast<double>(values[part.context_of_reading[reading]]) *
            derivative.segment(row * size, size);
      }
  }
  return columns;
}

double CandidateScan::share_of_possible(int candidate, const Eigen::VectorXd& coefficients) const {
  const ScanValues& part = parts_[part_[candidate]];
  std::map<int, Eigen::VectorXd> offsets;
  for (const Term& term : terms_[candidate]) {
    auto& offset = offsets.try_emplace(term.parameter, Eigen::VectorXd::Zero(part.values.rows()))
                       .first->second;
    offset += coefficients[term.coefficient] *
              part.values.col(value_of_column_[term.column]).cast<double>();
  }
  Eigen::VectorXd share(part.values.rows());  // of the readings
  for (Eigen::Index k = 0; k < share.size(); ++k)
    share[k] = static_cast<double>(part.readings_of_context[k]) /
               static_cast<double>(part.context_of_reading.size());
  double largest = 0;
  for (const auto& [parameter, offset] : offsets) {
    // The model fits no constants of the instrument, so their mean counts as variation.
    const double constant = layout_.is_of_instrument(parameter) ? 0 : offset.dot(share);
    const bool is_scale = parameter == layout_.instrument_scale || parameter == layout_.arm_scale;
    const double most = is_scale ? max_scale_ : kMaxVariation;
    const double square = share.dot((offset.array() - constant).square().matrix());
    largest = std::max(largest, std::sqrt(square) / most);
  }
  return largest;
}

bool CandidateScan::is_allowed(int candidate, const Eigen::VectorXd& coefficients) const {
  if (coefficients.size() != 1) return true;
  if (candidates_[candidate].only_positive && coefficients[0] <= 0) return false;
  const double furthest = candidates_[candidate].furthest;
  if (furthest == 0) return true;
  // All shapes that have such a bound rise with their driver.
  const auto values =
      parts_[part_[candidate]].values.col(value_of_column_[terms_[candidate].front().column]);
  const double change =
      coefficients[0] * static_cast<double>(values.maxCoeff() - values.minCoeff());
  return change / furthest > 0 && change / furthest <= 1;
}

bool CandidateScan::is_possible(int candidate, const Eigen::VectorXd& coefficients) const {
  return is_allowed(candidate, coefficients) &&
         share_of_possible(candidate, coefficients) < 1;
}

}  // namespace armtrue
