#pragma once

#include <string>

namespace armtrue {

/// Throws InputError if a text is no well-formed XML, or more of it than the URDF of an arm can
/// hold: more than 16 MB, 20,000 elements, 1000 attributes of one element, or 100 levels; also if
/// it declares entities. TinyXML is recursive: a deep text would overflow the stack. Whether the
/// names of closing tags match is left to TinyXML.
void check_xml_bounds(const std::string& text, const std::string& file);

}  // namespace armtrue
