#include "io/yaml/contact_io.h"

#include <algorithm>
#include <array>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/artefact_io.h"
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
    case ContactKind::beam:   // see read_beam()
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
  for (ContactKind kind : {ContactKind::point, ContactKind::plane, ContactKind::sphere})
    if (word == kind_word(kind)) return kind;
  if (is_artefact_word(word)) return ContactKind::artefact;
  map.fail("kind", "'" + word + "' is none of point, plane, sphere, artefact, cube and step-gauge");
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
  if (contact.kind == ContactKind::artefact) read_artefact(map, map.text("kind"), contact);
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
  if (contact.kind == ContactKind::artefact) add_artefact(contact, node);
  return node;
}

Contact read_beam(const std::string& name, YamlMap map) {
  Contact beam;
  beam.name = name;
  beam.kind = ContactKind::beam;
  beam.on_arm = true;
  beam.is_placed = std::ranges::any_of(std::array{"x_mm", "y_mm", "z_mm", "direction"},
                                       [&](const char* key) { return map.has(key); });
  if (beam.is_placed) {
    beam.place.translation = read_position(map);
    const std::vector<double> numbers = map.numbers("direction", 3);
    const Eigen::Vector3d direction(numbers[0], numbers[1], numbers[2]);
    if (direction.norm() == 0)
      map.fail("direction",
               "has no length; say where the beam points in the measured frame, such "
               "as [0, 0, 1]");
    beam.place.rotation = shortest_rotation(Eigen::Vector3d::UnitZ(), direction.normalized());
  }
  if (map.has("range_mm")) {
    const std::vector<double> range = map.numbers("range_mm", 2);
    if (range[0] >= range[1])
      map.fail("range_mm", "must be the least and the largest reading, [from, to]");
    beam.range = Eigen::Vector2d(range[0], range[1]) * kMillimetre;
  }
  map.finish();
  return beam;
}

YAML::Node beam_node(const Contact& beam) {
  std::vector<FlowEntry> entries;
  if (beam.is_placed) {
    for (int axis = 0; axis < 3; ++axis)
      entries.emplace_back(std::string(1, "xyz"[axis]) + "_mm",
                           number_text(beam.place.translation[axis], kMillimetre));
    const Eigen::Vector3d direction = beam.place.rotation.col(2);
    entries.emplace_back("direction", flow_list({direction.x(), direction.y(), direction.z()}));
  }
  if (!beam.range.isZero())
    entries.emplace_back("range_mm",
                         flow_list({beam.range[0] / kMillimetre, beam.range[1] / kMillimetre}));
  return flow_map(entries);
}

}  // namespace armtrue
