#pragma once

#include <string>
#include <vector>

#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// armtrue-ranking/1: the found effects, and the best candidates that were not added.
Document write_ranking(const TraceResult& result, const Provenance& provenance);

/// The effects of an armtrue-ranking/1 or armtrue-loop/1 document, each with the effects that
/// cannot be distinguished from it; ignores other keys of the documents. Throws InputError.
std::vector<TracedEffect> read_findings(const std::string& path, const KinematicChain& chain);

}  // namespace armtrue
