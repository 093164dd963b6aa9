#include "armtrue/planning/separation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/tracing/loop.h"
#include "linear_algebra/decompositions.h"
#include "planning/choose_by_exchange.h"
#include "planning/contest.h"

namespace armtrue {
namespace {

constexpr double kLevel = 0.05;
constexpr double kHopeless = 0.5;  // power with all candidates, below which no choice of them helps
constexpr int kRandomDesigns = 20;  // their mean power is good to a few per cent

// Visits one after another, from a time on.
Campaign visits(const PoseCloud& cloud, const std::vector<PlannedPose>& poses, double first_s,
                double seconds_per_visit) {
  Campaign campaign = readings(cloud, poses);
  derive_arrival(campaign);
  for (int pose : campaign.pose) campaign.time_s.push_back(first_s + pose * seconds_per_visit);
  const auto keep_last = [&](const auto& given, auto& own) {
    if (!given.empty()) own.assign(campaign.q.size(), given.back());
  };
  keep_last(cloud.given.payload_kg, campaign.payload_kg);
  keep_last(cloud.given.force_n, campaign.force_n);
  keep_last(cloud.given.temperature_c, campaign.temperature_c);
  keep_last(cloud.given.motor_torque_nm, campaign.motor_torque_nm);
  campaign.temperature_names = cloud.given.temperature_names;
  return campaign;
}

// Start and pace of the visits in the last session.
struct Clock {
  double first_s = 0, seconds_per_visit = SimulationOptions{}.seconds_per_visit;
};

Clock after(const Campaign& given) {
  Clock clock;
  if (given.time_s.empty()) return clock;
  std::vector<double> times;
  const std::vector<int> last = rows_by_session(given).back();
  for (int row : last) times.push_back(given.time_s[row]);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.size() > 1)
    clock.seconds_per_visit =
        (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  clock.first_s = times.back() + clock.seconds_per_visit;
  return clock;
}

double power(double noncentrality, int degrees_of_freedom) {
  constexpr double kCertain = 1e4;
  if (noncentrality <= 0) return kLevel;
  return non_central_chi_squared_above(chi_squared_quantile_above(kLevel, degrees_of_freedom),
                                       degrees_of_freedom, std::min(noncentrality, kCertain));
}

struct Pair {
  size_t contest;
  int truth, rival;  // members
  bool by_poses = true;
};

// Criterion: smallest noncentrality lambda of the pairs that poses can separate.
class Discrimination {
 public:
  // `blocks`: of each contest, columns x (candidates * block), standardised and transposed; `grams`
  // of the given poses.
  Discrimination(const std::vector<Contest>& contests, const std::vector<Pair>& pairs,
                 std::vector<Eigen::MatrixXd> blocks, std::vector<Eigen::MatrixXd> grams)
      : contests_(contests),
        pairs_(pairs),
        blocks_(std::move(blocks)),
        grams_(std::move(grams)),
        block_(static_cast<int>(blocks_.front().cols() / kCloudSize)) {}

  void set_chosen(int candidate, bool chosen) {
    for (size_t k = 0; k < grams_.size(); ++k) {
      const auto rows = blocks_[k].middleCols(candidate * block_, block_);
      if (chosen)
        grams_[k] += rows * rows.transpose();
      else
        grams_[k] -= rows * rows.transpose();
    }
  }

  // With N and B the columns of a candidate's rows (transposed) for nuisances and members, the
  // candidate adds E A^-1 E^T to the information of the members after the nuisances: P = L^-1 N,
  // E = B - share^T P (see Fitted), A = I + P^T P.
  Eigen::VectorXd values_of_adding() const {
    Eigen::VectorXd smallest =
        Eigen::VectorXd::Constant(kCloudSize, std::numeric_limits<double>::infinity());
    Eigen::LLT<Eigen::MatrixXd> root(block_);
    for (size_t k = 0; k < contests_.size(); ++k) {
      const int nuisances = contests_[k].nuisances;
      const Fitted fitted(grams_[k], nuisances);
      const Eigen::MatrixXd p = fitted.nuisance.matrixL().solve(blocks_[k].topRows(nuisances));
      const Eigen::MatrixXd left =
          blocks_[k].bottomRows(blocks_[k].rows() - nuisances) - fitted.share.transpose() * p;
      for (int i = 0; i < kCloudSize; ++i) {
        const auto own = p.middleCols(i * block_, block_);
        Eigen::MatrixXd variance = own.transpose().lazyProduct(own);
        variance.diagonal().array() += 1;
        root.compute(variance);
        const Eigen::MatrixXd seen =
            root.matrixL().solve(left.middleCols(i * block_, block_).transpose());
        const Eigen::MatrixXd information = fitted.members + seen.transpose().lazyProduct(seen);
        for (const Pair& pair : pairs_)
          if (pair.contest == k && pair.by_poses)
            smallest[i] =
                std::min(smallest[i], Imitation(information, contests_[k].members[pair.truth],
                                                contests_[k].members[pair.rival])
                                          .left);
      }
    }
    return smallest;
  }

 private:
  const std::vector<Contest>& contests_;
  const std::vector<Pair>& pairs_;
  std::vector<Eigen::MatrixXd> blocks_, grams_;
  int block_;
};

class Separation {
 public:
  Separation(const Robot& robot, const std::vector<TracedEffect>& found, int count,
             const CloudOptions& options, const Campaign& given)
      : cloud_(pose_cloud(robot, options, given)), clock_(after(given)) {
    Robot with_others = cloud_.robot;
    for (const Effect& effect : robot.effects)
      if (std::none_of(found.begin(), found.end(),
                       [&](const TracedEffect& one) { return same_form(one.effect, effect); }))
        with_others.effects.push_back(effect);
    set_noise(with_others, found, given);
    for (size_t k = 0; k < found.size(); ++k)
      if (!found[k].indistinguishable.empty())
        contests_.push_back(contest_about(k, with_others, found));
    const double middle = clock_.first_s + 0.5 * count * clock_.seconds_per_visit;
    for (Contest& contest : contests_) prepare(contest, visits(cloud_, cloud_.poses, middle, 0));
    enter_pairs();
  }

  SeparationPlan plan(int count) {
    SeparationPlan plan;
    plan.noise = cloud_.noise;
    if (std::any_of(pairs_.begin(), pairs_.end(), [](const Pair& pair) { return pair.by_poses; })) {
      Discrimination design(contests_, pairs_, candidates_, given_);
      for (int candidate : choose_by_exchange(design, kCloudSize, count))
        plan.poses.push_back(cloud_.poses[candidate]);
    }
    const std::vector<double> alone = powers({}), planned = powers(plan.poses);
    std::vector<double> random(pairs_.size());
    for (int k = 0; k < kRandomDesigns; ++k) {
      const std::vector<double> one =
          powers(random_poses(cloud_, count, cloud_.options.seed + 1 + k));
      for (size_t i = 0; i < one.size(); ++i) random[i] += one[i] / kRandomDesigns;
    }
    for (size_t i = 0; i < pairs_.size(); ++i)
      plan.pairs.push_back(described(pairs_[i], alone[i], planned[i], random[i]));
    return plan;
  }

 private:
  // The noise is the standard deviation of the given readings about the model with all found
  // effects, at least that of the instrument. With too few readings it stays.
  void set_noise(Robot robot, const std::vector<TracedEffect>& found, const Campaign& given) {
    size_t unknowns = cloud_.unknowns.size();
    for (const TracedEffect& one : found) {
      robot.effects.push_back(one.effect);
      unknowns += one.effect.coefficients.size();
    }
    if (std::cmp_less(given.rows() * given.reading_size().all(), 2 * unknowns)) return;
    const ReadingSigma spread =
        calibrate(robot, given, {.statistics = FitStatistics::weights}).spread;
    set_noise_by_spread(cloud_, spread);
  }

  // Standardised columns of cloud and given poses, and the sizes of the members.
  void prepare(Contest& contest, const Campaign& cloud_visits) {
    enter_members(contest, cloud_.given.temperature_names);
    const Eigen::MatrixXd cloud =
        equal_blocks(cloud_visits, derivatives(contest, cloud_, cloud_visits));
    const Eigen::MatrixXd given = given_derivatives(cloud_, contest.robot);
    Eigen::MatrixXd rows(cloud.rows() + given.rows(), cloud.cols());
    rows << cloud, given;
    standardise(contest, rows, static_cast<double>(kCloudSize + cloud_.given.pose_ids.size()));
    candidates_.push_back((cloud * contest.standard).transpose());
    const Eigen::MatrixXd standard = given * contest.standard;
    given_.push_back(standard.transpose() * standard);
    everything_.push_back(given_.back() + candidates_.back() * candidates_.back().transpose());

    Contest::Member& found = contest.members.front();
    Eigen::VectorXd coefficients(found.raw_count);
    for (int c = 0; c < found.raw_count; ++c) coefficients[c] = found.effect.coefficients[c].value;
    found.size = found.standard.of_coefficients * coefficients;
    const Fitted fitted(given.rows() > 0 ? given_.back() : everything_.back(), contest.nuisances);
    for (Contest::Member& member : contest.members) {
      if (&member == &found) continue;
      member.size = Imitation(fitted.members, found, member).size;
      coefficients = member.standard.of_raw * member.size;
      for (double value : coefficients) member.effect.coefficients.push_back({"", value});
    }
  }

  void enter_pairs() {
    for (size_t k = 0; k < contests_.size(); ++k) {
      const Fitted all(everything_[k], contests_[k].nuisances);
      const auto members = std::ssize(contests_[k].members);
      for (int truth = 0; truth < members; ++truth)
        for (int rival = 0; rival < members; ++rival)
          if (truth != rival)
            pairs_.push_back({k, truth, rival, poses_tell(contests_[k], all, truth, rival)});
    }
  }

  static bool poses_tell(const Contest& contest, const Fitted& all, int truth, int rival) {
    const Contest::Member& a = contest.members[truth];
    return power(Imitation(all.members, a, contest.members[rival]).left, a.count) > kHopeless;
  }

  std::vector<double> powers(const std::vector<PlannedPose>& poses) const {
    std::vector<double> powers(pairs_.size());
    for (size_t k = 0; k < contests_.size(); ++k) {
      Eigen::MatrixXd gram = given_[k];
      if (!poses.empty()) {
        const Campaign campaign = visits(cloud_, poses, clock_.first_s, clock_.seconds_per_visit);
        const Eigen::MatrixXd rows =
            derivatives(contests_[k], cloud_, campaign) * contests_[k].standard;
        gram += rows.transpose() * rows;
      }
      const Fitted fitted(gram, contests_[k].nuisances);
      for (size_t i = 0; i < pairs_.size(); ++i) {
        if (pairs_[i].contest != k) continue;
        const Contest::Member& truth = contests_[k].members[pairs_[i].truth];
        powers[i] =
            power(Imitation(fitted.members, truth, contests_[k].members[pairs_[i].rival]).left,
                  truth.count);
      }
    }
    return powers;
  }

  SeparatedPair described(const Pair& pair, double alone, double planned, double random) const {
    const auto& members = contests_[pair.contest].members;
    SeparatedPair result;
    result.truth = members[pair.truth].effect;
    result.rival = members[pair.rival].effect;
    for (int member : {pair.truth, pair.rival}) {
      const std::string& reading = members[member].separated_by;
      if (!reading.empty() && std::find(result.readings.begin(), result.readings.end(), reading) ==
                                  result.readings.end())
        result.readings.push_back(reading);
    }
    result.by_poses = pair.by_poses;
    result.power_given = alone;
    result.power_planned = planned;
    result.power_random = random;
    return result;
  }

  PoseCloud cloud_;
  Clock clock_;
  std::vector<Contest> contests_;
  std::vector<Eigen::MatrixXd> candidates_;  // of each contest, as Discrimination wants them
  std::vector<Eigen::MatrixXd> given_, everything_;  // inner products; with the whole cloud
  std::vector<Pair> pairs_;
};

// Without masses the number of coefficients of gravity depends on the identified chain.
void require_coefficients(const Effect& effect, const Robot& robot,
                          const std::vector<std::string>& temperature_names) {
  const int needed = BoundEffect(effect, robot, temperature_names).coefficient_count();
  const auto has = std::ssize(effect.coefficients);
  if (has != needed)
    throw std::invalid_argument("effect '" + effect.name + "' of " + to_string(effect.parameter) + " has " +
                                std::to_string(has) + " coefficients where this robot needs " +
                                std::to_string(needed) +
                                "; give the robot as it was identified (close-loop --robot-out)");
}

std::string quoted(const Effect& effect) { return "'" + describe(effect) + "'"; }

// Effects no two of which can be separated by poses, and the readings that separate them.
struct InseparableSet {
  std::vector<std::string> effects;
  std::set<std::string> readings;
};

std::vector<InseparableSet> inseparable_sets(const SeparationPlan& plan) {
  using Names = std::pair<std::string, std::string>;
  std::set<Names> told;
  for (const SeparatedPair& pair : plan.pairs)
    if (pair.by_poses) told.insert(std::minmax(quoted(pair.truth), quoted(pair.rival)));

  std::vector<std::string> effects;
  std::map<Names, std::vector<std::string>> untold;  // to the readings that would tell
  for (const SeparatedPair& pair : plan.pairs) {
    const std::string truth = quoted(pair.truth), rival = quoted(pair.rival);
    if (told.count(std::minmax(truth, rival))) continue;
    untold[std::minmax(truth, rival)] = pair.readings;
    for (const std::string& effect : {truth, rival})
      if (std::find(effects.begin(), effects.end(), effect) == effects.end())
        effects.push_back(effect);
  }

  std::vector<InseparableSet> sets;
  std::set<Names> covered;
  for (size_t i = 0; i < effects.size(); ++i)
    for (size_t j = i + 1; j < effects.size(); ++j) {
      const Names seed = std::minmax(effects[i], effects[j]);
      if (!untold.count(seed) || covered.count(seed)) continue;
      InseparableSet& set = sets.emplace_back();
      set.effects.push_back(effects[i]);
      const auto add = [&](const std::string& effect) {
        for (const std::string& member : set.effects) {
          const Names pair = std::minmax(effect, member);
          covered.insert(pair);
          set.readings.insert(untold[pair].begin(), untold[pair].end());
        }
        set.effects.push_back(effect);
      };
      add(effects[j]);
      for (const std::string& effect : effects)
        if (std::ranges::all_of(set.effects, [&](const std::string& member) {
              return untold.count(std::minmax(effect, member)) > 0;
            }))
          add(effect);
    }
  return sets;
}

}  // namespace

SeparationPlan plan_separation(const Robot& robot, const std::vector<TracedEffect>& found,
                               int count, const CloudOptions& options, const Campaign& given) {
  if (count > kCloudSize)
    throw std::invalid_argument("more poses are asked for than there are candidates, " +
                                std::to_string(kCloudSize));
  for (const TracedEffect& one : found)
    require_coefficients(one.effect, robot, given.temperature_names);
  return Separation(robot, found, count, options, given).plan(count);
}

std::vector<std::string> inseparable_in_words(const SeparationPlan& plan) {
  std::vector<std::string> sentences;
  for (const auto& [effects, readings] : inseparable_sets(plan))
    sentences.push_back(fmt::format(
        "no poses separate {}: after a refit their predictions are equal{}{}",
        fmt::join(effects, ", "),
        readings.empty() ? "" : "; a reading that does: ", fmt::join(readings, "; or ")));
  return sentences;
}

}  // namespace armtrue
