#pragma once

#include <string>
#include <vector>

#include "armtrue/io/output.h"

namespace armtrue {

/// Throws OutputError if replace_folder() would fail, as far as one can know beforehand: `path` is
/// no folder, or it holds anything but pictures that armtrue wrote, which would be lost.
void check_replaceable(const std::string& path);

/// Replaces the folder `path` by one that holds these pictures (`path` of a product is its name in
/// the folder), as a whole or not at all; it is made if it is missing. Throws OutputError.
void replace_folder(const std::string& path, const std::vector<Product>& pictures);

}  // namespace armtrue
