#include "diagnosis/plain_fit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/campaign/selection.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {

namespace {

Campaign part_of(const Campaign& campaign) {
  constexpr int kMostRows = 500, kMostImages = 100, kCorners = 12;
  if (campaign.has_pixels_only())
    return campaign.select(corners_evenly_chosen(campaign, kMostImages, kCorners));
  std::vector<int> rows(campaign.pose.size());
  std::iota(rows.begin(), rows.end(), 0);
  return campaign.select(readings_evenly_chosen(campaign, rows, kMostRows));
}

}  // namespace

double PlainFit::poses() const {
  return static_cast<double>(std::set(readings.pose.begin(), readings.pose.end()).size());
}

PlainFit beside_fit(const CalibrationResult& fit, const Campaign& campaign) {
  return {part_of(campaign), fit};
}

std::optional<PlainFit> fit_plainly(const Robot& given, const Campaign& campaign) {
  Robot robot = given;
  robot.identify = {"auto"};
  return fit_as_asked(robot, campaign);
}

std::optional<PlainFit> fit_as_asked(const Robot& given, const Campaign& campaign) {
  Campaign readings = part_of(campaign);
  Robot robot = given;
  robot.effects.clear();
  try {
    CalibrationResult result = calibrate(robot, readings, {.robust = readings.has_pixels_only()});
    return PlainFit{std::move(readings), std::move(result)};
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

namespace {

// Parameters by their columns: what all sessions share, what each has of its own, the further ones.
struct Columns {
  std::vector<int> shared{}, own{}, further{};
};

Columns columns_of(const PlainFit& fit, const std::vector<int>& further, bool has_sessions) {
  Columns columns{.further = further};
  if (has_sessions) columns.own = own_parameters(fit.result.robot);
  for (const int parameter : fit.result.set.kept)
    if (std::ranges::find(columns.own, parameter) == columns.own.end())
      columns.shared.push_back(parameter);
  return columns;
}

std::vector<int> joined(const Columns& columns) {
  std::vector<int> all = columns.shared;
  all.insert(all.end(), columns.own.begin(), columns.own.end());
  all.insert(all.end(), columns.further.begin(), columns.further.end());
  return all;
}

// The columns as they are.
struct RawEquations {
  int row_size;
  std::vector<std::vector<int>> rows;
  Eigen::MatrixXd fitted, beside;
  Eigen::VectorXd residual;
};

RawEquations raw_equations(const PlainFit& fit, const std::vector<int>& further_parameters) {
  const std::vector<std::vector<int>> sessions = rows_by_session(fit.readings);
  const Columns columns = columns_of(fit, further_parameters, sessions.size() > 1);
  const std::vector<int> parameters = joined(columns);
  const auto shared = std::ssize(columns.shared), own = std::ssize(columns.own),
             further = std::ssize(columns.further);
  const int size = fit.readings.reading_size().all();
  const Eigen::Index equations = fit.readings.rows() * size;
  RawEquations raw{size,
                   {},
                   Eigen::MatrixXd::Zero(equations, shared + own * std::ssize(sessions)),
                   Eigen::MatrixXd::Zero(equations, further),
                   Eigen::VectorXd(equations)};
  for (int row = 0; row < fit.readings.rows(); ++row) raw.rows.push_back({row});
  for (int session = 0; session < std::ssize(sessions); ++session) {
    const Campaign readings = fit.readings.select(sessions[session]);
    const ObservationModel model(readings, robot_at_row(fit.result.robot, readings, 0), parameters,
                                 fit.result.sigma, 0);
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(size, model.unknowns() + 1);
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      const int first = sessions[session][row] * size;
      raw.fitted.block(first, 0, size, shared) = block.leftCols(shared);
      raw.fitted.block(first, shared + own * session, size, own) = block.middleCols(shared, own);
      raw.beside.middleRows(first, size) = block.middleCols(shared + own, further);
      raw.residual.segment(first, size) = block.rightCols<1>();
    }
  }
  return raw;
}

FitEquations with_basis(RawEquations raw) {
  for (Eigen::Index k = 0; k < raw.fitted.cols(); ++k) raw.fitted.col(k).normalize();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(raw.fitted);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(raw.residual.size(), qr.rank());
  basis = product(qr.householderQ(), basis);
  raw.residual -= basis * (basis.transpose() * raw.residual);
  return {raw.row_size, std::move(raw.rows), std::move(basis), std::move(raw.beside),
          std::move(raw.residual)};
}

}  // namespace

std::vector<int> agreeing_rows(const std::vector<int>& rows, const Eigen::MatrixXd& place,
                               const Eigen::VectorXd& residual) {
  constexpr int kSteps = 20;
  constexpr double kGross = 7;  // medians: five standard deviations
  constexpr double kSmallest = 1e-9;
  Eigen::VectorXd left = residual;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::VectorXd root = left.cwiseAbs().cwiseMax(kSmallest).cwiseSqrt().cwiseInverse();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * place);
    left = residual - place * qr.solve(Eigen::VectorXd(root.cwiseProduct(residual)));
  }
  const Eigen::VectorXd sizes = left.cwiseAbs();
  const double limit =
      kGross * std::max(kSmallest, median(std::vector<double>(sizes.begin(), sizes.end())));
  std::vector<int> chosen;
  for (size_t k = 0; k < rows.size(); ++k)
    if (sizes[static_cast<Eigen::Index>(k)] <= limit) chosen.push_back(rows[k]);
  return chosen;
}

namespace {

// An orthonormal basis of what the place of the board does to sound corners of an image.
struct ImageBasis {
  std::vector<int> sound;
  Eigen::MatrixXd columns;
};

// `first_place`: the column of the first number of the place of each contact that is a board.
RawEquations by_images(const RawEquations& of_rows, const PlainFit& fit,
                       const std::vector<int>& first_place, Eigen::Index further) {
  const std::vector<ContactPoint> matched = match_contacts(fit.readings, fit.result.robot.chain);
  RawEquations of_images{kParametersPerPose, {}, {}, {}, {}};
  std::vector<ImageBasis> bases;
  for (std::vector<int>& rows : rows_by_image(fit.readings)) {
    const int board = matched[fit.readings.touch[rows.front()].contact].board;
    const auto place = Eigen::seqN(first_place[board], kParametersPerPose);
    const std::vector<int> sound =
        agreeing_rows(rows, of_rows.beside(rows, place), of_rows.residual(rows));
    if (std::ssize(sound) < kParametersPerPose) continue;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(of_rows.beside(sound, place));
    bases.push_back({sound, first_columns(qr.householderQ(), kParametersPerPose)});
    of_images.rows.push_back(std::move(rows));
  }
  const Eigen::Index equations = kParametersPerPose * std::ssize(bases);
  of_images.fitted.resize(equations, of_rows.fitted.cols());
  of_images.beside.resize(equations, further);
  of_images.residual.resize(equations);
  Eigen::Index first = 0;
  for (const auto& [sound, columns] : bases) {
    const auto own = Eigen::seqN(first, kParametersPerPose);
    of_images.fitted(own, Eigen::all) = columns.transpose() * of_rows.fitted(sound, Eigen::all);
    of_images.beside(own, Eigen::all) =
        columns.transpose() * of_rows.beside(sound, Eigen::seqN(0, further));
    of_images.residual(own) = columns.transpose() * of_rows.residual(sound);
    first += kParametersPerPose;
  }
  return of_images;
}

}  // namespace

FitEquations fit_equations(const PlainFit& fit, const std::vector<int>& further_parameters) {
  return with_basis(raw_equations(fit, further_parameters));
}

Eigen::VectorXd like_changes(const PlainFit& fit, const std::vector<int>& parameters,
                             const Eigen::VectorXd& changes) {
  const RawEquations raw = raw_equations(fit, parameters);
  const Columns columns = columns_of(fit, parameters, rows_by_session(fit.readings).size() > 1);
  const Eigen::VectorXd length = raw.fitted.colwise().norm().cwiseMax(1e-300).transpose();
  const Eigen::MatrixXd unit = raw.fitted * length.cwiseInverse().asDiagonal();
  const Eigen::VectorXd moved = raw.beside * changes;
  const Eigen::VectorXd alike =
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(unit).solve(moved).cwiseQuotient(length);
  const std::vector<int>& kept = fit.result.set.kept;
  Eigen::VectorXd change = Eigen::VectorXd::Zero(std::ssize(kept));
  for (Eigen::Index k = 0; k < std::ssize(columns.shared); ++k)
    change[std::ranges::find(kept, columns.shared[k]) - kept.begin()] = alike[k];
  return change;
}

FitEquations reading_equations(const PlainFit& fit, const std::vector<int>& further_parameters) {
  if (!fit.readings.has_pixels_only()) return fit_equations(fit, further_parameters);
  const KinematicChain& chain = fit.result.robot.chain;
  const std::vector<Contact>& contacts = chain.contacts;
  std::vector<int> parameters = further_parameters, first_place(contacts.size());
  for (int contact = 0; contact < std::ssize(contacts); ++contact) {
    if (contacts[contact].kind != ContactKind::board) continue;
    first_place[contact] = static_cast<int>(parameters.size());
    for (int k = 0; k < kParametersPerPose; ++k)
      parameters.push_back(first_contact_parameter(chain) + kParametersOfContact * contact + k);
  }
  return with_basis(
      by_images(raw_equations(fit, parameters), fit, first_place, std::ssize(further_parameters)));
}

JointFit fit_beside(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& on_basis,
                    const Eigen::VectorXd& slope, const FitEquations& equations) {
  Eigen::MatrixXd beside = gram - on_basis.transpose() * on_basis;
  const Eigen::VectorXd unit = gram.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  beside = unit.asDiagonal() * beside * unit.asDiagonal();
  beside.diagonal().array() += 1e-9;  // what the others show as well takes no part
  const Eigen::VectorXd scaled = unit.asDiagonal() * slope;
  const Eigen::VectorXd value = Eigen::LDLT<Eigen::MatrixXd>(beside).solve(scaled);
  const double whole = std::max(1e-300, equations.residual.squaredNorm());
  return {std::min(1 - 1e-12, value.dot(scaled) / whole), unit.asDiagonal() * value};
}

Eigen::VectorXd times_of_rows(const Eigen::VectorXd& column, const Eigen::VectorXd& factors) {
  const Eigen::Index size = column.size() / factors.size();
  Eigen::VectorXd product = column;
  for (Eigen::Index row = 0; row < factors.size(); ++row)
    product.segment(row * size, size) *= factors[row];
  return product;
}

JointFit fit_beside(const Eigen::MatrixXd& columns, const FitEquations& equations) {
  return fit_beside(columns.transpose() * columns, equations.basis.transpose() * columns,
                    columns.transpose() * equations.residual, equations);
}

double fall_of_bic(const JointFit& joint, const FitEquations& equations, double poses,
                   double choices) {
  const double freedom = poses * equations.row_size - static_cast<double>(equations.basis.cols());
  const auto unknowns = static_cast<double>(joint.value.size());
  if (freedom <= unknowns) return 0;
  return -(freedom - unknowns) * std::log(1 - joint.share) - unknowns * std::log(freedom) -
         2 * std::log(choices);
}

namespace {

double median_norm(const Eigen::VectorXd& residual, int row_size) {
  std::vector<double> norms;
  for (Eigen::Index first = 0; first < residual.size(); first += row_size)
    norms.push_back(residual.segment(first, row_size).norm());
  return median(norms);
}

}  // namespace

bool is_of_most(const Eigen::VectorXd& explained, const FitEquations& equations) {
  constexpr double kNearer = 0.8;  // the median residual
  const Eigen::VectorXd left =
      equations.residual - explained + equations.basis * (equations.basis.transpose() * explained);
  return median_norm(left, equations.row_size) <
         kNearer * median_norm(equations.residual, equations.row_size);
}

namespace {

// A reading, and what of the squared residual falls without it.
struct TakenOut {
  int row = -1;
  double fall = 0;
};

TakenOut worst_reading(const FitEquations& equations) {
  constexpr double kLeastFreedom = 1e-6;  // of a number: one that alone shows something always fits
  const int size = equations.row_size;
  TakenOut worst;
  for (int row = 0; row * size < equations.residual.size(); ++row) {
    const Eigen::MatrixXd own = equations.basis.middleRows(row * size, size);
    const Eigen::LLT<Eigen::MatrixXd> freedom{
        Eigen::MatrixXd(Eigen::MatrixXd::Identity(size, size) - own * own.transpose())};
    if (freedom.info() != Eigen::Success ||
        freedom.matrixLLT().diagonal().minCoeff() < std::sqrt(kLeastFreedom))
      continue;
    const double fall =
        freedom.matrixL().solve(equations.residual.segment(row * size, size)).squaredNorm();
    if (fall > worst.fall) worst = {row, fall};
  }
  return worst;
}

// Adds the numbers of a reading to what is fitted, as unknowns of their own.
void leave_out(int row, FitEquations& equations) {
  const int size = equations.row_size;
  Eigen::MatrixXd own = -equations.basis * equations.basis.middleRows(row * size, size).transpose();
  own.middleRows(row * size, size) += Eigen::MatrixXd::Identity(size, size);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(own);
  own = first_columns(qr.householderQ(), size);
  equations.residual -= own * (own.transpose() * equations.residual);
  equations.basis.conservativeResize(Eigen::NoChange, equations.basis.cols() + size);
  equations.basis.rightCols(size) = own;
}

}  // namespace

Blunders find_blunders(const FitEquations& equations, double poses) {
  constexpr double kMostBlunders = 0.1;  // of the rows
  const double whole = equations.residual.squaredNorm();
  const double rows = static_cast<double>(equations.residual.size()) / equations.row_size;
  FitEquations left = equations;
  Blunders best, tried;
  double choices = 1;  // of so many among all
  for (int count = 1; count <= kMostBlunders * rows; ++count) {
    const TakenOut worst = worst_reading(left);
    if (worst.row < 0) break;
    leave_out(worst.row, left);
    std::ranges::copy(equations.rows[worst.row], std::back_inserter(tried.rows));
    choices *= (rows - count + 1) / count;
    const JointFit joint{std::min(1 - 1e-12, 1 - left.residual.squaredNorm() / whole),
                         Eigen::VectorXd::Zero(count * equations.row_size)};
    tried.score = fall_of_bic(joint, equations, poses, choices);
    if (tried.score <= best.score) break;
    best = tried;
  }
  std::ranges::sort(best.rows);
  return best;
}

}  // namespace armtrue
