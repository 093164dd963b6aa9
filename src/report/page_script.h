#pragma once

namespace armtrue {

/// The script of a page: it sorts tables, enlarges pictures, shows the texts of their points, and
/// turns pictures in three dimensions. Without it a page shows the same numbers and pictures.
const char* page_script();

}  // namespace armtrue
