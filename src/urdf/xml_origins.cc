#include "urdf/xml_origins.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <vector>

#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/text_parts.h"
#include "armtrue/text/xml_tags.h"
#include "urdf/link_frames.h"

namespace armtrue {
namespace {

std::string xyz_text(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation;
  return fmt::format("{} {} {}", number_text(t.x()), number_text(t.y()), number_text(t.z()));
}

std::string rpy_text(const Pose& pose) {
  const Eigen::Vector3d rpy = roll_pitch_yaw(pose.rotation);
  return fmt::format("{} {} {}", number_text(rpy[0]), number_text(rpy[1]), number_text(rpy[2]));
}

void replace_origin(std::string_view text, const XmlTag& origin, const Pose& pose,
                    std::vector<Replacement>& replacements) {
  const size_t behind_name = origin.begin + 1 + origin.name.size();
  for (const auto& [name, value] :
       {std::pair("xyz", xyz_text(pose)), std::pair("rpy", rpy_text(pose))})
    if (const auto span = attribute_span(text, origin, name))
      replacements.push_back({span->begin, span->end, value});
    else
      replacements.push_back({behind_name, behind_name, fmt::format(" {}=\"{}\"", name, value)});
}

// An origin for a joint without one. It stands as the first child did, in the same line or on one
// of its own.
std::string new_origin(std::string_view text, const XmlTag& joint, const Pose& pose) {
  const size_t child = text.find_first_not_of(kXmlBlanks, joint.end);
  return fmt::format("{}<origin xyz=\"{}\" rpy=\"{}\"/>", text.substr(joint.end, child - joint.end),
                     xyz_text(pose), rpy_text(pose));
}

// The child <origin> of a joint, up to its end; `at` is moved behind the joint.
std::optional<XmlTag> origin_of_joint(std::string_view text, const XmlTag& joint, size_t& at) {
  std::optional<XmlTag> origin;
  int depth = joint.is_empty ? 0 : 1;
  at = joint.end;
  while (depth > 0) {
    const std::optional<XmlTag> tag = next_tag(text, at);
    if (!tag) break;
    at = tag->end;
    if (depth == 1 && !tag->closes && tag->name == "origin" && !origin) origin = tag;
    depth += tag->closes ? -1 : tag->is_empty ? 0 : 1;
  }
  return origin;
}

std::string decoded(std::string_view text) {
  std::string result(text);
  for (const auto& [code, character] :
       {std::pair("&lt;", "<"), std::pair("&gt;", ">"), std::pair("&quot;", "\""),
        std::pair("&apos;", "'"), std::pair("&amp;", "&")})
    for (size_t at = 0; (at = result.find(code, at)) != result.npos; ++at)
      result.replace(at, std::string_view(code).size(), character);
  return result;
}

}  // namespace

std::string with_origins(const std::string& document, const std::map<std::string, Pose>& origins,
                         const std::string& file) {
  std::vector<Replacement> replacements;
  std::map<std::string, int> found;
  size_t at = 0;
  int depth = 0;  // joints of the robot stand at 1; a transmission names joints deeper down
  while (const std::optional<XmlTag> tag = next_tag(document, at)) {
    at = tag->end;
    if (tag->closes) {
      --depth;
      continue;
    }
    if (depth != 1 || tag->name != "joint") {
      depth += tag->is_empty ? 0 : 1;
      continue;
    }
    const std::optional<XmlSpan> name = attribute_span(document, *tag, "name");
    const std::optional<XmlTag> origin = origin_of_joint(document, *tag, at);
    if (!name) continue;
    const std::string own =
        decoded(std::string_view(document).substr(name->begin, name->end - name->begin));
    const auto wanted = origins.find(own);
    if (wanted == origins.end()) continue;
    ++found[own];
    if (origin)
      replace_origin(document, *origin, wanted->second, replacements);
    else
      replacements.push_back({tag->end, tag->end, new_origin(document, *tag, wanted->second)});
  }
  for (const auto& [name, pose] : origins)
    if (found[name] != 1)
      throw InputError(
          fmt::format("{}: holds the joint '{}' {} times where it should once; give "
                      "each joint a name of its own",
                      file, name, found[name]));
  return replaced(document, std::move(replacements));
}

}  // namespace armtrue
