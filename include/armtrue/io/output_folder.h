#pragma once

#include <string>
#include <vector>

#include "armtrue/io/output.h"

namespace armtrue {

/// Throws OutputError if replace_folder() would fail, as far as this can be checked beforehand:
/// `path` is no folder, or it holds other files than pictures that armtrue wrote, which would be
/// lost.
void check_replaceable(const std::string& path);

/// Replaces the folder `path` by one that holds these pictures (`path` of a product is its name in
/// the folder), as a whole or not at all; creates it if it is missing. Throws OutputError.
void replace_folder(const std::string& path, const std::vector<Product>& pictures);

}  // namespace armtrue
