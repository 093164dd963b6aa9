#include "io/yaml/artefact_io.h"

#include <algorithm>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

constexpr const char* kCube = "cube";
constexpr const char* kStepGauge = "step-gauge";

double positive(const YamlMap& map, const std::string& key, double length) {
  if (length <= 0) map.fail(key, "must be above zero");
  return length * kMillimetre;
}

ArtefactPoint face(const std::string& name, const Eigen::Vector3d& position,
                   const Eigen::Vector3d& normal) {
  return {name, position, ContactKind::plane, normal};
}

// Faces +x, -x ... around the middle.
void read_cube(YamlMap& map, Contact& artefact) {
  const bool is_cube = map.has("edge_mm");
  const std::vector<double> edges =
      is_cube ? std::vector<double>(3, map.number("edge_mm")) : map.numbers("edges_mm", 3);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0}) {
      const double edge = positive(map, is_cube ? "edge_mm" : "edges_mm", edges[axis]);
      const Eigen::Vector3d normal = side * Eigen::Vector3d::Unit(axis);
      artefact.points.push_back(face(std::string(side > 0 ? "+" : "-") + "xyz"[axis],
                                     Eigen::Vector3d(normal * edge / 2), normal));
    }
}

// Faces 1, 2 ... that look along x.
void read_steps(YamlMap& map, Contact& artefact) {
  const std::vector<double> steps = map.numbers("steps_mm");
  if (steps.size() < 2 || std::ranges::adjacent_find(steps, std::greater_equal()) != steps.end())
    map.fail("steps_mm", "must be two or more places of faces along x, each above the one before");
  for (const double step : steps)
    artefact.points.push_back(face(std::to_string(artefact.points.size() + 1),
                                   Eigen::Vector3d(step * kMillimetre, 0, 0),
                                   Eigen::Vector3d::UnitX()));
}

// Calls take(name, numbers) for each entry of a section.
template <typename Take>
void read_section(YamlMap& map, const std::string& key, size_t count, Contact& artefact,
                  const Take& take) {
  if (!map.has(key)) return;
  YamlMap entries = map.map(key);
  for (const std::string& name : entries.keys()) {
    if (std::ranges::count(artefact.points, name, &ArtefactPoint::name) > 0)
      entries.fail(name, "is the name of a point, a face or a ball of this artefact already");
    artefact.points.push_back(take(entries, name, entries.numbers(name, count)));
  }
}

Eigen::Vector3d position_of(const std::vector<double>& numbers) {
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]) * kMillimetre;
}

void read_parts(YamlMap& map, Contact& artefact) {
  read_section(map, "points", 3, artefact,
               [](const YamlMap&, const std::string& name, const std::vector<double>& numbers) {
                 return ArtefactPoint{name, position_of(numbers)};
               });
  read_section(
      map, "faces", 6, artefact,
      [](const YamlMap& entries, const std::string& name, const std::vector<double>& numbers) {
        const Eigen::Vector3d normal(numbers[3], numbers[4], numbers[5]);
        if (normal.norm() == 0)
          entries.fail(name,
                       "needs [x, y, z] of a point in the face, and behind it the direction in "
                       "which the face looks, such as 0, 0, 1");
        return face(name, position_of(numbers), normal.normalized());
      });
  const double radius =
      map.has("ball_radius_mm") ? positive(map, "ball_radius_mm", map.number("ball_radius_mm")) : 0;
  read_section(
      map, "balls", 3, artefact,
      [radius](const YamlMap&, const std::string& name, const std::vector<double>& numbers) {
        ArtefactPoint ball{name, position_of(numbers), ContactKind::sphere};
        ball.radius = radius;
        return ball;
      });
  if (artefact.points.empty())
    map.fail(map.has("points") ? "points" : "kind",
             "is an artefact without points, faces and balls; it has some that are known relative "
             "to each other");
}

const ArtefactPoint* first_of(const Contact& artefact, ContactKind kind) {
  const auto found = std::ranges::find(artefact.points, kind, &ArtefactPoint::kind);
  return found == artefact.points.end() ? nullptr : &*found;
}

void read_radius(YamlMap& map, Contact& artefact) {
  const ArtefactPoint* const ball = first_of(artefact, ContactKind::sphere);
  const bool has_surfaces = ball || first_of(artefact, ContactKind::plane);
  artefact.radius_is_known = map.has("tip_radius_mm");
  const std::string key = artefact.radius_is_known ? "tip_radius_mm" : "radius_mm";
  if (!map.has(key)) return;
  if (!has_surfaces) map.fail(key, "is of what touches faces and balls, and there are only points");
  artefact.radius = map.number(key) * kMillimetre;
  if (!artefact.radius_is_known) return;
  if (map.has("radius_mm"))
    map.fail("radius_mm", "is identified, and tip_radius_mm says that it is known; keep one");
  if (artefact.radius < 0) map.fail(key, "must not be negative");
  if (ball && ball->radius == 0)
    map.fail(key,
             "also needs ball_radius_mm; without both, one radius of ball and tip together is "
             "identified");
}

YAML::Node lengths(std::vector<NumberText> texts) {
  YAML::Node list;
  for (const NumberText& text : texts) list.push_back(text);
  return flow(list);
}

}  // namespace

bool is_artefact_word(const std::string& word) {
  return word == "artefact" || word == kCube || word == kStepGauge;
}

void read_artefact(YamlMap& map, const std::string& word, Contact& artefact) {
  if (word == kCube)
    read_cube(map, artefact);
  else if (word == kStepGauge)
    read_steps(map, artefact);
  else
    read_parts(map, artefact);
  read_radius(map, artefact);
}

void add_artefact(const Contact& artefact, YAML::Node node) {
  for (const ArtefactPoint& part : artefact.points) {
    std::vector<NumberText> texts;
    for (double length : part.position) texts.push_back(number_text(length, kMillimetre));
    if (part.kind == ContactKind::plane)
      for (double component : part.normal) texts.push_back(number_text(component));
    const std::string section = part.kind == ContactKind::plane    ? "faces"
                                : part.kind == ContactKind::sphere ? "balls"
                                                                   : "points";
    node[section][part.name] = lengths(texts);
  }
  const ArtefactPoint* const ball = first_of(artefact, ContactKind::sphere);
  if (ball && ball->radius > 0) node["ball_radius_mm"] = number_text(ball->radius, kMillimetre);
  if (artefact.radius_is_known)
    node["tip_radius_mm"] = number_text(artefact.radius, kMillimetre);
  else if (artefact.is_placed && (ball || first_of(artefact, ContactKind::plane)))
    node["radius_mm"] = number_text(artefact.radius, kMillimetre);
}

}  // namespace armtrue
