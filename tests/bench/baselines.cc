// Against what people use instead: geometry alone, and geometry with a black box on what it leaves.
// Every method sees the same training poses and is scored by the mean position error on the same
// held-out poses.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/split.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/catalogue_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/tracing/loop.h"
#include "bench/two_threads.h"
#include "kinematics/six_axes.h"
#include "search/candidates.h"
#include "search/linearization.h"
#include "search/scan.h"

namespace {

using namespace armtrue;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::RowVectorXd;
using Eigen::VectorXd;
using Eigen::VectorXf;

constexpr int kFolds = 5;  // of cross-validation by pose, which chooses penalties

// What the geometry leaves of one target, replicates averaged: a row is a pose.
struct Leftover {
  MatrixXd q;         // 6 columns [rad]
  MatrixXd residual;  // 3 columns, axes of R_A [m]
};
// From joint angles, a row a pose, to the residual to expect there.
using Correction = std::function<MatrixXd(const MatrixXd& q)>;

MatrixXd rows_of(const MatrixXd& all, const std::vector<int>& rows) {
  return all(rows, Eigen::all);
}

// `count` values from 10^high down to 10^low.
VectorXd falling_powers(int count, double high, double low) {
  return VectorXd::LinSpaced(count, high, low).unaryExpr([](double e) {
    return std::pow(10.0, e);
  });
}

// ---- Gaussian process

MatrixXd squared_distances(const MatrixXd& a, const MatrixXd& b) {
  const auto on_circles = [](const MatrixXd& q) {
    MatrixXd x(q.rows(), 2 * q.cols());
    x << q.array().sin().matrix(), q.array().cos().matrix();
    return x;
  };
  const MatrixXd x = on_circles(a), y = on_circles(b);
  MatrixXd d = -2 * x * y.transpose();
  d.colwise() += x.rowwise().squaredNorm();
  d.rowwise() += y.rowwise().squaredNorm().transpose();
  return d.cwiseMax(0);
}

// Three independent processes; each takes the length scale and the ratio of noise to signal of
// highest marginal likelihood, with the signal's variance at its own maximum in closed form.
Correction gaussian_process(const Leftover& all, int most_poses) {
  constexpr std::array kLengths{0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0};
  constexpr std::array kNoiseRatios{1e-3, 1e-2, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0};
  std::vector<int> kept;
  const int poses = static_cast<int>(all.q.rows()), count = std::min(poses, most_poses);
  for (int i = 0; i < count; ++i)
    kept.push_back(static_cast<int>(static_cast<long>(i) * poses / count));
  const MatrixXd q = rows_of(all.q, kept), y = rows_of(all.residual, kept);

  struct Process {
    double log_likelihood = -std::numeric_limits<double>::infinity(), length = 1;
    VectorXd weights;
  };
  std::array<Process, 3> processes;
  const MatrixXd distances = squared_distances(q, q);
  for (double length : kLengths) {
    const MatrixXd kernel = (-0.5 / (length * length) * distances.array()).exp();
    for (double ratio : kNoiseRatios) {
      MatrixXd covariance = kernel;
      covariance.diagonal().array() += ratio;
      const Eigen::LLT<MatrixXd> cholesky(covariance);
      const double half_log_determinant =
          MatrixXd(cholesky.matrixL()).diagonal().array().log().sum();
      const MatrixXd weights = cholesky.solve(y);
      for (int axis = 0; axis < 3; ++axis) {
        const double signal = y.col(axis).dot(weights.col(axis)) / count;
        const double log_likelihood = -0.5 * count * std::log(signal) - half_log_determinant;
        Process& best = processes[static_cast<size_t>(axis)];
        if (log_likelihood > best.log_likelihood)
          best = {log_likelihood, length, weights.col(axis)};
      }
    }
  }
  return [q, processes](const MatrixXd& at) {
    const MatrixXd between = squared_distances(at, q);
    MatrixXd mean(at.rows(), 3);
    for (int axis = 0; axis < 3; ++axis) {
      const Process& process = processes[static_cast<size_t>(axis)];
      const double scale = -0.5 / (process.length * process.length);
      mean.col(axis) = (scale * between.array()).exp().matrix() * process.weights;
    }
    return mean;
  };
}

// ---- Ridge on generic features

// Sines and cosines of one to three turns of every joint, and the products of those of two joints.
MatrixXd features(const MatrixXd& q) {
  constexpr int kTurns = 3, kPerJoint = 2 * kTurns;
  MatrixXd waves(q.rows(), kPerJoint * kJoints);
  for (int joint = 0; joint < kJoints; ++joint)
    for (int turn = 1; turn <= kTurns; ++turn) {
      const int column = kPerJoint * joint + 2 * (turn - 1);
      waves.col(column) = (turn * q.col(joint).array()).sin();
      waves.col(column + 1) = (turn * q.col(joint).array()).cos();
    }
  const int single = static_cast<int>(waves.cols());
  MatrixXd x(q.rows(), single + kPerJoint * kPerJoint * kJoints * (kJoints - 1) / 2);
  x.leftCols(single) = waves;
  int next = single;
  for (int a = 0; a < single; ++a)
    for (int b = (a / kPerJoint + 1) * kPerJoint; b < single; ++b)
      x.col(next++) = waves.col(a).cwiseProduct(waves.col(b));
  return x;
}

// The weights (features x 3) for every penalty, on features of unit variance.
std::vector<MatrixXd> ridge(const MatrixXd& x, const MatrixXd& y, const VectorXd& penalties) {
  const auto n = static_cast<double>(x.rows());
  const bool fewer_poses = x.rows() < x.cols();  // then the dual is the smaller system
  const MatrixXd gram = fewer_poses ? MatrixXd(x * x.transpose()) : MatrixXd(x.transpose() * x);
  std::vector<MatrixXd> path;
  for (double penalty : penalties) {
    MatrixXd system = gram;
    system.diagonal().array() += n * penalty;
    const Eigen::LLT<MatrixXd> cholesky(system);
    path.push_back(fewer_poses ? MatrixXd(x.transpose() * cholesky.solve(y))
                               : MatrixXd(cholesky.solve(x.transpose() * y)));
  }
  return path;
}

// Each axis takes the penalty of the smallest squared error under five-fold cross-validation by
// pose.
Correction ridge_on_features(const Leftover& leftover) {
  const VectorXd penalties = falling_powers(13, 3, -3);
  MatrixXd x = features(leftover.q);
  const RowVectorXd centre = x.colwise().mean();
  x.rowwise() -= centre;
  RowVectorXd scale = (x.colwise().squaredNorm() / static_cast<double>(x.rows())).cwiseSqrt();
  for (double& value : scale)
    if (value < 1e-6) value = std::numeric_limits<double>::infinity();
  x.array().rowwise() /= scale.array();
  const RowVectorXd mean = leftover.residual.colwise().mean();
  const MatrixXd y = leftover.residual.rowwise() - mean;

  MatrixXd errors = MatrixXd::Zero(penalties.size(), 3);
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<int> in, out;
    for (int row = 0; row < x.rows(); ++row) (row % kFolds == fold ? out : in).push_back(row);
    const auto weights = ridge(rows_of(x, in), rows_of(y, in), penalties);
    const MatrixXd x_out = rows_of(x, out), y_out = rows_of(y, out);
    for (int k = 0; k < penalties.size(); ++k)
      errors.row(k) += (y_out - x_out * weights[static_cast<size_t>(k)]).colwise().squaredNorm();
  }
  const auto paths = ridge(x, y, penalties);
  MatrixXd chosen(x.cols(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    int best = 0;
    errors.col(axis).minCoeff(&best);
    chosen.col(axis) = paths[static_cast<size_t>(best)].col(axis);
  }
  return [=](const MatrixXd& q) -> MatrixXd {
    const MatrixXd standard = (features(q).rowwise() - centre).array().rowwise() / scale.array();
    return (standard * chosen).rowwise() + mean;
  };
}

// ---- Lasso on all candidates

// All that the search could add, catalogue and beyond, as columns beside the geometry: what the
// arm's own derivatives make of it in every reading.
struct Dictionary {
  MatrixXf columns;    // equations x columns, whitened
  MatrixXd geometric;  // the derivatives of the geometry
  VectorXd residual;   // whitened, of the geometric fit

  Dictionary rows(const std::vector<Eigen::Index>& some) const {
    return {columns(some, Eigen::all), geometric(some, Eigen::all), residual(some)};
  }
};

Dictionary dictionary(const std::vector<Candidate>& candidates, const CalibrationResult& geometry,
                      const Campaign& campaign, const std::vector<double>& weights) {
  CalibrationResult fit = geometry;
  fit.weights = weights;
  const SessionModels models(campaign, fit.robot, fit.set.kept, fit.sigma);
  MatrixXd blocks = models.blocks();
  const int size = models.row_size();
  for (int row = 0; row < campaign.rows(); ++row)
    blocks.middleRows(row * size, size) *= std::sqrt(weights[static_cast<size_t>(row)]);
  Dictionary all;
  all.geometric = blocks.leftCols(models.unknowns());
  all.residual = blocks.rightCols<1>();
  const Linearization linear(fit, campaign);
  const CandidateScan scan(candidates, fit.robot, campaign);
  std::vector<MatrixXd> columns;
  Eigen::Index count = 0;
  for (size_t k = 0; k < scan.candidates().size(); ++k) {
    columns.push_back(scan.columns_at_readings(linear, static_cast<int>(k)));
    count += columns.back().cols();
  }
  all.columns.resize(blocks.rows(), count);
  Eigen::Index next = 0;
  for (const MatrixXd& of_candidate : columns) {
    all.columns.middleCols(next, of_candidate.cols()) = of_candidate.cast<float>();
    next += of_candidate.cols();
  }
  return all;
}

// Coordinate descent on what is not zero or pulls harder than the penalty, from each penalty to the
// next lower one.
class Lasso {
 public:
  // `x`: columns of unit length or of nothing.
  Lasso(MatrixXf x, VectorXf y)
      : x_(std::move(x)),
        left_(std::move(y)),
        pull_(x_.transpose() * left_),
        weights_(VectorXf::Zero(x_.cols())),
        is_active_(static_cast<size_t>(x_.cols())) {}

  // From which penalty on all weights are zero.
  float highest() const { return pull_.cwiseAbs().maxCoeff(); }

  const VectorXf& solve(float penalty) {
    constexpr int kMaxSweeps = 100;
    constexpr float kTolerance = 1e-2f;  // of the penalty
    for (bool grown = true; grown;) {
      grown = false;
      for (Eigen::Index j = 0; j < x_.cols(); ++j)
        if (!is_active_[static_cast<size_t>(j)] && std::abs(pull_[j]) > penalty) {
          active_.push_back(j);
          is_active_[static_cast<size_t>(j)] = grown = true;
        }
      float change = penalty;
      for (int sweep = 0; sweep < kMaxSweeps && change > kTolerance * penalty; ++sweep) {
        change = 0;
        for (Eigen::Index j : active_) {
          const float to_fit = x_.col(j).dot(left_) + weights_[j];
          const float to = std::copysign(std::max(std::abs(to_fit) - penalty, 0.0f), to_fit);
          const float step = to - weights_[j];
          if (step == 0) continue;
          left_ -= step * x_.col(j);
          weights_[j] = to;
          change = std::max(change, std::abs(step));
        }
      }
      pull_.noalias() = x_.transpose() * left_;
    }
    return weights_;
  }

 private:
  MatrixXf x_;
  VectorXf left_, pull_, weights_;
  std::vector<Eigen::Index> active_;
  std::vector<bool> is_active_;
};

// The lasso beside the geometry, which follows what is taken from its residual.
class LassoBesideGeometry {
 public:
  explicit LassoBesideGeometry(const Dictionary& seen)
      : seen_(seen), geometric_(seen.geometric), length_(seen.columns.cols()) {
    const MatrixXf basis = MatrixXd(geometric_.householderQ() *
                                    MatrixXd::Identity(seen.geometric.rows(), geometric_.rank()))
                               .cast<float>();
    MatrixXf x = seen.columns;
    x.noalias() -= basis * (basis.transpose() * x);
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      // What the geometry can imitate but for a hundredth is not told from it.
      const float own = x.col(j).norm();
      length_[j] =
          own > 0.01f * seen.columns.col(j).norm() ? own : std::numeric_limits<float>::infinity();
      x.col(j) /= length_[j];
    }
    VectorXf y = seen.residual.cast<float>();
    y -= basis * (basis.transpose() * y);
    lasso_.emplace(std::move(x), std::move(y));
  }

  float highest() const { return lasso_->highest(); }
  void solve(float penalty) { weights_ = lasso_->solve(penalty).cwiseQuotient(length_); }

  // What it leaves of readings, of these or of others.
  VectorXd left(const Dictionary& of) const {
    const VectorXd taken = (seen_.columns * weights_).cast<double>();
    const VectorXd followed = geometric_.solve(seen_.residual - taken);
    return of.residual - (of.columns * weights_).cast<double>() - of.geometric * followed;
  }

 private:
  const Dictionary& seen_;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> geometric_;
  VectorXf length_, weights_;
  std::optional<Lasso> lasso_;
};

// Mean error of the held-out readings [m].
double lasso_on_candidates(const CalibrationResult& model, const Campaign& training,
                           const Campaign& held_out, const Catalogue& catalogue) {
  constexpr int kMaxPenalties = 40, kPatience = 3;
  constexpr float kFall = 0.75f;
  std::vector<Candidate> candidates = catalogue_candidates(catalogue, model.robot, training);
  for (const Candidate& open : open_candidates(model.robot, training)) candidates.push_back(open);
  const Dictionary seen = dictionary(candidates, model, training, model.weights);
  const std::vector<int> pose = training.pose_by_id();
  const Eigen::Index size = seen.residual.size() / training.rows();
  std::vector<Dictionary> in(kFolds), out(kFolds);
  std::vector<LassoBesideGeometry> folds;
  for (size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<Eigen::Index> taken, left_out;
    for (int row = 0; row < training.rows(); ++row)
      for (Eigen::Index k = 0; k < size; ++k)
        (pose[static_cast<size_t>(row)] % kFolds == static_cast<int>(fold) ? left_out : taken)
            .push_back(row * size + k);
    in[fold] = seen.rows(taken);
    out[fold] = seen.rows(left_out);
    folds.emplace_back(in[fold]);
  }
  LassoBesideGeometry all(seen);
  // Falling penalties, as long as what the folds leave of their poses falls.
  const float highest = all.highest();
  float penalty = highest, best = highest;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0, since = 0; k < kMaxPenalties && since < kPatience; ++k, ++since) {
    double error = 0;
    for (size_t fold = 0; fold < kFolds; ++fold) {
      folds[fold].solve(penalty);
      error += folds[fold].left(out[fold]).squaredNorm();
    }
    if (error < least) {
      least = error;
      best = penalty;
      since = 0;
    }
    penalty *= kFall;
  }
  for (penalty = highest; penalty >= best; penalty *= kFall) all.solve(penalty);

  const VectorXd left = all.left(dictionary(
      candidates, model, held_out, std::vector<double>(static_cast<size_t>(held_out.rows()), 1)));
  double sum = 0;
  for (int row = 0; row < held_out.rows(); ++row)
    sum += model.sigma.position * left.segment<3>(row * size).norm();
  return sum / held_out.rows();
}

// ---- Campaigns

struct Data {
  std::string name;
  Robot robot;
  Campaign training, held_out;
};

std::string target_of(const Campaign& campaign, int row) {
  return campaign.target.empty() ? ""
                                 : campaign.target_names[static_cast<size_t>(campaign.target[row])];
}

// Rows by target. A black box knows nothing of levers: every target has a correction of its own.
std::map<std::string, std::vector<int>> rows_by_target(const Campaign& campaign) {
  std::map<std::string, std::vector<int>> rows;
  for (int row = 0; row < campaign.rows(); ++row) rows[target_of(campaign, row)].push_back(row);
  return rows;
}

Leftover leftover(const Campaign& campaign, const Evaluation& geometry,
                  const std::vector<int>& rows) {
  std::map<int, std::vector<int>> poses;
  for (int row : rows) poses[campaign.pose[row]].push_back(row);
  Leftover result;
  result.q.setZero(static_cast<int>(poses.size()), kJoints);
  result.residual.setZero(static_cast<int>(poses.size()), 3);
  int next = 0;
  for (const auto& [pose, readings] : poses) {
    for (int row : readings) {
      result.q.row(next) += campaign.q[row].transpose();
      result.residual.row(next) += geometry.residuals[row].head<3>().transpose();
    }
    result.q.row(next) /= static_cast<double>(readings.size());
    result.residual.row(next) /= static_cast<double>(readings.size());
    ++next;
  }
  return result;
}

// Mean over the held-out readings of what is left when the correction of their target is taken off
// [m].
double mean_error(const Campaign& campaign, const Evaluation& geometry,
                  const std::map<std::string, Correction>& corrections) {
  double sum = 0;
  for (const auto& [target, rows] : rows_by_target(campaign)) {
    MatrixXd q(static_cast<int>(rows.size()), kJoints);
    for (int i = 0; i < q.rows(); ++i)
      q.row(i) = campaign.q[rows[static_cast<size_t>(i)]].transpose();
    const MatrixXd expected = corrections.at(target)(q);
    for (int i = 0; i < q.rows(); ++i)
      sum +=
          (geometry.residuals[rows[static_cast<size_t>(i)]].head<3>() - expected.row(i).transpose())
              .norm();
  }
  return sum / campaign.rows();
}

enum Method { kGeometry, kGaussianProcess, kRidge, kLasso, kOurs, kApplied, kMethods };
using Errors = std::array<double, kMethods>;  // [m]

Errors compare(const Data& data, const Catalogue& catalogue, int most_poses) {
  LoopResult loop = close_loop(data.robot, data.training, data.held_out, catalogue);
  const Robot& geometric = loop.trace.stages.front().robot;
  const Evaluation training = evaluate(geometric, data.training);
  const Evaluation held_out = evaluate(geometric, data.held_out);
  const auto corrected = [&](const std::function<Correction(const Leftover&)>& learn) {
    std::map<std::string, Correction> corrections;
    for (const auto& [target, rows] : rows_by_target(data.training))
      corrections[target] = learn(leftover(data.training, training, rows));
    return mean_error(data.held_out, held_out, corrections);
  };
  Errors errors;
  errors[kGeometry] = loop.before;
  errors[kGaussianProcess] =
      corrected([&](const Leftover& left) { return gaussian_process(left, most_poses); });
  errors[kRidge] = corrected(ridge_on_features);
  errors[kLasso] =
      lasso_on_candidates(loop.trace.stages.front(), data.training, data.held_out, catalogue);
  errors[kOurs] = loop.after_named;
  errors[kApplied] = loop.after;
  return errors;
}

struct Set {
  std::string name;
  std::filesystem::path robot, training,
      held_out;  // without held_out, 30 % of the poses are split off
};

std::vector<Set> find_sets(const std::filesystem::path& data) {
  std::vector<Set> sets;
  const auto folders = [](const std::filesystem::path& parent) {
    std::vector<std::filesystem::path> list;
    if (!std::filesystem::is_directory(parent)) return list;
    for (const auto& entry : std::filesystem::directory_iterator(parent))
      if (entry.is_directory()) list.push_back(entry.path());
    std::sort(list.begin(), list.end());
    return list;
  };
  for (const auto& folder : folders(data / "practice/std"))
    sets.push_back({"practice/std/" + folder.filename().string(), data / "robot-kr360-spindle.yaml",
                    folder / "train.csv", folder / "test.csv"});
  for (const auto& folder : folders(data / "measured"))
    for (const char* file : {"commanded.csv", "measured.csv", "grid.csv"})
      if (std::filesystem::exists(folder / file))
        sets.push_back(
            {"measured/" + folder.filename().string(), folder / "robot.yaml", folder / file, ""});
  return sets;
}

Data read(const Set& set, std::uint64_t seed) {
  Data data{set.name, read_robot(set.robot).robot, read_campaign(set.training).campaign, {}};
  if (!set.held_out.empty()) {
    data.held_out = read_campaign(set.held_out).campaign;
    return data;
  }
  const Split split = split_by_pose(data.training, 0.3, seed);
  data.held_out = data.training.select(split.held_out);
  data.training = data.training.select(split.training);
  return data;
}

void print_line(const std::string& name, const Errors& values) {
  fmt::print("{:<32}", name);
  for (double value : values) fmt::print("{:>12.4f}", value);
  fmt::print("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Held-out mean position error of the loop and of what people use instead");
  std::filesystem::path folder = ARMTRUE_DATA;
  std::vector<std::string> only, skip;
  int most_poses = 800;
  std::uint64_t seed = 1;
  app.add_option("--data", folder, "Holds practice/std/NNN and measured/SET");
  app.add_option("--skip", skip, "Leave out the sets whose names contain one of these");
  app.add_option("--gp-poses", most_poses, "Training poses for the Gaussian process at most")
      ->capture_default_str();
  app.add_option("--seed", seed, "Of the splits of measured sets")->capture_default_str();
  app.add_option("sets", only, "Run only the sets whose names contain one of these");
  CLI11_PARSE(app, argc, argv);

  std::vector<Set> sets = find_sets(folder);
  const auto matches = [](const std::string& name, const std::vector<std::string>& parts) {
    return std::any_of(parts.begin(), parts.end(), [&](const std::string& part) {
      return name.find(part) != std::string::npos;
    });
  };
  std::erase_if(sets, [&](const Set& set) {
    return (!only.empty() && !matches(set.name, only)) || matches(set.name, skip);
  });
  if (sets.empty()) {
    fmt::print("no campaigns under {}; nothing to run\n", folder.string());
    return 0;
  }

  const Catalogue catalogue = read_catalogue(ARMTRUE_CONFIG "/effects/catalogue.yaml");
  fmt::print("{:<32}{:>12}{:>12}{:>12}{:>12}{:>12}{:>12}   mm\n", "held-out mean error", "geometry",
             "+ GP", "+ ridge", "+ lasso", "armtrue", "applied");
  struct Sum {
    Errors ratios{};
    int sets = 0;
  };
  std::map<std::string, Sum> sums;
  std::mutex printing;
  armtrue_bench::on_two_threads(static_cast<int>(sets.size()), [&](int i) {
    const Set& set = sets[static_cast<size_t>(i)];
    Errors errors = compare(read(set, seed), catalogue, most_poses);
    const std::lock_guard lock(printing);
    Sum& sum = sums[set.name.substr(0, set.name.find('/'))];
    ++sum.sets;
    for (size_t m = 0; m < kMethods; ++m) sum.ratios[m] += errors[m] / errors[kOurs];
    for (double& error : errors) error /= kMillimetre;
    print_line(set.name, errors);
  });
  for (auto& [group, sum] : sums) {
    for (double& ratio : sum.ratios) ratio /= sum.sets;
    print_line(fmt::format("{}: mean ratio of {}", group, sum.sets), sum.ratios);
  }
}
