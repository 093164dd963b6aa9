#include "armtrue/io/ranking_io.h"

#include "armtrue/io/source.h"
#include "io/yaml/effect_io.h"
#include "io/yaml/traced_effect_text.h"
#include "io/yaml/yaml_map.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

std::string write_ranking(const TraceResult& result, const Provenance& provenance) {
  YAML::Node root;
  root["format"] = "armtrue-ranking/1";
  root["provenance"] = provenance_node(provenance);
  root["effects"] = YAML::Node(YAML::NodeType::Sequence);
  for (const TracedEffect& traced : result.effects)
    root["effects"].push_back(traced_node(traced, nullptr, {}, result.fit.robot));
  root["remaining"] = flow_map({{"best_delta_ebic", rounded_or_null(result.best_score)},
                                {"p_value", rounded(result.remaining_p)}});
  for (const RankedCandidate& ranked : result.ranking)
    root["candidates"].push_back(
        flow_map({{"name", ranked.effect.name},
                  {"parameter", ranked.effect.parameter},
                  {"driver", to_string(ranked.effect.driver)},
                  {"shape", to_string(ranked.effect.shape)},
                  {"degrees_of_freedom", std::to_string(ranked.degrees_of_freedom)},
                  {"left", rounded(ranked.unexplained_share)},
                  {"delta_ebic", rounded_or_null(ranked.score)}}));
  root["not_separable"] = not_separable_node(result.not_separable);
  return print_document(root);
}

std::vector<TracedEffect> read_findings(const std::string& path, const KinematicChain& chain) {
  Source source(path);
  YamlMap document =
      read_document(source.read_all(), source.name(), {"armtrue-ranking/1", "armtrue-loop/1"});
  std::vector<TracedEffect> found;
  for (YamlMap& entry : document.maps("effects")) {
    TracedEffect& traced = found.emplace_back();
    traced.separated_by = entry.text("separated_by", "");
    for (YamlMap& other : entry.maps("indistinguishable")) {
      Rival& rival = traced.indistinguishable.emplace_back();
      rival.effect = read_effect_form(other, chain);
      rival.effect.name = other.text("name", "rival");
      rival.correlation = other.number("correlation", 0);
      rival.delta_ebic = other.number("delta_ebic", 0);
      rival.separated_by = other.text("separated_by", "");
      other.finish();
    }
    traced.effect = read_effect(entry, chain);
  }
  return found;
}

}  // namespace armtrue
