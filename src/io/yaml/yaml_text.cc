#include "io/yaml/yaml_text.h"

#include <cmath>
#include <functional>

#include "armtrue/effects/gravity_basis.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/utf8.h"
#include "io/yaml/effect_io.h"
#include "io/yaml/json_text.h"
#include "io/yaml/plain_text.h"

namespace armtrue {
namespace {

// The tag of YAML for a plain scalar, whose characters decide its type; texts do not have it.
constexpr const char* kPlain = "?";

YAML::Node plain(const std::string& text) {
  YAML::Node node(text);
  node.SetTag(kPlain);
  return node;
}

const char* basis_name(SeriesBasis basis) {
  switch (basis) {
    case SeriesBasis::cosine:
      return "cosine";
    case SeriesBasis::spline:
      return "spline";
    case SeriesBasis::saturating:
      return "saturating";
    case SeriesBasis::bump:
      return "bump";
    case SeriesBasis::polynomial:
      return "polynomial";
    case SeriesBasis::fourier:
      break;
  }
  return "fourier";
}

const char* si_name(ParameterUnit unit) {
  switch (unit) {
    case ParameterUnit::metre:
      return "m";
    case ParameterUnit::radian:
      return "rad";
    case ParameterUnit::pixel:
      return "px";
    case ParameterUnit::one:
      break;
  }
  return "1";
}

// Unit of the parameter that a coefficient moves. In a pose the first half of the coefficients
// moves x, y and z, the others rotate; with the driver `moment` all rotate.
ParameterUnit unit_moved(const Effect& effect, size_t coefficient, const KinematicChain& chain) {
  if (group_size(effect.parameter) == 6 && effect.driver.kind != DriverKind::moment &&
      2 * coefficient < effect.coefficients.size())
    return ParameterUnit::metre;
  return unit_of_parameter(chain, effect.parameter);
}

std::string unit_of_coefficient(const Effect& effect, ParameterUnit moved,
                                const KinematicChain& chain) {
  std::string driver;
  const Driver& of = effect.driver;
  if (has_gravity_basis(effect))
    driver = "m/s2";
  else if (effect.shape.kind == ShapeKind::linear)
    driver = unit_of(chain, of.kind, of.joint, moved);
  const std::string factor = of.factor ? unit_of(chain, *of.factor, of.second_joint, moved) : "";
  if (!driver.empty() && !factor.empty()) driver += " ";
  driver += factor;
  if (driver.empty()) return si_name(moved);
  return si_name(moved) +
         (driver.find_first_of(" /") == std::string::npos ? "/" + driver : "/(" + driver + ")");
}

}  // namespace

std::string coefficient_unit(const Effect& effect, size_t coefficient,
                             const KinematicChain& chain) {
  return unit_of_coefficient(effect, unit_moved(effect, coefficient, chain), chain);
}

std::string si_unit_moved(const Effect& effect, size_t coefficient, const KinematicChain& chain) {
  return si_name(unit_moved(effect, coefficient, chain));
}

YAML::Node flow_map(const std::vector<FlowEntry>& entries) {
  YAML::Node node(YAML::NodeType::Map);
  for (const auto& [key, value] : entries) node[key] = value;
  return flow(node);
}

YAML::Node flow_list(const std::vector<double>& values) {
  return flow_list(values, [](double value) { return number_text(value); });
}

YAML::Node rounded_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? YAML::Node(rounded(*value))
                                        : YAML::Node(YAML::NodeType::Null);
}

YAML::Node boolean(bool value) { return plain(value ? "true" : "false"); }

YAML::Node text_or_null(const std::string& text) {
  return text.empty() ? YAML::Node(YAML::NodeType::Null) : YAML::Node(text);
}

YAML::Node list_node(const std::vector<YAML::Node>& items) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const YAML::Node& item : items) list.push_back(item);
  return items.empty() ? flow(list) : list;
}

YAML::Node texts_node(const std::vector<std::string>& texts) {
  std::vector<YAML::Node> items;
  for (const std::string& text : texts) items.emplace_back(text);
  return list_node(items);
}

YAML::Node effect_form_node(const Effect& effect, const KinematicChain& chain) {
  YAML::Node node;
  node["name"] = effect.name;
  node["parameter"] = to_string(effect.parameter);
  node["driver"] = to_string(effect.driver);
  node["shape"] = to_string(effect.shape);
  const Shape& shape = effect.shape;
  const auto [suffix, unit] = inner_unit(effect.driver, chain);
  if (const std::vector<std::string>& sessions = effect.driver.sessions; !sessions.empty()) {
    node["since"] = first_session_after(effect);
    node["sessions"] = flow_list(sessions, std::identity());
  } else if (has_at(shape.kind)) {
    node["at" + suffix] = number_text(shape.at, unit);
  } else if (const char* key = key_of_begin(effect); key && shape.at != 0) {
    node[key] = number_text(shape.at);
  }
  if (has_tau(shape.kind)) node["tau" + suffix] = number_text(shape.tau, unit);
  if (shape.kind == ShapeKind::series) {
    YAML::Node series;
    series["basis"] = basis_name(shape.basis);
    series["count"] = whole_number(shape.count);
    if (shape.basis != SeriesBasis::fourier) {
      series["range"] = flow_list({shape.low[0], shape.high[0]});
      if (effect.driver.is_pair() || is_polynomial(shape))
        series["second_range"] = flow_list({shape.low[1], shape.high[1]});
      if (is_polynomial(shape)) series["third_range"] = flow_list({shape.low[2], shape.high[2]});
    }
    node["series"] = flow(series);
  }
  return node;
}

YAML::Node effect_node(const Effect& effect, const KinematicChain& chain) {
  YAML::Node node = effect_form_node(effect, chain);
  if (effect.driver_range)
    node["measured"] = flow_list({(*effect.driver_range)[0], (*effect.driver_range)[1]});
  for (size_t k = 0; k < effect.coefficients.size(); ++k) {
    const Coefficient& c = effect.coefficients[k];
    YAML::Node coefficient;
    coefficient["name"] = c.name;
    coefficient["value"] = number_text(c.value);
    if (c.std > 0) {
      coefficient["std"] = rounded(c.std);
      coefficient["ci95"] =
          flow_list(c.ci95, [](double bound) { return number_in_form("{:.5g}", bound); });
    }
    coefficient["unit"] = coefficient_unit(effect, k, chain);
    node["coefficients"].push_back(flow(coefficient));
  }
  if (effect.family) {
    node["family"] = effect.family->name;
    node["typical"] = number_text(effect.family->typical);
  }
  if (effect.may_be_instrument) node["may_be_instrument"] = boolean(true);
  if (effect.mean != 0)
    node["mean"] = number_text(effect.mean / display_unit(chain, effect.parameter).si);
  return node;
}

YAML::Node provenance_node(const Provenance& provenance) {
  YAML::Node node;
  node["command"] = provenance.command;
  node["version"] = provenance.version;
  for (const auto& [file, sha256] : provenance.inputs)
    node["inputs"].push_back(flow_map({{"file", file}, {"sha256", sha256}}));
  for (const std::string& warning : provenance.warnings) node["warnings"].push_back(warning);
  return node;
}

namespace {

void print_text(const std::string& text, YAML::Emitter& emitter) {
  const std::string utf8 = as_utf8(text);
  if (!is_plain_text(utf8)) emitter << YAML::DoubleQuoted;
  if (!is_printable(utf8)) emitter << YAML::EscapeNonAscii;
  emitter << utf8;
}

// yaml-cpp itself would print a text such as 0032 or no as it prints a number.
void print(const YAML::Node& node, YAML::Emitter& emitter) {
  if (node.Style() == YAML::EmitterStyle::Flow) emitter << YAML::Flow;
  if (node.Style() == YAML::EmitterStyle::Block) emitter << YAML::Block;
  if (node.IsMap()) {
    emitter << YAML::BeginMap;
    for (const auto& entry : node) {
      emitter << YAML::Key;
      print_text(entry.first.Scalar(), emitter);
      emitter << YAML::Value;
      print(entry.second, emitter);
    }
    emitter << YAML::EndMap;
  } else if (node.IsSequence()) {
    emitter << YAML::BeginSeq;
    for (const auto& item : node) print(item, emitter);
    emitter << YAML::EndSeq;
  } else if (!node.IsScalar()) {
    emitter << YAML::Null;
  } else if (is_value(node)) {
    emitter << node.Scalar();
  } else {
    print_text(node.Scalar(), emitter);
  }
}

// `path` ends with a slash, or is empty.
void add_values(const YAML::Node& node, const std::string& path,
                std::map<std::string, std::string>& values) {
  if (node.IsMap())
    for (const auto& entry : node)
      add_values(entry.second, path + entry.first.Scalar() + "/", values);
  else if (node.IsSequence())
    for (size_t k = 0; k < node.size(); ++k)
      add_values(node[k], path + std::to_string(k) + "/", values);
  else if (node.IsScalar())
    values.emplace(path.substr(0, path.size() - 1), node.Scalar());
}

}  // namespace

bool is_value(const YAML::Node& scalar) { return scalar.Tag() == kPlain; }

Document print_document(const YAML::Node& root) {
  YAML::Emitter emitter;
  emitter.SetIndent(2);
  print(root, emitter);
  std::map<std::string, std::string> values;
  add_values(root, "", values);
  return {std::string(emitter.c_str()) + "\n", json_text(root) + "\n", std::move(values)};
}

}  // namespace armtrue

YAML::Node YAML::convert<armtrue::NumberText>::encode(const armtrue::NumberText& number) {
  // A number of YAML 1.1 with an exponent has a point: to its readers, 1e-05 is a text.
  std::string text = number;
  const size_t exponent = text.find('e');
  if (exponent != text.npos && text.find('.') == text.npos) text.insert(exponent, ".0");
  return armtrue::plain(text);
}
