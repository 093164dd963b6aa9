#pragma once

#include <string>
#include <vector>

#include "armtrue/io/provenance.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// armtrue-ranking/1: the effects that the tracer found and the best candidates it did not add.
std::string write_ranking(const TraceResult& result, const Provenance& provenance);

/// The effects of an armtrue-ranking/1 or armtrue-loop/1 document, each with the effects that
/// cannot be told from it; other keys of the documents are not read. Throws InputError.
std::vector<TracedEffect> read_findings(const std::string& path, const KinematicChain& chain);

}  // namespace armtrue
