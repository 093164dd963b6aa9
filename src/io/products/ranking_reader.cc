#include "armtrue/io/products/ranking_io.h"
#include "armtrue/io/source.h"
#include "io/yaml/effect_io.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

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
