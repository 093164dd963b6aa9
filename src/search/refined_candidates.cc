#include <algorithm>
#include <cmath>

#include "search/candidates.h"
#include "search/driver_span.h"
#include "search/frequency_grid.h"

namespace armtrue {
namespace {

constexpr size_t kMaxSteps = 2000;  // finer than any campaign tells

}  // namespace

std::vector<Candidate> steps_anywhere(const Candidate& step, const Campaign& campaign) {
  const Span span = span_of(step.effect.driver, campaign);
  const std::vector<double> scanned = step_places(span, kStepGrid);
  std::vector<Candidate> steps;
  if (scanned.empty()) return steps;
  for (double at : step_places(span, static_cast<int>(std::min(span.values.size(), kMaxSteps)))) {
    if (at < scanned.front() || at > scanned.back()) continue;
    steps.push_back(step);
    steps.back().effect.shape.at = at;
    for (Effect& member : steps.back().effect.members) member.shape.at = at;
  }
  return steps;
}

std::vector<Candidate> cycles_near(const Candidate& found, int first, int last, int stride) {
  const double step = found.frequency_resolution / kFrequencySteps / kFinerSteps;
  std::vector<Candidate> cycles;
  for (int k = first; k <= last; k += stride) {
    const double n = readable(found.effect.shape.harmonic + k * step);
    cycles.push_back(found);
    cycles.back().effect.shape.harmonic = n;
    for (Effect& member : cycles.back().effect.members) member.shape.harmonic = n;
  }
  return cycles;
}

std::vector<Candidate> refined_candidates(const Candidate& candidate, const Campaign& campaign) {
  const Shape& shape = candidate.effect.shape;
  std::vector<Candidate> refined;
  const Span span = span_of(candidate.effect.driver, campaign);
  const auto add = [&](const Shape& inner) {
    refined.push_back(candidate);
    refined.back().effect.shape = inner;
    for (Effect& member : refined.back().effect.members) member.shape = inner;
  };
  if (has_at(shape.kind)) {
    refined = steps_anywhere(candidate, campaign);
    const double reach = 2.0 * span.length() / kStepGrid;
    std::erase_if(refined, [&](const Candidate& step) {
      return std::abs(step.effect.shape.at - shape.at) > reach;
    });
  } else if (shape.kind == ShapeKind::series && shape.basis == SeriesBasis::bump) {
    const double width = shape.high[0] - shape.low[0];
    const double middle = 0.5 * (shape.low[0] + shape.high[0]);
    for (double other : {5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 112.0}) {
      const double wide = other * candidate.degree, step = wide / 6;
      if (std::abs(std::log(wide / width)) > std::log(2.1)) continue;
      for (double k = std::ceil((middle - width) / step); k * step <= middle + width; ++k) {
        Shape inner = shape;
        inner.low[0] = k * step - 0.5 * wide;
        inner.high[0] = k * step + 0.5 * wide;
        if (shows_bump(inner, span)) add(inner);
      }
    }
  } else if (has_tau(shape.kind)) {
    // Steps of a grid that does not depend on the start of the search.
    const double whole =
        shape.kind == ShapeKind::pre_sliding ? 32 * candidate.degree : span.length();
    for (double tau = whole / 64; tau <= 2 * whole; tau *= 1.15) {
      if (std::abs(std::log(tau / shape.tau)) > std::log(2.0)) continue;
      Shape inner = shape;
      inner.tau = tau;
      add(inner);
    }
  }
  return refined;
}

}  // namespace armtrue
