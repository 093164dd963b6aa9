#pragma once

namespace armtrue {

/// The CSS of every page, beside picture_style().
const char* page_style();

}  // namespace armtrue
