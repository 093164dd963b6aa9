#include "io/yaml/contact_io.h"

#include <algorithm>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/link_io.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

const char* kind_word(ContactKind kind) {
  switch (kind) {
    case ContactKind::artefact:
      return "artefact";
    case ContactKind::plane:
      return "plane";
    case ContactKind::sphere:
      return "sphere";
    case ContactKind::point:
    case ContactKind::board:  // of images, see camera_io.h
    case ContactKind::camera:
      break;
  }
  return "point";
}

// A plane and an artefact are turned, a point and a sphere are not.
bool has_rotation(ContactKind kind) {
  return kind == ContactKind::plane || kind == ContactKind::artefact;
}

ContactKind read_kind(YamlMap& map) {
  const std::string word = map.text("kind");
  for (ContactKind kind :
       {ContactKind::point, ContactKind::artefact, ContactKind::plane, ContactKind::sphere})
    if (word == kind_word(kind)) return kind;
  map.fail("kind", "'" + word + "' is none of point, artefact, plane and sphere");
}

std::vector<std::string> place_keys(ContactKind kind) {
  std::vector<std::string> keys{"x_mm", "y_mm", "z_mm"};
  if (has_rotation(kind)) keys.insert(keys.end(), {"a_deg", "b_deg", "c_deg"});
  if (kind == ContactKind::sphere) keys.emplace_back("radius_mm");
  return keys;
}

void read_place(YamlMap& map, Contact& contact) {
  const std::vector<std::string> keys = place_keys(contact.kind);
  contact.is_placed =
      std::ranges::any_of(keys, [&](const std::string& key) { return map.has(key); });
  if (!contact.is_placed) return;
  contact.place.translation = read_position(map);
  if (has_rotation(contact.kind)) contact.place.rotation = read_rotation(map);
  if (contact.kind != ContactKind::sphere) return;
  contact.radius = map.number("radius_mm") * kMillimetre;
  if (contact.radius < 0) map.fail("radius_mm", "must not be negative");
}

}  // namespace

Contact read_contact(const std::string& name, YamlMap map) {
  Contact contact;
  contact.name = name;
  contact.kind = read_kind(map);
  read_place(map, contact);
  if (contact.kind == ContactKind::artefact) {
    YamlMap points = map.map("points");
    for (const std::string& point : points.keys()) {
      const std::vector<double> p = points.numbers(point, 3);
      contact.points.push_back({point, Eigen::Vector3d(p[0], p[1], p[2]) * kMillimetre});
    }
    if (contact.points.empty())
      map.fail("points", "is empty; an artefact has points that are known relative to each other");
  }
  map.finish();
  return contact;
}

YAML::Node contact_node(const Contact& contact) {
  std::vector<FlowEntry> entries{{"kind", kind_word(contact.kind)}};
  if (contact.is_placed) {
    const Eigen::Vector3d& at = contact.place.translation;
    std::vector<NumberText> values;
    for (double length : at) values.push_back(number_text(length, kMillimetre));
    if (has_rotation(contact.kind))
      for (const NumberText& angle : rotation_texts(contact.place.rotation))
        values.push_back(angle);
    if (contact.kind == ContactKind::sphere)
      values.push_back(number_text(contact.radius, kMillimetre));
    const std::vector<std::string> keys = place_keys(contact.kind);
    for (size_t k = 0; k < keys.size(); ++k) entries.emplace_back(keys[k], values[k]);
  }
  YAML::Node node = flow_map(entries);
  for (const ArtefactPoint& point : contact.points) {
    YAML::Node position;
    for (double length : point.position) position.push_back(number_text(length, kMillimetre));
    node["points"][point.name] = flow(position);
  }
  return node;
}

}  // namespace armtrue
