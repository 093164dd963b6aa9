#include "compensation/grid_joints.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/near_posture.h"
#include "compensation/programmed_joints.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kSeedsPerSide = 4;    // points from which the grid is filled where others do not lead
constexpr int kSeedStarts = 20;     // of each of them
constexpr int kPointsPerTask = 64;  // of a thread

// Fills the grid from a point that is reached to its neighbours, wave by wave.
class GridFlood {
 public:
  GridFlood(const ProgramArm& arm, const Context& context, const Grid& grid, const Pose& base,
            const JointVector& start)
      : arm_(arm),
        context_(context),
        grid_(grid),
        base_(base),
        start_(start),
        posture_(arm, start, NearPosture::Turns::within_travel),
        q_(grid.points()),
        wave_(q_.size(), kNever) {}

  std::vector<std::optional<JointVector>> run() {
    for (int seed : seeds()) {
      if (q_[index(seed)]) continue;
      const FoundJoints found = joints_on_branch(arm_, context_, wanted(seed), start_, kSeedStarts);
      if (found.reach != Reach::reached) continue;
      q_[index(seed)] = posture_.nearer(context_, wanted(seed), found.q);
      fill_from(seed);
    }
    return std::move(q_);
  }

 private:
  static constexpr int kNever = -1;
  static size_t index(int point) { return point; }

  Pose wanted(int point) const { return base_ * Pose{grid_.orientation, grid_.position(point)}; }

  // First the point nearest to the TCP at the start, then some points in all regions of the box.
  std::vector<int> seeds() const {
    Context here = context_;
    here.q = start_;
    const Eigen::Vector3d stands = inverse(base_) * arm_.pose(here).translation;
    std::array<int, 3> nearest{};
    std::array<std::vector<int>, 3> places;
    for (size_t axis = 0; axis < 3; ++axis) {
      double least = std::numeric_limits<double>::infinity();
      for (int k = 0; k < grid_.count[axis]; ++k) {
        const int side = static_cast<int>(axis);
        const double away = std::abs(grid_.coordinate(side, k) - stands[side]);
        if (away >= least) continue;
        least = away;
        nearest[axis] = k;
      }
      const int several = std::min(grid_.count[axis], kSeedsPerSide);
      for (int k = 0; k < several; ++k)
        places[axis].push_back(several == 1 ? 0 : k * (grid_.count[axis] - 1) / (several - 1));
    }
    std::vector<int> all{grid_.point(nearest)};
    for (int z : places[2])
      for (int y : places[1])
        for (int x : places[0]) all.push_back(grid_.point({x, y, z}));
    return all;
  }

  // The neighbours along the sides, in a fixed order.
  template <typename Take>
  void for_neighbours(int point, const Take& take) const {
    const std::array<int, 3> place = grid_.place(point);
    for (size_t axis = 0; axis < 3; ++axis)
      for (int step : {-1, 1}) {
        std::array<int, 3> other = place;
        other[axis] += step;
        if (other[axis] >= 0 && other[axis] < grid_.count[axis]) take(grid_.point(other));
      }
  }

  // From the neighbours that the wave before has reached.
  std::optional<JointVector> reach(int point) const {
    std::optional<JointVector> q;
    for_neighbours(point, [&](int from) {
      if (!q && wave_[index(from)] == now_ - 1)
        q = posture_.reach(context_, wanted(point), *q_[index(from)]);
    });
    return q;
  }

  void fill_from(int seed) {
    std::vector<int> reached{seed};
    for (wave_[index(seed)] = now_++; !reached.empty(); ++now_) {
      std::vector<int> candidates;
      for (int point : reached)
        for_neighbours(point, [&](int other) {
          if (!q_[index(other)]) candidates.push_back(other);
        });
      std::ranges::sort(candidates);
      candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
      reached = reached_of(candidates);
    }
  }

  std::vector<int> reached_of(const std::vector<int>& candidates) {
    using Found = std::vector<std::optional<JointVector>>;
    Found found;
    for_ordered_blocks<Found>(
        static_cast<int>(candidates.size()), kPointsPerTask,
        [&](int begin, int end) {
          Found block;
          for (int k = begin; k < end; ++k) block.push_back(reach(candidates[index(k)]));
          return block;
        },
        [&](const Found& block) { found.insert(found.end(), block.begin(), block.end()); });
    std::vector<int> reached;
    for (size_t k = 0; k < candidates.size(); ++k) {
      if (!found[k]) continue;
      q_[index(candidates[k])] = found[k];
      wave_[index(candidates[k])] = now_;
      reached.push_back(candidates[k]);
    }
    return reached;
  }

  const ProgramArm& arm_;
  const Context& context_;
  const Grid& grid_;
  const Pose& base_;
  const JointVector& start_;
  NearPosture posture_;
  std::vector<std::optional<JointVector>> q_;
  std::vector<int> wave_;  // in which a point was reached
  int now_ = 0;            // the wave that runs
};

}  // namespace

std::vector<std::optional<JointVector>> grid_joints(const ProgramArm& arm, const Context& context,
                                                    const Grid& grid, const Pose& base,
                                                    const JointVector& start) {
  return GridFlood(arm, context, grid, base, start).run();
}

}  // namespace armtrue
