#pragma once

#include <string>

#include "armtrue/effects/catalogue.h"

namespace armtrue {

/// Reads an armtrue-catalogue/1 document. Throws InputError.
Catalogue read_catalogue(const std::string& path);
Catalogue parse_catalogue(const std::string& text, const std::string& file);

}  // namespace armtrue
