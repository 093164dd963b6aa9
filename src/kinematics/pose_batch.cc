#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

#include "armtrue/kinematics/evaluator.h"
#include "kinematics/chain_recursion.h"

namespace armtrue {
namespace {

using Values = Lanes::Values;

// A pointer for each lane. Lanes without a pose repeat the last one, and write it again.
template <typename T>
using OfLanes = std::array<T*, Lanes::kCount>;

template <typename T>
OfLanes<T> of_lanes(std::span<T> values) {
  OfLanes<T> pointers{};
  for (size_t lane = 0; lane < pointers.size() && !values.empty(); ++lane)
    pointers[lane] = &values[std::min(lane, values.size() - 1)];
  return pointers;
}

template <typename Number>
inline Lanes gathered(const Number& number_of) {
  return Lanes(Values{number_of(0), number_of(1), number_of(2), number_of(3)});
}

inline LaneVector repeated(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

MovingFrame<Lanes> repeated(const Pose& pose) {
  return {repeated(pose.rotation.col(0)), repeated(pose.rotation.col(1)),
          repeated(pose.rotation.col(2)), repeated(pose.translation)};
}

MovingFrame<Lanes> gathered(const std::array<Pose, Lanes::kCount>& poses) {
  const auto entry = [&](int row, int column) {
    return gathered([&](size_t lane) { return poses[lane].rotation(row, column); });
  };
  const auto axis = [&](int k) { return LaneVector{entry(0, k), entry(1, k), entry(2, k)}; };
  const auto origin = [&](int row) {
    return gathered([&](size_t lane) { return poses[lane].translation[row]; });
  };
  return {axis(0), axis(1), axis(2), {origin(0), origin(1), origin(2)}};
}

// Base or tool of each pose; `first`: index of its parameters.
template <bool kWithOffsets>
MovingFrame<Lanes> end_frames(const Pose& pose, const OfLanes<const ParameterOffsets>& offsets,
                              int first) {
  if constexpr (!kWithOffsets) return repeated(pose);
  std::array<Pose, Lanes::kCount> moved;
  for (size_t lane = 0; lane < moved.size(); ++lane)
    moved[lane] = moved_by(pose, offsets[lane]->template segment<6>(first));
  return gathered(moved);
}

// Writes the three numbers of each pose.
inline void scatter(const LaneVector& vectors, const OfLanes<double>& out) {
  const Values& x = vectors.x.values();
  const Values& y = vectors.y.values();
  const Values& z = vectors.z.values();
  const Values even = __builtin_shufflevector(x, y, 0, 4, 2, 6);
  const Values odd = __builtin_shufflevector(x, y, 1, 5, 3, 7);
  const auto write = [&](size_t lane, const auto& first_two) {
    std::memcpy(out[lane], &first_two, 2 * sizeof(double));
    out[lane][2] = z[lane];
  };
  write(0, __builtin_shufflevector(even, even, 0, 1));
  write(1, __builtin_shufflevector(odd, odd, 0, 1));
  write(2, __builtin_shufflevector(even, even, 2, 3));
  write(3, __builtin_shufflevector(odd, odd, 2, 3));
}

inline void write_column(const std::array<Lanes, 6>& rows, double* out) {
  for (const Lanes& row : rows) {
    std::memcpy(out, &row.values(), sizeof(Values));
    out += Lanes::kCount;
  }
}

struct LaneColumn {
  double* entries;

  Lanes get(int row) const {
    Values values;
    std::memcpy(&values, entries + Lanes::kCount * row, sizeof(Values));
    return Lanes(values);
  }
  void set(int row, const Lanes& value) {
    std::memcpy(entries + Lanes::kCount * row, &value.values(), sizeof(Values));
  }
};

}  // namespace

static_assert(LaneJacobians::kCount == Lanes::kCount);

template <bool kWithOffsets, bool kWithJacobian, int kFixedCount>
void ChainEvaluator::evaluate_lanes(std::span<const JointVector> q,
                                    std::span<const ParameterOffsets> offsets,
                                    std::span<Pose> a_from_measured, LaneJacobians* jacobians,
                                    const ColumnSet& columns) const {
  const int count = kFixedCount > 0 ? kFixedCount : count_;
  const ParameterLayout layout(count, static_cast<int>(couplings_.size()));
  const OfLanes<const JointVector> encoders = of_lanes(q);
  const OfLanes<const ParameterOffsets> moved = of_lanes(offsets);
  const OfLanes<Pose> poses = of_lanes(a_from_measured);
  MovingFrame<Lanes> last = end_frames<kWithOffsets>(base_, moved, kFirstBaseParameter);
  const LaneVector base_origin = last.origin;
  std::array<LinkAxes<Lanes>, (kFixedCount > 0 ? kFixedCount : kMaxLinks)> axes;
  const auto encoder = [&](int joint) {
    return gathered([&](size_t lane) { return (*encoders[lane])[joint]; });
  };
  const auto offset = [&](int parameter) {
    return gathered([&](size_t lane) { return (*moved[lane])[parameter]; });
  };
  Motions<Lanes> motions;
  move_along<kWithOffsets, kWithJacobian, kFixedCount>(encoder, offset, motions, last, axes);
  const MovingFrame<Lanes> tool = end_frames<kWithOffsets>(tool_, moved, layout.tool);
  const auto turned = [&](const LaneVector& v) {
    return v.x * last.x + v.y * last.y + v.z * last.z;
  };
  const LaneVector end = turned(tool.origin) + last.origin;
  const auto write = [&](const LaneVector& vectors, const auto& place) {
    scatter(vectors, {place(*poses[0]), place(*poses[1]), place(*poses[2]), place(*poses[3])});
  };
  write(turned(tool.x), [](Pose& pose) { return pose.rotation.data(); });
  write(turned(tool.y), [](Pose& pose) { return pose.rotation.data() + 3; });
  write(turned(tool.z), [](Pose& pose) { return pose.rotation.data() + 6; });
  write(end, [](Pose& pose) { return pose.translation.data(); });
  if constexpr (kWithJacobian) {
    jacobians->set_columns(layout.geometric);
    for_each_column(count, base_origin, last, end, axes,
                    [&](int column, const LaneVector& of_point, const LaneVector& of_rotation) {
                      if (!columns[column]) return;
                      write_column({of_point.x, of_point.y, of_point.z, of_rotation.x,
                                    of_rotation.y, of_rotation.z},
                                   jacobians->entries(0, column));
                    });
    if constexpr (kFixedCount == 0)
      follow(motions, [&](int parameter) { return LaneColumn{jacobians->entries(0, parameter)}; });
  }
}

void ChainEvaluator::poses(std::span<const JointVector> q,
                           std::span<const ParameterOffsets> offsets,
                           std::span<Pose> a_from_measured) const {
  poses(q, offsets, a_from_measured, {}, {});
}

void ChainEvaluator::poses(std::span<const JointVector> q,
                           std::span<const ParameterOffsets> offsets,
                           std::span<Pose> a_from_measured, std::span<LaneJacobians> jacobians,
                           const ColumnSet& columns) const {
  constexpr size_t kCount = Lanes::kCount;
  if ((!offsets.empty() && offsets.size() != q.size()) || a_from_measured.size() != q.size() ||
      (!jacobians.empty() && jacobians.size() != (q.size() + kCount - 1) / kCount))
    throw std::invalid_argument("offsets, poses or Jacobians are not as many as joint vectors");
  const auto evaluate = [&]<int kFixedCount>() {
    if (offsets.empty())
      return jacobians.empty() ? &ChainEvaluator::evaluate_lanes<false, false, kFixedCount>
                               : &ChainEvaluator::evaluate_lanes<false, true, kFixedCount>;
    return jacobians.empty() ? &ChainEvaluator::evaluate_lanes<true, false, kFixedCount>
                             : &ChainEvaluator::evaluate_lanes<true, true, kFixedCount>;
  };
  const ColumnSet written = with_followers(columns);
  const bool is_usual = count_ == kUsualLinks && couplings_.empty();
  const auto of_lanes =
      is_usual ? evaluate.template operator()<kUsualLinks>() : evaluate.template operator()<0>();
  for (size_t first = 0; first < q.size(); first += kCount) {
    const size_t count = std::min(kCount, q.size() - first);
    const auto part = [&](auto all) { return all.empty() ? all : all.subspan(first, count); };
    (this->*of_lanes)(part(q), part(offsets), part(a_from_measured),
                      jacobians.empty() ? nullptr : &jacobians[first / kCount], written);
  }
}

}  // namespace armtrue
