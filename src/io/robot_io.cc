#include "armtrue/io/robot_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

#include "armtrue/effects/identify.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/yaml/camera_io.h"
#include "io/yaml/contact_io.h"
#include "io/yaml/convention_io.h"
#include "io/yaml/effect_io.h"
#include "io/yaml/link_io.h"
#include "io/yaml/parameter_io.h"
#include "io/yaml/uncertainty_io.h"
#include "io/yaml/yaml_map.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

constexpr double kMaxGravity = 20;   // m/s2
constexpr double kMinGravity = 9;    // m/s2, unless it is zero
constexpr double kHeaviest = 2e4;    // kg: of a link
constexpr double kNearestCentre = 2e-3;  // m: at least one link has its centre farther off
constexpr double kSmallest = 1e-12;  // m or rad: of a deviation
// Each target, anchor or session adds parameters. Time and memory of the fit grow with the square
// of their number.
constexpr size_t kMaxOfAKind = 1000;

int link_index(const YamlMap& map, const KinematicChain& chain, const std::string& name) {
  for (int j = 0; j < link_count(chain); ++j)
    if (chain.links[j].name == name) return j;
  map.fail("link", "the robot has no link '" + name + "'");
}

void check_count(const YamlMap& map, const std::string& key, size_t count) {
  if (count > kMaxOfAKind)
    map.fail(key,
             fmt::format("has {} entries; more than {} are none of one arm", count, kMaxOfAKind));
}

// Calls with(name, section) for each entry of a section.
template <class With>
void each_entry(YamlMap& document, const std::string& key, With with) {
  if (!document.has(key)) return;
  YamlMap section = document.map(key);
  check_count(document, key, section.keys().size());
  for (const std::string& name : section.keys()) with(name, section);
}

Eigen::Vector3d read_vector(YamlMap& map, const std::string& key) {
  return Eigen::Vector3d(map.numbers(key, 3).data());
}

Session read_session(YamlMap map, const KinematicChain& chain) {
  Session session;
  for (const auto& [key, which, unit] :
       {std::tuple("theta_deg", LinkParameter::theta, kDegree),
        std::tuple("r_mm", LinkParameter::r, kMillimetre)}) {
    if (!map.has(key)) continue;
    YamlMap zeros = map.map(key);
    for (const std::string& name : zeros.keys()) {
      const auto zero =
          find_parameter(chain, Parameter(Owner::link, name, static_cast<int>(which)));
      if (!zero || !is_zero_offset(chain, *zero))
        zeros.fail(name, "the robot has no driven link '" + name + "' with this zero offset");
      session.zero[link_of_parameter(*zero)] = zeros.number(name) * unit;
    }
  }
  if (map.has("std")) session.std = read_deviations(map.map("std"), chain);
  session.base = read_pose(map);
  return session;
}

void read_masses(YamlMap& document, Robot& robot) {
  std::vector<YamlMap> masses = document.maps("masses");
  check_count(document, "masses", masses.size());
  for (YamlMap& entry : masses) {
    Body& body = robot.bodies.emplace_back();
    body.link = link_index(entry, robot.chain, entry.text("link"));
    body.mass_kg = entry.number("mass_kg");
    if (body.mass_kg <= 0) entry.fail("mass_kg", "must be above zero");
    if (body.mass_kg > kHeaviest)
      entry.fail("mass_kg", "is more than any link of an arm has; give it in kg");
    body.centre = read_vector(entry, "com_mm") * kMillimetre;
    entry.finish();
  }
  double farthest = 0;
  for (const Body& body : robot.bodies) farthest = std::max(farthest, body.centre.norm());
  if (robot.bodies.size() > 1 && farthest > 0 && farthest < kNearestCentre)
    document.fail("masses", fmt::format("no com_mm is farther than {:.3g} mm from the frame of its "
                                        "link, as centres in m would be; give them in mm",
                                        farthest / kMillimetre));
}

YAML::Node session_node(const Session& session, const KinematicChain& chain) {
  YAML::Node node = pose_node(session.base);
  std::vector<FlowEntry> angles, lengths;
  for (const auto& [link, zero] : session.zero) {
    const bool slides = is_prismatic(chain.links[link]);
    (slides ? lengths : angles)
        .emplace_back(chain.links[link].name, number_text(zero, slides ? kMillimetre : kDegree));
  }
  if (!angles.empty()) node["theta_deg"] = flow_map(angles);
  if (!lengths.empty()) node["r_mm"] = flow_map(lengths);
  if (!session.std.empty()) node["std"] = flow(std_node(session.std, chain));
  return node;
}

// Marks of eight hexadecimal digits, after an x that keeps a text of them from being a number.
TrainingRows read_training_rows(YamlMap map) {
  constexpr size_t kDigits = 8;
  TrainingRows training;
  const double rows = map.number("count");
  if (rows < 1 || rows > 1e12) map.fail("count", "must be from 1 to 1e12");
  training.rows = std::lround(rows);
  const std::string text = map.text("marks");
  const auto wrong = [&] {
    map.fail("marks", "must be x and then marks of eight hexadecimal digits, increasing");
  };
  if (text.empty() || text.front() != 'x' || (text.size() - 1) % kDigits != 0 ||
      (text.size() - 1) / kDigits > TrainingRows::kMostMarks)
    wrong();
  for (size_t first = 1; first < text.size(); first += kDigits) {
    std::uint32_t mark = 0;
    const char* const end = text.data() + first + kDigits;
    const auto read = std::from_chars(text.data() + first, end, mark, 16);
    if (read.ec != std::errc() || read.ptr != end ||
        (!training.marks.empty() && mark <= training.marks.back()))
      wrong();
    training.marks.push_back(mark);
  }
  map.finish();
  return training;
}

// Of the map `calibration` only the spread of the residuals and the marks of the rows are read
// back.
void read_residual_spread(YamlMap& calibration, RobotFile& result) {
  if (!calibration.has("residual_spread")) return;
  YamlMap spread = calibration.map("residual_spread");
  const ReadingSigma sigma{spread.number("position_mm") * kMillimetre,
                           spread.number("orientation_mrad", 0) * kMilliradian};
  if (sigma.position < 0) spread.fail("position_mm", "must not be negative");
  if (sigma.orientation < 0) spread.fail("orientation_mrad", "must not be negative");
  if (spread.has("pixel_px")) {
    result.pixel_spread = spread.number("pixel_px");
    if (*result.pixel_spread < 0) spread.fail("pixel_px", "must not be negative");
  }
  spread.finish();
  result.residual_spread = sigma;
}

void read_targets_and_anchors(YamlMap& document, KinematicChain& chain) {
  each_entry(document, "targets", [&](const std::string& name, YamlMap& targets) {
    chain.targets.push_back({name, read_vector(targets, name) * kMillimetre});
  });
  each_entry(document, "anchors", [&](const std::string& name, YamlMap& anchors) {
    YamlMap entry = anchors.map(name);
    const Eigen::Vector3d position = read_position(entry);
    chain.anchors.push_back({name, position, entry.number("zero_mm", 0) * kMillimetre});
    entry.finish();
  });
}

void read_contacts(YamlMap& document, KinematicChain& chain) {
  each_entry(document, "contacts", [&](const std::string& name, YamlMap& contacts) {
    if (name.empty() || name.find('/') != std::string::npos)
      contacts.fail(name,
                    "a contact needs a name without '/', which stands before a point of an "
                    "artefact");
    chain.contacts.push_back(read_contact(name, contacts.map(name)));
  });
}

// The section of the robot file that a contact stands in.
std::string section_of(ContactKind kind) {
  switch (kind) {
    case ContactKind::beam:
      return "beams";
    case ContactKind::camera:
      return "cameras";
    case ContactKind::board:
      return "boards";
    default:
      return "contacts";
  }
}

// The section that the owner of a parameter stands in.
std::string section_of(Owner owner) {
  switch (owner) {
    case Owner::target:
      return "targets";
    case Owner::anchor:
      return "anchors";
    case Owner::beam:
      return section_of(ContactKind::beam);
    case Owner::camera:
      return section_of(ContactKind::camera);
    case Owner::board:
      return section_of(ContactKind::board);
    case Owner::contact:
      return "contacts";
    default:
      return "links";
  }
}

// `beams`, `cameras` and `boards` are contacts of their kinds.
void read_beams_and_cameras(YamlMap& document, KinematicChain& chain) {
  for (const auto& [kind, read] :
       {std::pair(ContactKind::beam, &read_beam), std::pair(ContactKind::camera, &read_camera),
        std::pair(ContactKind::board, &read_board)}) {
    const bool is_beam = kind == ContactKind::beam;
    const auto of_kind = read;
    each_entry(document, section_of(kind), [&](const std::string& name, YamlMap& entries) {
      if (name.empty() || name.find_first_of(is_beam ? "/:" : "/") != name.npos)
        entries.fail(name,
                     "a beam, a camera and a board need a name without '/', a beam also "
                     "without ':'");
      if (std::ranges::count(chain.contacts, name, &Contact::name) > 0)
        entries.fail(name, "is the name of a contact, a beam, a camera or a board already");
      chain.contacts.push_back(of_kind(name, entries.map(name)));
    });
  }
}

void read_gravity(YamlMap& document, Robot& robot) {
  if (!document.has("gravity_m_s2")) return;
  robot.gravity = read_vector(document, "gravity_m_s2");
  const double length = robot.gravity.norm();
  if (length > kMaxGravity || (length > 0 && length < kMinGravity))
    document.fail("gravity_m_s2", fmt::format("is {:.4g} m/s2 long, but that of the earth is "
                                              "9.81; give it in m/s2",
                                              length));
}

void read_instrument(YamlMap& document, Robot& robot) {
  if (document.has("instrument_mm"))
    robot.instrument = read_vector(document, "instrument_mm") * kMillimetre;
}

// Which parameters are identified; the chain is known.
void read_identify(YamlMap& document, Robot& robot) {
  if (document.has("identify")) robot.identify = document.texts("identify");
  check_count(document, "identify", robot.identify.size());
  for (const std::string& name : robot.identify)
    if (find_parameter(robot.chain, name))
      constant_parameter(document, "identify", name, robot.chain);
  if (const std::string why = why_not_identified(robot.chain, robot.identify); !why.empty())
    document.fail("identify", why);
  if (document.has("identify_per_session"))
    robot.identify_per_session = document.texts("identify_per_session");
  check_count(document, "identify_per_session", robot.identify_per_session.size());
  for (const std::string& name : robot.identify_per_session)
    if (!is_zero_offset(robot.chain, name))
      document.fail("identify_per_session", "'" + name + "' is no zero offset such as A2.theta");
}

void read_noise(YamlMap noise, InstrumentNoise& result) {
  result.position = noise.number("position_mm", 0) * kMillimetre;
  result.orientation = noise.number("orientation_mrad", 0) * kMilliradian;
  result.pixel = noise.number("pixel_px", 0);
  const auto check = [&](const char* key, double value) {
    if (value < 0) noise.fail(key, "must not be negative");
    if (value > 0 && value < kSmallest) noise.fail(key, "is less than any instrument has");
  };
  check("position_mm", result.position);
  check("orientation_mrad", result.orientation);
  check("pixel_px", result.pixel);
  noise.finish();
}

// Adds the keys that a map lacks, as "links[2] r_mm".
void find_missing(YamlMap& map, const std::string& where, std::initializer_list<const char*> keys,
                  std::vector<std::string>& missing) {
  for (const char* key : keys)
    if (!map.has(key)) missing.push_back(where + key);
}

// Throws one error for all keys that are missing. A single one is left to its reader, which names
// the line.
void check_complete(YamlMap& document, const std::string& file) {
  std::vector<std::string> missing;
  find_missing(document, "", {"name", "base", "links", "tool"}, missing);
  for (const char* pose : {"base", "tool"})
    if (document.has(pose)) {
      YamlMap map = document.map(pose);
      find_missing(map, std::string(pose) + " ",
                   {"x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"}, missing);
    }
  std::vector<YamlMap> links = document.maps("links");
  for (size_t j = 0; j < links.size(); ++j)
    find_missing(links[j], fmt::format("links[{}] ", j + 1),
                 {"name", "joint", "alpha_deg", "d_mm", "theta_deg", "r_mm"}, missing);
  if (missing.size() > 1)
    throw InputError(fmt::format("{}: lacks {} keys: {}; armtrue-formats(5) says what they mean",
                                 file, missing.size(), fmt::join(missing, ", ")));
}

// Files that calibrate or close-loop read; the first is the nominal robot.
void take_inputs(RobotFile& result) {
  for (const auto& input : result.provenance.inputs) {
    result.made_of.push_back(input.second);
    if (!result.nominal) result.nominal = input;
  }
}

// [x, y, z] in mm.
YAML::Node point_node(const Eigen::Vector3d& point) {
  return flow_list(point, [](double length) { return number_text(length, kMillimetre); });
}

}  // namespace

Provenance read_provenance(YamlMap& document) {
  Provenance provenance;
  try {
    YamlMap map = document.map("provenance");
    provenance.command = map.text("command");
    provenance.version = map.text("version");
    for (YamlMap& input : map.maps("inputs"))
      provenance.inputs.emplace_back(input.text("file"), input.text("sha256"));
  } catch (const InputError&) {
    return provenance;
  }
  return provenance;
}

RobotFile parse_robot_file(const std::string& text, const std::string& file) {
  YamlMap document = read_document(text, file, {"armtrue-robot/1"});
  check_complete(document, file);
  RobotFile result;
  Robot& robot = result.robot;
  robot.name = document.text("name");
  robot.chain.base = read_pose(document.map("base"));
  read_links(document, robot.chain);
  robot.chain.tool = read_pose(document.map("tool"));
  each_entry(document, "sessions", [&](const std::string& name, YamlMap& sessions) {
    robot.sessions[name] = read_session(sessions.map(name), robot.chain);
  });
  read_targets_and_anchors(document, robot.chain);
  read_contacts(document, robot.chain);
  read_beams_and_cameras(document, robot.chain);
  if (const auto twice = ambiguous_parameter(robot.chain))
    document.fail(
        section_of(twice->owner),
        "'" + to_string(*twice) +
            "' names two parameters; give the link, target, anchor or contact a name that "
            "does not end like the name of a parameter");
  read_masses(document, robot);
  use_convention(document, robot);
  use_positioner(document, robot);
  read_gravity(document, robot);
  robot.floor = document.number("floor_mm", 0) * kMillimetre;
  read_instrument(document, robot);
  read_identify(document, robot);
  if (document.has("noise")) read_noise(document.map("noise"), robot.noise);
  if (document.has("priors")) robot.priors = read_deviations(document.map("priors"), robot.chain);
  for (const auto& [name, deviation] : robot.priors)
    if (deviation < kSmallest)
      document.fail("priors", "'" + name +
                                  "' is less than anything is known to; leave the "
                                  "parameter out of 'identify' to keep it as it is");
  if (document.has("std")) robot.std = read_deviations(document.map("std"), robot.chain);
  for (const YamlMap& entry : document.maps("effects"))
    robot.effects.push_back(read_effect(entry, robot.chain));
  if (document.has("uncertainty"))
    robot.uncertainty =
        read_uncertainty(document.map("uncertainty"), robot.chain, robot.effects, robot.std);
  if (document.has("calibration")) {
    YamlMap calibration = document.map("calibration");
    read_residual_spread(calibration, result);
    if (calibration.has("used_readings"))
      result.training = read_training_rows(calibration.map("used_readings"));
  }
  if (document.has("provenance")) result.provenance = read_provenance(document);
  if (!robot.std.empty()) take_inputs(result);
  document.ignore("provenance");
  document.finish();
  return result;
}

Robot parse_robot(const std::string& text, const std::string& file) {
  return parse_robot_file(text, file).robot;
}

RobotFile read_robot(const std::string& path) {
  Source source(path);
  RobotFile file = parse_robot_file(source.read_all(), source.name());
  file.name = source.name();
  file.sha256 = source.sha256();
  return file;
}

YAML::Node sessions_node(const Robot& robot) {
  YAML::Node node;
  for (const auto& [name, session] : robot.sessions)
    node[name] = session_node(session, robot.chain);
  return node;
}

YAML::Node robot_node(const Robot& robot, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-robot/1";
  if (!provenance.command.empty()) root["provenance"] = provenance_node(provenance);
  root["name"] = robot.name;
  root["base"] = pose_node(robot.chain.base);
  if (!robot.sessions.empty()) root["sessions"] = sessions_node(robot);
  for (int j = 0; j < link_count(robot.chain); ++j)
    root["links"].push_back(link_node(robot.chain, j));
  if (robot.ground_link) root["ground_link"] = robot.chain.links[*robot.ground_link].name;
  root["tool"] = pose_node(robot.chain.tool);
  for (const Target& target : robot.chain.targets)
    root["targets"][target.name] = point_node(target.position);
  for (const Anchor& anchor : robot.chain.anchors)
    root["anchors"][anchor.name] =
        flow_map({{"x_mm", number_text(anchor.position.x(), kMillimetre)},
                  {"y_mm", number_text(anchor.position.y(), kMillimetre)},
                  {"z_mm", number_text(anchor.position.z(), kMillimetre)},
                  {"zero_mm", number_text(anchor.zero, kMillimetre)}});
  for (const Contact& contact : robot.chain.contacts)
    root[section_of(contact.kind)][contact.name] =
        contact.kind == ContactKind::beam ? beam_node(contact)
        : is_of_images(contact.kind)      ? node_of_images(contact)
                                          : contact_node(contact);
  for (const Body& body : robot.bodies) {
    YAML::Node entry = flow_map(
        {{"link", robot.chain.links[body.link].name}, {"mass_kg", number_text(body.mass_kg)}});
    entry["com_mm"] = point_node(body.centre);
    root["masses"].push_back(entry);
  }
  if (robot.instrument) root["instrument_mm"] = point_node(*robot.instrument);
  root["gravity_m_s2"] = flow_list({robot.gravity.x(), robot.gravity.y(), robot.gravity.z()});
  if (robot.floor != 0) root["floor_mm"] = number_text(robot.floor, kMillimetre);
  if (robot.identify.size() == 1 &&
      (robot.identify.front() == "auto" || robot.identify.front() == "paper-25")) {
    root["identify"] = robot.identify.front();
  } else {
    root["identify"] = flow(YAML::Node(robot.identify));
  }
  if (!robot.identify_per_session.empty())
    root["identify_per_session"] = flow(YAML::Node(robot.identify_per_session));
  std::vector<FlowEntry> noise;
  if (robot.noise.position > 0)
    noise.emplace_back("position_mm", number_text(robot.noise.position, kMillimetre));
  if (robot.noise.orientation > 0)
    noise.emplace_back("orientation_mrad", number_text(robot.noise.orientation, kMilliradian));
  if (robot.noise.pixel > 0) noise.emplace_back("pixel_px", number_text(robot.noise.pixel));
  if (!noise.empty()) root["noise"] = flow_map(noise);
  if (!robot.priors.empty()) root["priors"] = priors_node(robot.priors, robot.chain);
  if (!robot.std.empty()) root["std"] = std_node(robot.std, robot.chain);
  if (robot.effects.empty()) root["effects"] = flow(YAML::Node(YAML::NodeType::Sequence));
  for (const Effect& effect : robot.effects)
    root["effects"].push_back(effect_node(effect, robot.chain));
  if (robot.uncertainty) root["uncertainty"] = uncertainty_node(*robot.uncertainty);
  return root;
}

Document write_robot(const Robot& robot, const Provenance& provenance) {
  return print_document(robot_node(robot, provenance));
}

}  // namespace armtrue
