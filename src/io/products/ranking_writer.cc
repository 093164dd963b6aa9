#include "armtrue/io/products/ranking_io.h"
#include "io/products/traced_effect_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

Document write_ranking(const TraceResult& result, const Provenance& provenance) {
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
                  {"parameter", to_string(ranked.effect.parameter)},
                  {"driver", to_string(ranked.effect.driver)},
                  {"shape", to_string(ranked.effect.shape)},
                  {"degrees_of_freedom", whole_number(ranked.degrees_of_freedom)},
                  {"left", rounded(ranked.unexplained_share)},
                  {"delta_ebic", rounded_or_null(ranked.score)}}));
  root["not_separable"] = not_separable_node(result.not_separable);
  return print_document(root);
}

}  // namespace armtrue
