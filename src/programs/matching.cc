#include "programs/matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <vector>

namespace armtrue {
namespace {

using Eigen::Index;

struct Foot {
  Index segment;
  double place;
  double distance;
};

// Finds the segments of a polygon near a point: a binary tree of bounding boxes.
class SegmentTree {
 public:
  explicit SegmentTree(const Eigen::Matrix3Xd& polygon) : polygon_(polygon) {
    while (leaves_ * kPerLeaf < segments()) leaves_ *= 2;
    boxes_.resize(2 * static_cast<size_t>(leaves_));
    for (Index i = 0; i < segments(); ++i) {
      box(leaves_ + i / kPerLeaf).extend(polygon.col(i));
      box(leaves_ + i / kPerLeaf).extend(polygon.col(i + 1));
    }
    for (Index node = leaves_ - 1; node > 0; --node)
      box(node) = box(2 * node).merged(box(2 * node + 1));
  }

  // Calls `visit` with the foot of the perpendicular on each segment within `distance`, in the
  // order of the segments. `visit` returns the distance for the rest of the search.
  template <class Visit>
  void within(const Eigen::Vector3d& point, double distance, Visit visit) const {
    descend(1, point, distance, visit);
  }

 private:
  static constexpr Index kPerLeaf = 4;

  Index segments() const { return polygon_.cols() - 1; }
  Eigen::AlignedBox3d& box(Index node) { return boxes_[node]; }

  Foot foot(Index segment, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d from = polygon_.col(segment);
    const Eigen::Vector3d chord = polygon_.col(segment + 1) - from;
    const double square = chord.squaredNorm();
    const double fraction =
        square > 0 ? std::clamp(chord.dot(point - from) / square, 0.0, 1.0) : 0.0;
    return {segment, static_cast<double>(segment) + fraction,
            (from + fraction * chord - point).norm()};
  }

  template <class Visit>
  void descend(Index node, const Eigen::Vector3d& point, double& distance, Visit& visit) const {
    const Eigen::AlignedBox3d& bounds = boxes_[node];
    if (bounds.isEmpty() || bounds.squaredExteriorDistance(point) > distance * distance) return;
    if (node < leaves_) {
      descend(2 * node, point, distance, visit);
      descend(2 * node + 1, point, distance, visit);
      return;
    }
    const Index first = (node - leaves_) * kPerLeaf;
    for (Index i = first; i < std::min(first + kPerLeaf, segments()); ++i) {
      const Foot found = foot(i, point);
      if (found.distance <= distance) distance = visit(found);
    }
  }

  const Eigen::Matrix3Xd& polygon_;
  Index leaves_ = 1;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

// Local minima of the distance between polygon and point, one for each pass: feet inside a segment,
// and vertices that are the foot on the segments of both sides.
void add_passes(const SegmentTree& tree, Index segments, const Eigen::Vector3d& point,
                double tolerance, std::vector<Foot>& passes) {
  double last = -1;
  tree.within(point, tolerance, [&](const Foot& foot) {
    const double fraction = foot.place - static_cast<double>(foot.segment);
    const bool at_start = fraction <= 0 && (foot.segment == 0 || foot.place == last);
    const bool at_end = fraction >= 1 && foot.segment + 1 == segments;
    if (at_start || at_end || (fraction > 0 && fraction < 1)) passes.push_back(foot);
    last = foot.place;
    return tolerance;
  });
}

struct Candidate {
  double place;
  double merit;
  Index point;
  Index before = -1;  // the candidate before this one in the best chain that ends here; -1: none
  double sum = 0;     // of the merits of that chain
};

// Finds the candidate with the greatest sum among those up to a rank: a Fenwick tree of maxima.
class BestUpTo {
 public:
  explicit BestUpTo(size_t ranks) : best_(ranks + 1, -1) {}

  Index find(size_t rank, const std::vector<Candidate>& candidates) const {
    Index best = -1;
    for (size_t k = rank + 1; k > 0; k &= k - 1)
      if (better(best_[k], best, candidates)) best = best_[k];
    return best;
  }
  void add(size_t rank, Index candidate, const std::vector<Candidate>& candidates) {
    for (size_t k = rank + 1; k < best_.size(); k += k & (~k + 1))
      if (better(candidate, best_[k], candidates)) best_[k] = candidate;
  }

 private:
  static bool better(Index a, Index b, const std::vector<Candidate>& candidates) {
    if (a < 0) return false;
    return b < 0 || candidates[a].sum > candidates[b].sum;
  }

  std::vector<Index> best_;
};

// Chains candidates, given point by point, with non-decreasing places and the greatest sum of
// merits. Returns the last candidate of the best chain; -1 if there is none.
Index chain(std::vector<Candidate>& candidates) {
  std::vector<double> places;
  places.reserve(candidates.size());
  for (const Candidate& candidate : candidates) places.push_back(candidate.place);
  std::sort(places.begin(), places.end());
  const auto rank = [&](const Candidate& candidate) {
    return std::lower_bound(places.begin(), places.end(), candidate.place) - places.begin();
  };
  BestUpTo best(places.size());
  for (size_t begin = 0, end = 0; begin < candidates.size(); begin = end) {
    for (end = begin; end < candidates.size() && candidates[end].point == candidates[begin].point;
         ++end) {
      Candidate& candidate = candidates[end];
      candidate.before = best.find(rank(candidate), candidates);
      candidate.sum = candidate.merit;
      if (candidate.before >= 0) candidate.sum += candidates[candidate.before].sum;
    }
    for (size_t i = begin; i < end; ++i) best.add(rank(candidates[i]), i, candidates);
  }
  return candidates.empty() ? -1 : best.find(places.size() - 1, candidates);
}

}  // namespace

Eigen::VectorXd places_in_order(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points,
                                double tolerance) {
  const SegmentTree tree(polygon);
  std::vector<Candidate> candidates;
  std::vector<Foot> passes;
  for (Index i = 0; i < points.cols(); ++i) {
    passes.clear();
    add_passes(tree, polygon.cols() - 1, points.col(i), tolerance, passes);
    for (const Foot& pass : passes) {
      const double share = pass.distance / tolerance;
      candidates.push_back({pass.place, 1 - share * share, i});
    }
  }
  Eigen::VectorXd places =
      Eigen::VectorXd::Constant(points.cols(), std::numeric_limits<double>::quiet_NaN());
  for (Index last = chain(candidates); last >= 0; last = candidates[last].before) {
    const Candidate& candidate = candidates[last];
    places[candidate.point] = candidate.place;
  }
  return places;
}

Eigen::Vector3d at_place(const Eigen::Matrix3Xd& samples, double place) {
  const Index before = std::min(static_cast<Index>(place), samples.cols() - 2);
  const double fraction = place - static_cast<double>(before);
  return samples.col(before) + fraction * (samples.col(before + 1) - samples.col(before));
}

NearestPoint nearest_to(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points) {
  const SegmentTree tree(polygon);
  NearestPoint nearest{-1, std::numeric_limits<double>::max()};
  for (Index i = 0; i < points.cols(); ++i)
    tree.within(points.col(i), nearest.distance, [&](const Foot& foot) {
      if (foot.distance < nearest.distance) nearest = {i, foot.distance};
      return nearest.distance;
    });
  return nearest;
}

}  // namespace armtrue
