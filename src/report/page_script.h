#pragma once

namespace armtrue {

/// The script of a page: tables that sort, pictures that enlarge and tell their points, spaces that
/// turn. Without it a page shows the same numbers and pictures.
const char* page_script();

}  // namespace armtrue
