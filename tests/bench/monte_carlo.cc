// How often the loop finds what was hidden, what it adds that is not there, and how often its
// intervals hold the truth: many campaigns of the oracle with fixed seeds. The loop reads the CSV
// and the nominal robot, nothing else.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <boost/math/distributions/binomial.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/tracing/loop.h"
#include "bench/two_threads.h"
#include "tracing/hidden_campaign.h"

namespace {

using namespace armtrue;

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
constexpr std::array kSizes{0.03, 0.06, 0.12};  // mm RMS after the best geometric refit
constexpr int kNullsPerRound = 10;
const std::string kKnownMasses = "compliance, masses known";

struct Case {
  std::string family;
  double size_mm = 0;
  unsigned seed = 0;
};

struct Outcome {
  bool named = false;  // the hidden effect itself or its class is among what was added
  bool nothing_to_explain = false;
  int extra = 0;                 // effects added that were not hidden
  double before = 0, after = 0;  // over the error of the true arm
  std::optional<bool>
      right_shape;  // the effect itself was added; set where the truth is one number
  bool covered = false;
};

// One round holds every family at every size once, so that a shortened run stays balanced.
std::vector<Case> cases(int count, bool only_nulls) {
  const std::vector<std::string> families{"compliance", kKnownMasses, "harmonic",
                                          "ratio",      "backlash",   "knock",
                                          "wobble",     "x-bump",     "x-product"};
  std::vector<Case> all;
  while (static_cast<int>(all.size()) < count) {
    if (!only_nulls)
      for (double size : kSizes)
        for (const std::string& family : families) all.push_back({family, size, 0});
    for (int k = 0; k < kNullsPerRound; ++k) all.push_back({"null", 0, 0});
  }
  all.resize(static_cast<size_t>(count));
  unsigned seed = 1000;
  for (Case& one : all) one.seed = seed++;
  return all;
}

// The coefficient that a perfect fit would give, where the effect is one number: the oracle's unit
// effect is 1e-6 rad per N m of compliance, 1 rad per rad of ratio, 1 rad of backlash from one side
// to the other.
struct OneNumber {
  double coefficient;
  ShapeKind shape;
};
std::optional<OneNumber> truth_in_one_number(const armtrue_oracle::Written& written) {
  const double a = written.amplitude;
  if (written.truth.family == "compliance") return OneNumber{1e-6 * a, ShapeKind::linear};
  if (written.truth.family == "ratio") return OneNumber{a, ShapeKind::linear};
  if (written.truth.family == "backlash") return OneNumber{0.5 * a, ShapeKind::sign};
  return {};
}

Outcome run(const Case& one, armtrue_oracle::CampaignPlan plan, const Robot& robot,
            const Catalogue& catalogue) {
  plan.seed = one.seed;
  plan.known_masses = one.family == kKnownMasses;
  const std::string family = plan.known_masses ? "compliance" : one.family;
  const HiddenCampaign campaign(kNominal, family, one.size_mm, plan);
  const LoopResult result = close_loop(robot, campaign.training, campaign.held_out, catalogue);
  const armtrue_oracle::Hidden& truth = campaign.written.truth;
  const double floor = campaign.written.floor_mean_mm * kMillimetre;

  Outcome outcome;
  outcome.nothing_to_explain = result.verdict == Verdict::nothing_to_explain;
  outcome.before = result.before / floor;
  outcome.after = result.after / floor;
  const auto one_number = truth_in_one_number(campaign.written);
  if (one_number) outcome.right_shape = false;
  for (const TracedEffect& traced : result.trace.effects) {
    if (!names(truth, traced)) {
      ++outcome.extra;
      continue;
    }
    outcome.named = true;
    const Effect& effect = traced.effect;
    if (!one_number || !names(truth, effect) || effect.shape.kind != one_number->shape) continue;
    const auto [low, high] = effect.coefficients.at(0).ci95;
    outcome.right_shape = true;
    outcome.covered = low <= one_number->coefficient && one_number->coefficient <= high;
  }
  return outcome;
}

// Whether intervals hold the truth where the effect is declared, so that nothing is searched for:
// as if readings were independent, Student's from the covariance by pose, and from the cluster
// bootstrap by pose.
struct Coverage {
  bool of_independent = false, of_student = false, of_bootstrap = false;
  double width_ratio = 0;  // bootstrap over independent
};

Coverage cover(const std::string& family, const armtrue_oracle::CampaignPlan& plan, Robot robot) {
  const HiddenCampaign campaign(kNominal, family, 0.06, plan);
  const armtrue_oracle::Hidden& truth = campaign.written.truth;
  const OneNumber number = *truth_in_one_number(campaign.written);
  Effect effect{family, truth.parameter, *parse_driver(truth.driver), Shape{number.shape}, {{}}};
  robot.effects = {effect};
  CalibrationResult fit = calibrate(robot, campaign.training);
  const auto holds = [&](const std::array<double, 2>& interval) {
    return interval[0] <= number.coefficient && number.coefficient <= interval[1];
  };
  const auto width = [](const std::array<double, 2>& interval) {
    return interval[1] - interval[0];
  };
  const Coefficient& c = fit.robot.effects[0].coefficients[0];
  const std::array<double, 2> student = c.ci95;
  const double std = fit.inverse_root.row(static_cast<Eigen::Index>(fit.set.kept.size())).norm();
  const std::array<double, 2> plain{c.value - 1.959964 * std, c.value + 1.959964 * std};
  set_intervals(bootstrap_coefficients(fit, campaign.training, 1000, 1), plan.poses, fit.robot);
  return {holds(plain), holds(student), holds(c.ci95), width(c.ci95) / width(plain)};
}

// Clopper and Pearson: never too short.
std::string share_with_interval(int k, int n) {
  using Binomial = boost::math::binomial_distribution<>;
  if (n == 0) return "-";
  const double low = k == 0 ? 0 : Binomial::find_lower_bound_on_p(n, k, 0.025);
  const double high = k == n ? 1 : Binomial::find_upper_bound_on_p(n, k, 0.025);
  return fmt::format("{}/{} = {:.1f} % [{:.1f}, {:.1f}]", k, n, 100.0 * k / n, 100 * low,
                     100 * high);
}

void print_tables(const std::vector<Case>& all, const std::vector<Outcome>& outcomes) {
  struct Cell {
    int cases = 0, named = 0, extra = 0, fitted = 0, covered = 0;
    double before = 0, after = 0;
    bool one_number = false;
  };
  std::map<std::pair<std::string, double>, Cell> cells;
  for (size_t i = 0; i < all.size(); ++i) {
    const Outcome& outcome = outcomes[i];
    std::vector<double> rows{-1};  // all sizes
    if (all[i].size_mm > 0) rows.push_back(all[i].size_mm);
    for (double row : rows) {
      Cell& cell = cells[{all[i].family, row}];
      ++cell.cases;
      cell.named += outcome.named;
      cell.extra += outcome.extra;
      cell.before += outcome.before;
      cell.after += outcome.after;
      cell.one_number |= outcome.right_shape.has_value();
      cell.fitted += outcome.right_shape.value_or(false);
      cell.covered += outcome.covered;
    }
  }
  fmt::print(
      "{:<26}{:>8}{:>9}{:>7}{:>10}{:>8}   coverage of ci95, right effect in the right shape\n",
      "family", "size mm", "named", "extra", "geometry", "after");
  for (const auto& [key, cell] : cells)
    fmt::print("{:<26}{:>8}{:>9}{:>7}{:>10.3f}{:>8.3f}   {}\n", key.first,
               key.second < 0 ? "all" : fmt::format("{:.2f}", key.second),
               key.first == "null" ? "-" : fmt::format("{}/{}", cell.named, cell.cases), cell.extra,
               cell.before / cell.cases, cell.after / cell.cases,
               cell.one_number ? share_with_interval(cell.covered, cell.fitted) : "");

  Cell hidden;
  int nulls = 0, added_on_null = 0, silent_on_null = 0, with_extra = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    const Outcome& outcome = outcomes[i];
    if (all[i].family == "null") {
      ++nulls;
      added_on_null += outcome.extra > 0;
      silent_on_null += outcome.nothing_to_explain;
    } else {
      ++hidden.cases;
      hidden.named += outcome.named;
      with_extra += outcome.extra > 0;
      // Torques of masses that are off by 10 to 30 % have no one true coefficient.
      if (all[i].family == "compliance") continue;
      hidden.fitted += outcome.right_shape.value_or(false);
      hidden.covered += outcome.covered;
    }
  }
  fmt::print(
      "\nErrors are held-out means over that of the true arm; intervals in brackets are 95 %.\n");
  fmt::print("named                        {}\n", share_with_interval(hidden.named, hidden.cases));
  fmt::print("with an effect not hidden    {}\n", share_with_interval(with_extra, hidden.cases));
  fmt::print("null: something added        {}\n", share_with_interval(added_on_null, nulls));
  fmt::print("null: nothing to explain     {}\n", share_with_interval(silent_on_null, nulls));
  fmt::print("coverage, masses known       {}\n",
             share_with_interval(hidden.covered, hidden.fitted));
}

void print_coverage(int count, const Robot& robot) {
  fmt::print(
      "Effect of 0.06 mm declared, masses known; noise of each reading alone, or of each pose "
      "too\n");
  fmt::print("{:<12}{:>6}{:>10}   {:<36}{:<36}{:<36}{}\n", "family", "poses", "rest mrad",
             "independent readings", "Student by pose", "cluster bootstrap by pose", "width ratio");
  std::map<std::pair<int, double>, std::array<int, 4>> all;
  for (int poses : {60, 30})
    for (double rest_mrad : {0.0, 0.05})
      for (const std::string family : {"compliance", "ratio", "backlash"}) {
        std::vector<Coverage> outcomes(static_cast<size_t>(count));
        armtrue_bench::on_two_threads(count, [&](int i) {
          armtrue_oracle::CampaignPlan plan;
          plan.seed = 5000u + static_cast<unsigned>(i);
          plan.known_masses = true;
          plan.poses = poses;
          plan.rest_mrad = rest_mrad;
          outcomes[static_cast<size_t>(i)] = cover(family, plan, robot);
        });
        int plain = 0, student = 0, by_pose = 0;
        double ratio = 0;
        for (const Coverage& one : outcomes) {
          plain += one.of_independent;
          student += one.of_student;
          by_pose += one.of_bootstrap;
          ratio += one.width_ratio / count;
        }
        auto& [sum_plain, sum_student, sum_by_pose, sum] = all[{-poses, rest_mrad}];
        sum_plain += plain;
        sum_student += student;
        sum_by_pose += by_pose;
        sum += count;
        fmt::print("{:<12}{:>6}{:>10.2f}   {:<36}{:<36}{:<36}{:.2f}\n", family, poses, rest_mrad,
                   share_with_interval(plain, count), share_with_interval(student, count),
                   share_with_interval(by_pose, count), ratio);
      }
  for (const auto& [key, sums] : all)
    fmt::print("{:<12}{:>6}{:>10.2f}   {:<36}{:<36}{:<36}\n", "together", -key.first, key.second,
               share_with_interval(sums[0], sums[3]), share_with_interval(sums[1], sums[3]),
               share_with_interval(sums[2], sums[3]));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Detection, false additions and coverage over many campaigns of the oracle");
  int campaigns = 999;
  app.add_option("--campaigns", campaigns, "How many; 37 are one round over families and sizes")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  armtrue_oracle::CampaignPlan plan;
  app.add_option("--poses", plan.poses, "Of training, and as many held out")->capture_default_str();
  app.add_option("--repeats", plan.repeats, "Readings of each pose")->capture_default_str();
  app.add_option("--rest-mrad", plan.rest_mrad,
                 "How far each joint rests from what is read, in each pose by another amount")
      ->capture_default_str();
  bool only_nulls = false;
  app.add_flag("--nothing-hidden", only_nulls, "Only campaigns without an effect");
  int coverage = 0;
  app.add_option("--coverage", coverage,
                 "Instead: coverage of intervals of a declared effect, so many campaigns a line")
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);

  const Robot robot = read_robot(kNominal).robot;
  if (coverage > 0) {
    print_coverage(coverage, robot);
    return 0;
  }
  const Catalogue catalogue = read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml");
  const std::vector<Case> all = cases(campaigns, only_nulls);
  std::vector<Outcome> outcomes(all.size());
  armtrue_bench::on_two_threads(campaigns, [&](int i) {
    const auto k = static_cast<size_t>(i);
    outcomes[k] = run(all[k], plan, robot, catalogue);
  });
  print_tables(all, outcomes);
}
