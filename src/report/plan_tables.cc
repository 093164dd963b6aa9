#include "armtrue/report/plan_tables.h"

#include <fmt/format.h>

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/loop.h"

namespace armtrue {
namespace {

std::string in_quotes(const Effect& effect) { return "'" + describe(effect) + "'"; }

}  // namespace

std::string plan_table(const PlanQuality& planned, const PlanQuality& random, bool with_zone) {
  std::string table = fmt::format("{:<40}{:>13}{:>13}\n", "", "planned", "random");
  const auto add = [&](const std::string& what, double a, double b) {
    const auto cell = [](double value) {
      return std::isfinite(value) ? fmt::format("{:.5g}", value) : std::string("no bound");
    };
    table += fmt::format("{:<40}{:>13}{:>13}\n", what, cell(a), cell(b));
  };
  for (size_t k = 0; k < planned.observability.size(); ++k)
    add(fmt::format("O{}", k + 1), planned.observability[k], random.observability[k]);
  add("expected error over the candidates, mm", planned.cloud_deviation / kMillimetre,
      random.cloud_deviation / kMillimetre);
  if (with_zone)
    add("expected error in the zone, mm", planned.zone_deviation / kMillimetre,
        random.zone_deviation / kMillimetre);
  return table;
}

std::string power_table(const SeparationPlan& plan) {
  std::string table = fmt::format(
      "power at 5 %, with {:.3g} mm and {:.3g} mrad of noise\n{:>7}{:>9}{:>9}   truth, rival\n",
      plan.noise.position / kMillimetre, plan.noise.orientation / kMilliradian, "given", "planned",
      "random");
  for (const SeparatedPair& pair : plan.pairs)
    table +=
        fmt::format("{:>7.2f}{:>9.2f}{:>9.2f}   {}, {}\n", pair.power_given, pair.power_planned,
                    pair.power_random, in_quotes(pair.truth), in_quotes(pair.rival));
  return table;
}

}  // namespace armtrue
