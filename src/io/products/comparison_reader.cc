#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/io/products/comparison_io.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/yaml/yaml_map.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

// The keys that state the inner values of a shape.
constexpr const char* kInnerKeys[] = {"at_s",    "at_deg", "at_mm", "tau_s",
                                      "tau_deg", "tau_mm", "since"};

std::optional<double> length(YamlMap& map, const std::string& key) {
  if (!map.has_value(key)) return std::nullopt;
  return map.number(key) * kMillimetre;
}

int count_of(YamlMap& map, const std::string& key) {
  constexpr double kMostCounted = 1e9;
  const double count = map.number(key);
  if (count < 0 || count > kMostCounted) map.fail(key, "must be from 0 to 1e9");
  return static_cast<int>(count);
}

std::string inner_text(YamlMap& map) {
  std::string text;
  for (const char* key : kInnerKeys)
    if (map.has(key)) text += fmt::format("{} {}, ", key, map.text(key));
  if (map.has("series")) {
    YamlMap series = map.map("series");
    text += series.text("basis") + " " + series.text("count");
    for (const char* key : {"range", "second_range", "third_range"})
      if (series.has(key)) text += fmt::format(" {}", fmt::join(series.texts(key), " "));
  }
  return text;
}

// An effect of a loop document, whose numbers state their units: no robot is needed.
NamedEffect named_effect(YamlMap map) {
  NamedEffect effect{map.text("name"),  map.text("parameter"), map.text("driver"),
                     map.text("shape"), inner_text(map),       {}};
  for (YamlMap& entry : map.maps("coefficients"))
    effect.coefficients.push_back({entry.text("name"), entry.text("unit", ""),
                                   entry.number("value"), entry.number("std", 0)});
  return effect;
}

NamedEffect named_effect(const Effect& effect, const KinematicChain& chain) {
  NamedEffect named{effect.name,
                    to_string(effect.parameter),
                    to_string(effect.driver),
                    to_string(effect.shape),
                    "",
                    {}};
  for (const auto& entry : effect_form_node(effect, chain)) {
    const std::string key = entry.first.as<std::string>();
    if (key != "name" && key != "parameter" && key != "driver" && key != "shape")
      named.inner += key + " " + YAML::Dump(entry.second) + ", ";
  }
  for (size_t k = 0; k < effect.coefficients.size(); ++k) {
    const Coefficient& c = effect.coefficients[k];
    named.coefficients.push_back({c.name, coefficient_unit(effect, k, chain), c.value, c.std});
  }
  return named;
}

RunErrors errors_of_loop(YamlMap& document) {
  RunErrors errors;
  errors.verdict = document.text("verdict");
  errors.sentence = document.text("sentence", "");
  YamlMap before_after = document.map("before_after");
  errors.before = length(before_after, "before_mm");
  errors.after = length(before_after, "after_mm");
  errors.floor = length(before_after, "floor_mm");
  YamlMap data = document.map("data");
  errors.poses = count_of(data, "poses");
  if (data.has("held_out_poses"))
    errors.poses = std::max(0, errors.poses - count_of(data, "held_out_poses"));
  return errors;
}

RunErrors errors_of_evaluation(YamlMap& document) {
  RunErrors errors;
  errors.after = document.map("position_mm").number("mean") * kMillimetre;
  if (document.has("against"))
    errors.before = document.map("against").map("position_mm").number("mean") * kMillimetre;
  errors.floor = length(document, "floor_mm");
  errors.poses = count_of(document, "poses");
  return errors;
}

}  // namespace

ComparedRun compared_run(const RunFile& run) {
  ComparedRun compared;
  compared.name = run.name;
  compared.effects = run.effects;
  compared.errors = run.errors;
  compared.command = run.provenance.command;
  compared.version = run.provenance.version;
  if (run.robot) {
    compared.robot = &run.robot->robot;
    compared.training = &run.robot->training;
    compared.spread = run.robot->residual_spread;
  }
  const auto is_document = [](const std::string& file) {
    return is_json_file(file) || file.ends_with(".yaml") || file.ends_with(".yml");
  };
  for (const auto& [file, sha256] : run.provenance.inputs) {
    if (compared.nominal.empty())
      compared.nominal = sha256;
    else if (!is_document(file))
      compared.readings.push_back(sha256);
  }
  return compared;
}

std::string kind_in_words(RunFile::Kind kind) {
  switch (kind) {
    case RunFile::Kind::loop:
      return "the document of a loop";
    case RunFile::Kind::evaluation:
      return "an evaluation";
    case RunFile::Kind::robot:
      break;
  }
  return "a robot file";
}

void require_one_kind(const RunFile& before, const RunFile& after) {
  if (before.kind != after.kind)
    throw InputError(fmt::format("{} is {}, but {} is {}; give two documents of one kind",
                                 before.name, kind_in_words(before.kind), after.name,
                                 kind_in_words(after.kind)));
}

void require_loop(const RunFile& run) {
  if (run.kind != RunFile::Kind::loop)
    throw InputError(fmt::format("{}: is {}; give the document that close-loop -o wrote", run.name,
                                 kind_in_words(run.kind)));
}

RunFile read_run(const std::string& path) {
  Source source(path);
  const std::string text = source.read_all();
  RunFile run;
  run.name = source.name();
  run.sha256 = source.sha256();
  YamlMap document = read_document(
      text, run.name,
      {"armtrue-robot/1", "armtrue-loop/1", "armtrue-summary/1", "armtrue-certificate/1"});
  const std::string format = document.text("format");
  if (format == "armtrue-certificate/1")
    document.fail("format", "is a certificate; certify --against compares two of them");
  if (format == "armtrue-robot/1") {
    run.robot = parse_robot_file(text, run.name);
    run.robot->name = run.name;
    run.robot->sha256 = run.sha256;
    run.provenance = run.robot->provenance;
    for (const Effect& effect : run.robot->robot.effects)
      if (!is_nameless(effect)) run.effects.push_back(named_effect(effect, run.robot->robot.chain));
    return run;
  }
  if (document.has("provenance")) run.provenance = read_provenance(document);
  run.kind = format == "armtrue-loop/1" ? RunFile::Kind::loop : RunFile::Kind::evaluation;
  if (run.kind == RunFile::Kind::evaluation) {
    run.errors = errors_of_evaluation(document);
    return run;
  }
  run.errors = errors_of_loop(document);
  for (const YamlMap& entry : document.maps("effects")) run.effects.push_back(named_effect(entry));
  return run;
}

}  // namespace armtrue
