#include <string_view>

#include "report/svg.h"

namespace armtrue {
namespace {

// Okabe and Ito's colours (2008), which colour-blind readers distinguish, darker on white and
// lighter on black. The classes of a map have one hue, with rising contrast to the paper.
constexpr const char* kLight =
    ":root{color-scheme:light dark;--paper:#fff;--ink:#1c2127;--quiet:#57606a;--grid:#dfe3e8;"
    "--card:#f5f7f9;--nominal:#6e7781;--before:#c8500a;--after:#0067a8;--good:#067a52;"
    "--warn:#8a5a00;--bad:#b3261e;"
    "--h0:#dbe8f3;--h1:#bcd5ea;--h2:#93bddd;--h3:#619fcc;--h4:#3580b8;--h5:#155c95;--h6:#083268}";
constexpr const char* kDark =
    "@media screen and (prefers-color-scheme:dark){:root{--paper:#12161b;--ink:#e6eaee;"
    "--quiet:#a0abb6;--grid:#313a44;--card:#1b2128;--nominal:#98a3ae;--before:#ff9d5c;"
    "--after:#62b8f2;--good:#4cc795;--warn:#e3b341;--bad:#ff8a80;"
    "--h0:#1b3048;--h1:#214666;--h2:#2a5f8b;--h3:#377eb3;--h4:#569fd4;--h5:#8bc3ec;--h6:#d8ecfb}}";
constexpr const char* kClasses =
    ".picture{display:block;width:100%;height:auto;font:13px system-ui,-apple-system,'Segoe UI',"
    "Roboto,'DejaVu Sans',sans-serif}"
    ".picture text{fill:var(--ink)}.picture .title{font-weight:600;font-size:14px}"
    ".picture .quiet,.picture .tick{fill:var(--quiet)}"
    ".picture .halo{paint-order:stroke;stroke:var(--paper);stroke-width:3px}"
    ".grid{stroke:var(--grid);fill:none}.axis{stroke:var(--quiet);fill:none}"
    ".line,.shaft{fill:none;stroke-width:1.5;stroke-linejoin:round}"
    ".line.nominal{stroke-dasharray:2 3}.line.before{stroke-width:1.1}.line.after{stroke-width:2.2}"
    ".shaft{stroke-width:1.3}.shaft.after{stroke-width:2}"
    ".dot{fill:none;stroke:var(--quiet);stroke-width:3;stroke-linecap:round}"
    ".rule{fill:none;stroke-width:1.5;stroke-dasharray:7 4}.rule.nominal{stroke-dasharray:2 3}"
    ".rule.after{stroke-dasharray:none}"
    ".line.nominal,.shaft.nominal,.rule.nominal,.point.nominal{stroke:var(--nominal)}"
    ".line.before,.shaft.before,.rule.before,.point.before{stroke:var(--before)}"
    ".line.after,.shaft.after,.rule.after,.point.after{stroke:var(--after)}"
    ".line.mark,.shaft.mark,.rule.mark,.point.mark{stroke:var(--ink)}"
    ".point{fill:none;stroke-width:1.3}.point.after{stroke-width:4.5;stroke-linecap:round}"
    ".point.after.large{stroke-width:9}.point.mark{fill:var(--paper)}"
    ".hover{fill:none;stroke:transparent;stroke-width:9;stroke-linecap:round}"
    ".turned{fill:transparent}"
    ".head.nominal{fill:var(--nominal)}.head.before{fill:var(--before)}"
    ".head.after{fill:var(--after)}.head.mark{fill:var(--ink)}"
    ".bar.nominal{fill:none;stroke:var(--nominal)}"
    ".bar.before{fill:var(--before);fill-opacity:.25;stroke:var(--before)}"
    ".bar.after{fill:var(--after);stroke:var(--after)}"
    ".band{stroke:none}.band.before{fill:var(--before);opacity:.25}"
    ".band.after{fill:var(--after);opacity:.25}.band.mark{fill:var(--ink);opacity:.12}"
    ".h0{fill:var(--h0)}.h1{fill:var(--h1)}.h2{fill:var(--h2)}.h3{fill:var(--h3)}"
    ".h4{fill:var(--h4)}.h5{fill:var(--h5)}.h6{fill:var(--h6)}";

std::string light_value(std::string_view variable) {
  const std::string_view light = kLight;
  const size_t begin = light.find(std::string(variable) + ":") + variable.size() + 1;
  return std::string(light.substr(begin, light.find_first_of(";}", begin) - begin));
}

// The classes with the light colour before each variable: `fill:#fff;fill:var(--paper)`. Programs
// that draw SVG and know no variables, such as librsvg, leave the second out.
std::string classes_with_light_values() {
  constexpr std::string_view kUse = "var(";
  const std::string_view classes = kClasses;
  std::string text;
  size_t done = 0;
  for (size_t use = classes.find(kUse); use != classes.npos; use = classes.find(kUse, done)) {
    const size_t property = classes.find_last_of("{;", use) + 1;
    const size_t variable = use + kUse.size(), end = classes.find(')', variable);
    text += classes.substr(done, use - done);
    text += light_value(classes.substr(variable, end - variable)) + ";";
    text += classes.substr(property, end + 1 - property);
    done = end + 1;
  }
  return text + std::string(classes.substr(done));
}

}  // namespace

const std::string& picture_style() {
  static const std::string style = std::string(kLight) + kDark + classes_with_light_values();
  return style;
}

}  // namespace armtrue
