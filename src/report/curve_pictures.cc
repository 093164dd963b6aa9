#include "report/curve_pictures.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// Text that a pointer shows: a point of a curve and its 95 % band. `unit_of_x`: such as "deg".
std::string point_text(double x, const std::string& unit_of_x, const CurvePoint& point,
                       const DisplayUnit& unit) {
  return fmt::format("at {:.4g} {}: {:.3g} +- {:.2g} {}", x, unit_of_x, point.value / unit.si,
                     point.half_width / unit.si, unit.name);
}

}  // namespace

Drawing effect_picture(const TracedEffect& traced, const std::vector<CurvePoint>& curve,
                       const Robot& robot, size_t number) {
  if (curve.empty()) return nullptr;
  const DisplayUnit unit = display_unit(robot.chain, traced.effect.parameter);
  const bool is_angle = traced.effect.driver.kind == DriverKind::joint_angle;
  const bool travels = is_travel(traced.effect.driver, robot.chain);
  const double si_of_driver = travels ? kMillimetre : is_angle ? kDegree : 1.0;
  const char* of_driver = travels                                         ? ", mm"
                          : is_angle                                      ? ", deg"
                          : traced.effect.driver.kind == DriverKind::time ? ", s"
                                                                          : ", deg C";
  Points low, middle, high;
  double least = 0, most = 0;
  std::vector<std::string> texts;
  for (const CurvePoint& point : curve) {
    const double x = point.driver / si_of_driver;
    texts.push_back(point_text(x, of_driver + 2, point, unit));
    low.emplace_back(x, (point.value - point.half_width) / unit.si);
    middle.emplace_back(x, point.value / unit.si);
    high.emplace_back(x, (point.value + point.half_width) / unit.si);
    least = std::min(least, low.back().y());
    most = std::max(most, high.back().y());
  }
  auto picture = std::make_shared<Picture>(
      fmt::format("effect-{}", number + 1),
      to_string(traced.effect.parameter) + " over " + to_string(traced.effect.driver),
      "What the parameter departs by; the band is the 95 % interval.",
      exact_axis(middle.front().x(), middle.back().x(),
                 to_string(traced.effect.driver) + of_driver));
  Panel& panel = picture->panel(
      round_axis(least, most, to_string(traced.effect.parameter) + ", " + unit.name, 4), 110);
  panel.band(low, high, Look::after, "95 %");
  panel.line(middle, Look::after, "found", texts);
  return picture;
}

Drawing joint_picture(const JointCurve& curve, const KinematicChain& chain) {
  const std::string parameter = parameter_name(chain, zero_offset(chain, curve.joint));
  const JointName name = joint_names(chain)[curve.joint];
  const DisplayUnit unit = display_unit(chain, parameter);
  Points low, middle, high, named;
  std::vector<std::string> texts;
  double least = 0, most = 0;
  for (size_t k = 0; k < curve.points.size(); ++k) {
    const CurvePoint& point = curve.points[k];
    const double x = point.driver / name.si();
    texts.push_back(point_text(x, name.unit(), point, unit));
    low.emplace_back(x, (point.value - point.half_width) / unit.si);
    middle.emplace_back(x, point.value / unit.si);
    high.emplace_back(x, (point.value + point.half_width) / unit.si);
    named.emplace_back(x, curve.named[k] / unit.si);
    least = std::min({least, low.back().y(), named.back().y()});
    most = std::max({most, high.back().y(), named.back().y()});
  }
  auto picture = std::make_shared<Picture>(
      "joint-" + name.axis, "Axis " + name.words + " over its own angle",
      "What the zero offset departs by in the arm that is applied; the band is the 95 % interval.",
      exact_axis(middle.front().x(), middle.back().x(), "axis " + name.words + ", " + name.unit()));
  Panel& panel = picture->panel(round_axis(least, most, parameter + ", " + unit.name, 4), 110);
  panel.band(low, high, Look::after, "95 %");
  panel.line(middle, Look::after, "applied", texts);
  panel.line(named, Look::mark, "with a name");
  return picture;
}

}  // namespace armtrue
