#include "armtrue/diagnosis/readings_difference.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/diagnosis/change.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/distributions.h"
#include "linear_algebra/decompositions.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

struct ChowUnknowns {
  std::vector<int> arm, set_up;  // indices of parameters
};

// What either run identified of the links, and of the station.
ChowUnknowns chow_unknowns(const Robot& before, const Robot& after) {
  ChowUnknowns unknowns;
  const ParameterLayout layout = layout_of(before.chain);
  for (const Robot* robot : {&before, &after})
    for (const std::string& name : robot->uncertainty->parameters)
      if (const auto parameter = find_parameter(before.chain, name);
          parameter && robot->std.contains(name)) {
        std::vector<int>& own = layout.is_of_links(*parameter) ? unknowns.arm : unknowns.set_up;
        if (std::ranges::count(own, *parameter) == 0) own.push_back(*parameter);
      }
  return unknowns;
}

// The mean equations of the poses of one run, one below the other: derivatives by base and tool
// (and by the scale of the instrument), then by the arm, residual last.
struct RunEquations {
  Eigen::MatrixXd rows;
  Eigen::Index set_up = 0;                 // columns
  std::vector<Eigen::Index> first_rows{};  // of each pose, whose channels share what models lack
};

std::vector<Eigen::Index> first_rows_of_poses(const Campaign& campaign, int size) {
  std::set<std::pair<int, int>> groups;
  for (int row = 0; row < campaign.rows(); ++row)
    groups.insert({campaign.pose[row], campaign.channel(row)});
  std::vector<Eigen::Index> first;
  Eigen::Index row = 0;
  int pose = -1;
  for (const auto& [of, channel] : groups) {
    if (of != pose) first.push_back(row);
    pose = of;
    row += size;
  }
  return first;
}

Eigen::MatrixXd means_of_channels(const ObservationModel& model, const Campaign& campaign) {
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  const int size = model.row_size();
  std::map<std::pair<int, int>, std::vector<int>> groups;
  for (int row = 0; row < model.rows(); ++row)
    groups[{campaign.pose[row], campaign.channel(row)}].push_back(row);
  Eigen::MatrixXd means(std::ssize(groups) * size, model.unknowns() + 1);
  Eigen::MatrixXd block(size, model.unknowns() + 1);
  Eigen::Index top = 0;
  for (const auto& [key, rows] : groups) {
    auto mean = means.middleRows(top, size);
    top += size;
    mean.setZero();
    for (const int row : rows) {
      at.block(row, block);
      mean += block / static_cast<double>(rows.size());
    }
  }
  return means;
}

// How the residuals change with the scale of the instrument, at the points of the model: those of
// the readings differ by the residual, which a scale of all lengths would then explain.
Eigen::VectorXd column_of_scale(const Robot& robot, const MeasuredRun& run,
                                const std::vector<int>& parameters,
                                const Eigen::VectorXd& residual) {
  constexpr double kStep = 1e-4;
  Campaign larger = *run.campaign;
  for (Eigen::Vector3d& point : larger.position) point *= 1 + kStep;
  const ObservationModel model(larger, robot, parameters, run.spread);
  const Eigen::VectorXd change = means_of_channels(model, larger).rightCols<1>() - residual;
  return (change.array() == 0)
      .select(Eigen::VectorXd::Zero(change.size()), change / kStep - residual);
}

RunEquations equations_of(const Robot& robot, const MeasuredRun& run, const ChowUnknowns& unknowns,
                          bool has_scale) {
  std::vector<int> all = unknowns.set_up;
  all.insert(all.end(), unknowns.arm.begin(), unknowns.arm.end());
  const ObservationModel model(*run.campaign, robot, all, run.spread);
  RunEquations equations{means_of_channels(model, *run.campaign),
                         static_cast<Eigen::Index>(unknowns.set_up.size()),
                         first_rows_of_poses(*run.campaign, model.row_size())};
  if (!has_scale) return equations;
  Eigen::MatrixXd wider(equations.rows.rows(), equations.rows.cols() + 1);
  wider << column_of_scale(robot, run, all, equations.rows.rightCols<1>()), equations.rows;
  equations.rows = std::move(wider);
  ++equations.set_up;
  return equations;
}

Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor_of(const Eigen::MatrixXd& columns) {
  constexpr double kNotShown = 1e-7;
  const Eigen::VectorXd norms = columns.colwise().norm().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns.rows(), columns.cols());
  qr.setThreshold(kNotShown);
  qr.compute(columns * norms.cwiseInverse().asDiagonal());
  return qr;
}

// What base and tool leave of the equations.
Eigen::MatrixXd of_the_arm(const Eigen::MatrixXd& rows, Eigen::Index set_up) {
  const auto qr = factor_of(rows.leftCols(set_up));
  const Eigen::MatrixXd turned =
      product(qr.householderQ().adjoint(), Eigen::MatrixXd(rows.rightCols(rows.cols() - set_up)));
  return turned.bottomRows(rows.rows() - qr.rank());
}

struct ChowFit {
  double squares = 0, freedom = 0;
  Eigen::Index rank = 0;
};

ChowFit chow_fit(const Eigen::MatrixXd& rows) {
  const auto qr = factor_of(rows.leftCols(rows.cols() - 1));
  const Eigen::VectorXd turned =
      product(qr.householderQ().adjoint(), Eigen::VectorXd(rows.rightCols<1>()));
  const Eigen::Index left = rows.rows() - qr.rank();
  return {turned.tail(left).squaredNorm(), static_cast<double>(left), qr.rank()};
}

// In units of the scatter about the run's own fit: means of several visits, and readings of a
// better instrument, scatter less, and the test takes all of both runs as alike.
RunEquations in_own_scatter(RunEquations run) {
  const ChowFit own = chow_fit(of_the_arm(run.rows, run.set_up));
  if (own.freedom >= 1 && own.squares > 0) run.rows /= std::sqrt(own.squares / own.freedom);
  return run;
}

struct ChowTest {
  double f = 0, lacking = 0, freedom = 0;
};

std::optional<ChowTest> chow_test(const Eigen::MatrixXd& first, Eigen::Index first_set_up,
                                  const Eigen::MatrixXd& second, Eigen::Index second_set_up) {
  const Eigen::MatrixXd one = of_the_arm(first, first_set_up),
                        other = of_the_arm(second, second_set_up);
  Eigen::MatrixXd both(one.rows() + other.rows(), one.cols());
  both << one, other;
  const ChowFit of_one = chow_fit(one), of_other = chow_fit(other), common = chow_fit(both);
  ChowTest test;
  test.lacking = static_cast<double>(of_one.rank + of_other.rank - common.rank);
  test.freedom = of_one.freedom + of_other.freedom;
  if (test.lacking < 1 || of_one.freedom < 1 || of_other.freedom < 1) return std::nullopt;
  const double own = of_one.squares + of_other.squares;
  test.f = std::max(0.0, common.squares - own) / test.lacking / (own / test.freedom);
  return test;
}

// The equations of all poses with what base and tool of each run, beside one arm for both, leave of
// the residuals. Under one arm they could stand in either run. A scale of the second is taken up
// too, and its column is gone.
RunEquations exchangeable(const RunEquations& first, const RunEquations& second) {
  const Eigen::Index scale = second.set_up - first.set_up, set_up = first.set_up;
  const Eigen::Index n = first.rows.rows(), m = second.rows.rows(),
                     arm = first.rows.cols() - set_up - 1;
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(n + m, arm + set_up + second.set_up);
  joint.topLeftCorner(n, arm) = first.rows.middleCols(set_up, arm);
  joint.bottomLeftCorner(m, arm) = second.rows.middleCols(second.set_up, arm);
  joint.block(0, arm, n, set_up) = first.rows.leftCols(set_up);
  joint.bottomRightCorner(m, second.set_up) = second.rows.leftCols(second.set_up);
  const Eigen::VectorXd norms = joint.colwise().norm().cwiseMax(1e-300);
  Eigen::VectorXd residual(n + m);
  residual << first.rows.rightCols<1>(), second.rows.rightCols<1>();
  const Eigen::VectorXd x =
      norms.cwiseInverse().asDiagonal() * Eigen::VectorXd(factor_of(joint).solve(residual));
  residual -= joint.rightCols(joint.cols() - arm) * x.tail(joint.cols() - arm);
  RunEquations all{Eigen::MatrixXd(n + m, first.rows.cols()), set_up, first.first_rows};
  for (const Eigen::Index row : second.first_rows) all.first_rows.push_back(n + row);
  all.rows << first.rows, second.rows.rightCols(second.rows.cols() - scale);
  all.rows.rightCols<1>() = residual;
  return all;
}

// The p-value of an F by exchanging poses between the runs: what models lack is not normal, and the
// coordinates of a pose share it. Ends as soon as the runs are not told apart.
double p_of_exchange(const RunEquations& first, const RunEquations& second, double f) {
  constexpr int kExchanges = 199;
  const RunEquations all = exchangeable(first, second);
  std::vector<int> order(all.first_rows.size());
  std::iota(order.begin(), order.end(), 0);
  const auto rows_of = [&](int pose) {
    const Eigen::Index from = all.first_rows[pose];
    const bool is_last = pose + 1 == std::ssize(all.first_rows);
    return std::pair{from, (is_last ? all.rows.rows() : all.first_rows[pose + 1]) - from};
  };
  int beyond = 0;
  for (int k = 0; k < kExchanges; ++k) {
    shuffle(order, static_cast<std::uint64_t>(k));
    Eigen::MatrixXd rows(all.rows.rows(), all.rows.cols());
    Eigen::Index end = 0, end_of_first = 0;
    for (size_t place = 0; place < order.size(); ++place) {
      const auto [from, count] = rows_of(order[place]);
      rows.middleRows(end, count) = all.rows.middleRows(from, count);
      end += count;
      if (place + 1 == first.first_rows.size()) end_of_first = end;
    }
    const auto test = chow_test(rows.topRows(end_of_first), all.set_up,
                                rows.bottomRows(rows.rows() - end_of_first), all.set_up);
    beyond += test && test->f >= f;
    if ((beyond + 1.0) / (kExchanges + 1.0) >= kChangeSignificance) break;
  }
  return (beyond + 1.0) / (kExchanges + 1.0);
}

struct Told {
  double p_value, f, critical;
};

std::optional<Told> told_apart(const RunEquations& first, const RunEquations& second) {
  const auto test = chow_test(first.rows, first.set_up, second.rows, second.set_up);
  if (!test) return std::nullopt;
  Told told{fisher_f_above(test->f, test->lacking, test->freedom), test->f,
            fisher_f_quantile(1 - kChangeSignificance, test->lacking, test->freedom)};
  if (told.p_value >= kChangeSignificance) return told;
  told.p_value = std::max(told.p_value, p_of_exchange(first, second, test->f));
  if (told.p_value >= kChangeSignificance) told.critical = test->f;
  return told;
}

}  // namespace

bool ReadingsDifference::moved() const { return p_value < kChangeSignificance; }

std::optional<ReadingsDifference> readings_difference(const Robot& before, const MeasuredRun& first,
                                                      const Robot& after,
                                                      const MeasuredRun& second) {
  for (const MeasuredRun& run : {first, second})
    if (!run.campaign || run.campaign->position.empty() || run.campaign->reads_one_number())
      return std::nullopt;
  if (!before.uncertainty || !after.uncertainty || !before.sessions.empty() ||
      !after.sessions.empty())
    return std::nullopt;
  const ChowUnknowns unknowns = chow_unknowns(before, after);
  const Campaign of_first =
      without_gross(*first.campaign, find_gross_poses(before, *first.campaign));
  const Campaign of_second =
      without_gross(*second.campaign, find_gross_poses(after, *second.campaign));
  std::vector<std::string> set_up;
  for (const int parameter : unknowns.set_up)
    set_up.push_back(parameter_name(before.chain, parameter));
  const Robot elsewhere = refit_set_up(before, of_second, set_up);
  const MeasuredRun one{&of_first, first.spread}, other{&of_second, second.spread};
  const RunEquations own = in_own_scatter(equations_of(before, one, unknowns, false));
  const auto apart_from = [&](bool has_scale) {
    return told_apart(own, in_own_scatter(equations_of(elsewhere, other, unknowns, has_scale)));
  };
  const auto found = apart_from(false), beside_scale = apart_from(true);
  if (!found || !beside_scale) return std::nullopt;
  return ReadingsDifference{found->p_value, beside_scale->p_value, found->f / found->critical};
}

}  // namespace armtrue
