#include "armtrue/diagnosis/sensor_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "armtrue/campaign/selection.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/observation.h"
#include "armtrue/statistics/random.h"
#include "diagnosis/plain_fit.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

using Place = Eigen::Vector2d;  // within a sensor or on a board

// Terms of lower degrees move the image as a whole, or are those of focal lengths and centre.
constexpr int kFirstOfLens = 2;
constexpr int kHighestOfLens = 8, kLowestOfLens = 3, kHighestOfScanner = 3, kHighestOfBoard = 4;
constexpr int kDrawsOfSigns = 1999;
constexpr double kAsOthers = 1e-5;  // what others show as well, to this share, takes no part
constexpr double kMostChance = 1e-3;
constexpr double kShareThatStays = 0.25;
constexpr double kLeastSigma = 1e-7;  // m: what is left below it is rounding of the file

// Legendre polynomials of x up to this degree.
std::vector<double> legendre(double x, int degree) {
  std::vector<double> p{1, x};
  for (int n = 1; n < degree; ++n) p.push_back(((2 * n + 1) * x * p[n] - n * p[n - 1]) / (n + 1));
  return p;
}

// Products of Legendre polynomials of both coordinates, by their degrees in sum.
std::vector<double> products(const Place& place, int lowest, int highest) {
  const std::vector<double> s = legendre(place.x(), highest), t = legendre(place.y(), highest);
  std::vector<double> values;
  for (int degree = lowest; degree <= highest; ++degree)
    for (int k = 0; k <= degree; ++k) values.push_back(s[degree - k] * t[k]);
  return values;
}

// Columns: those of the terms up to a degree, lower degrees first. Rows: of both coordinates.
Eigen::MatrixXd of_each_coordinate(const std::vector<double>& values, int coordinates) {
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(coordinates, coordinates * std::ssize(values));
  for (int k = 0; k < std::ssize(values); ++k)
    for (int i = 0; i < coordinates; ++i) terms(i, coordinates * k + i) = values[k];
  return terms;
}

// Of degree 1 y depends on z (the axes are not square) and on y (the scale along the line differs
// from that across it), both about the origin, where the sensor is: the rest turns the sensor or
// scales the arm.
int count_of_scanner(int degree) { return 2 + 2 * ((degree + 1) * (degree + 2) / 2 - 3); }

Eigen::MatrixXd terms_of(const SensorField& field, const Place& place) {
  const Place scaled = (place - field.middle).cwiseQuotient(field.half);
  if (field.camera >= 0) return of_each_coordinate(products(scaled, kFirstOfLens, field.degree), 2);
  Eigen::MatrixXd terms(2, count_of_scanner(field.degree));
  terms.leftCols<2>() << place.y() / field.half.y(), place.x() / field.half.x(), 0, 0;
  if (field.degree > 1)
    terms.rightCols(terms.cols() - 2) = of_each_coordinate(products(scaled, 2, field.degree), 2);
  return terms;
}

SensorField field_over(int camera, const std::vector<Place>& places, int degree) {
  Place low = places.front(), high = low;
  for (const Place& place : places) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  return {camera, (low + high) / 2, ((high - low) / 2).cwiseMax(1e-12), degree, {}};
}

// The whitened residual of readings, the columns of a polynomial, and those of all else.
struct Equations {
  std::vector<int> cluster;  // of each row its pose
  Eigen::MatrixXd columns, others;
  Eigen::VectorXd residual;
  Eigen::VectorXd squares;   // of the columns before anything was taken off them
  double taken = 0;          // numbers that others have taken up before
  std::vector<int> choices;  // number of columns of each degree that is tried
};

struct Evidence {
  double score = 0, p = 1, share = 0;
  int choice = 0;
  Eigen::VectorXd value, explained;
};

// (I - Q Q^T)^(-1/2) r of a cluster with the rows Q of an orthonormal basis: its residual has then
// the covariance of its errors (Bell, McCaffrey 2002).
Eigen::VectorXd without_leverage(const Eigen::MatrixXd& basis, const Eigen::VectorXd& residual) {
  constexpr double kLeast = 1e-12, kMost = 1 - 1e-6;
  if (basis.cols() == 0) return residual;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
      Eigen::MatrixXd(basis.transpose() * basis)};
  Eigen::VectorXd factor = eigen.eigenvalues();
  for (double& value : factor) {
    const double leverage = std::min(value, kMost);
    value = leverage < kLeast ? 0.0 : (1 / std::sqrt(1 - leverage) - 1) / leverage;
  }
  const Eigen::VectorXd on_basis = basis.transpose() * residual;
  const Eigen::VectorXd along = eigen.eigenvectors().transpose() * on_basis;
  return residual + basis * (eigen.eigenvectors() * factor.cwiseProduct(along));
}

class Test {
 public:
  explicit Test(const Equations& equations) : equations_(equations) {
    basis_ = Eigen::MatrixXd(equations.others.rows(), 0);
    if (equations.others.cols() > 0) {
      const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(equations.others);
      basis_ = first_columns(qr.householderQ(), qr.rank());
    }
    residual_ = equations.residual - basis_ * (basis_.transpose() * equations.residual);
    columns_ = equations.columns;
    scale_ = equations.squares.cwiseSqrt().cwiseMax(1e-300);
    columns_ -= basis_ * (basis_.transpose() * columns_);
    columns_ = columns_ * scale_.cwiseInverse().asDiagonal();
    Eigen::MatrixXd gram = columns_.transpose() * columns_;
    gram.diagonal().array() += kAsOthers;
    root_ = Eigen::LLT<Eigen::MatrixXd>(gram);
  }

  Evidence evidence() const {
    const Eigen::VectorXd slope = columns_.transpose() * residual_;
    Evidence found = best(slope, residual_.squaredNorm());
    const int count = equations_.choices[found.choice];
    const auto part = root_.matrixLLT().topLeftCorner(count, count);
    Eigen::VectorXd value = part.triangularView<Eigen::Lower>().solve(slope.head(count));
    value = part.transpose().triangularView<Eigen::Upper>().solve(value);
    found.explained = columns_.leftCols(count) * value;
    found.value = value.cwiseQuotient(scale_.head(count));
    if (found.score > kClearFall) found.p = chance_of(found.score);
    return found;
  }

 private:
  // The degree with the largest fall of BIC.
  Evidence best(const Eigen::VectorXd& slope, double whole) const {
    const Eigen::VectorXd along = root_.matrixL().solve(slope);
    const double freedom = static_cast<double>(residual_.size()) - equations_.taken -
                           static_cast<double>(basis_.cols());
    Evidence found{-1e300};
    for (int choice = 0; choice < std::ssize(equations_.choices); ++choice) {
      const int count = equations_.choices[choice];
      if (freedom <= count) break;
      const double share = std::min(1 - 1e-12, along.head(count).squaredNorm() / whole);
      const double score = -(freedom - count) * std::log(1 - share) - count * std::log(freedom);
      if (score <= found.score) continue;
      found.score = score;
      found.share = share;
      found.choice = choice;
    }
    return found;
  }

  double chance_of(double score) const {
    std::map<int, std::vector<int>> rows;
    for (int row = 0; row < std::ssize(equations_.cluster); ++row)
      rows[equations_.cluster[row]].push_back(row);
    std::vector<Eigen::VectorXd> slopes, on_basis;
    double whole = 0;
    for (const auto& [cluster, own] : rows) {
      const Eigen::MatrixXd basis = basis_(own, Eigen::all);
      const Eigen::VectorXd residual = without_leverage(basis, residual_(own));
      slopes.push_back(columns_(own, Eigen::all).transpose() * residual);
      on_basis.push_back(basis.transpose() * residual);
      whole += residual.squaredNorm();
    }
    Random random(1);
    int as_large = 0;
    for (int draw = 0; draw < kDrawsOfSigns; ++draw) {
      Eigen::VectorXd slope = Eigen::VectorXd::Zero(columns_.cols());
      Eigen::VectorXd taken = Eigen::VectorXd::Zero(basis_.cols());
      for (size_t k = 0; k < slopes.size(); ++k) {
        const double sign = random.next() % 2 == 0 ? 1 : -1;
        slope += sign * slopes[k];
        taken += sign * on_basis[k];
      }
      if (best(slope, std::max(1e-300, whole - taken.squaredNorm())).score >= score) ++as_large;
    }
    return (1.0 + as_large) / (1 + kDrawsOfSigns);
  }

  const Equations& equations_;
  Eigen::MatrixXd basis_, columns_;
  Eigen::VectorXd residual_, scale_;
  Eigen::LLT<Eigen::MatrixXd> root_;
};

bool is_no_chance(const Evidence& found) {
  return found.score > kClearFall && found.p <= kMostChance;
}

// A row of an image, and where its corner lies.
struct Corner {
  int row, axis;
  Place pixel, on_board;
  int board;
};

// Images of one camera; all that moves the board before the camera is taken off each image.
struct CameraEquations {
  Equations of_lens, of_board;
  Equations of_held;            // columns: the numbers of the lens that the fit has not identified
  std::vector<Corner> corners;  // of each row
  Eigen::MatrixXd columns;      // those of the lens as they are
  SensorField field;
};

// The corners of one image of which both numbers were read.
std::vector<Corner> corners_of(const Campaign& campaign, const std::vector<ContactPoint>& matched,
                               const KinematicChain& chain, const std::vector<int>& image) {
  std::map<int, std::array<int, 2>> rows;  // of each corner
  for (int row : image)
    rows.try_emplace(campaign.touch[row].contact, std::array{-1, -1})
        .first->second[campaign.touch[row].axis] = row;
  std::vector<Corner> corners;
  for (const auto& [contact, pair] : rows) {
    if (pair[0] < 0 || pair[1] < 0) continue;
    const ContactPoint& seen = matched[contact];
    const Place pixel =
        Place(campaign.distance[pair[0]], campaign.distance[pair[1]]) / campaign.metre_per_pixel;
    const Place on_board = chain.contacts[seen.board].points[seen.point].position.head<2>();
    for (int axis : {0, 1}) corners.push_back({pair[axis], axis, pixel, on_board, seen.board});
  }
  return corners;
}

std::vector<int> counts(int lowest, int highest, const auto& count_of) {
  std::vector<int> all;
  for (int degree = lowest; degree <= highest; ++degree) all.push_back(count_of(degree));
  return all;
}

void append_rows(Eigen::MatrixXd& all, const Eigen::MatrixXd& rows) {
  all.conservativeResize(all.rows() + rows.rows(), rows.cols());
  all.bottomRows(rows.rows()) = rows;
}

void append(Equations& equations, int cluster, const Eigen::MatrixXd& place,
            const Eigen::MatrixXd& columns, const Eigen::MatrixXd& others,
            const Eigen::VectorXd& residual) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(place);
  const Eigen::MatrixXd basis = first_columns(qr.householderQ(), place.cols());
  const auto beside = [&](const Eigen::MatrixXd& of) -> Eigen::MatrixXd {
    return of - basis * (basis.transpose() * of);
  };
  const Eigen::VectorXd squares = columns.colwise().squaredNorm();
  if (equations.squares.size() == 0)
    equations.squares = squares;
  else
    equations.squares += squares;
  append_rows(equations.columns, beside(columns));
  append_rows(equations.others, beside(others));
  const Eigen::Index before = equations.residual.size();
  equations.residual.conservativeResize(before + residual.size());
  equations.residual.tail(residual.size()) = beside(residual);
  equations.cluster.insert(equations.cluster.end(), residual.size(), cluster);
  equations.taken += static_cast<double>(place.cols());
}

// The images of one camera, and where in them and on their boards the corners lie.
struct CameraImages {
  std::vector<std::vector<Corner>> corners;  // of each image
  std::vector<Place> pixels, on_board;
  std::set<int> boards;
};

CameraImages images_of_camera(const PlainFit& fit, int camera) {
  const Campaign& campaign = fit.readings;
  const KinematicChain& chain = fit.result.robot.chain;
  const std::vector<ContactPoint> matched = match_contacts(campaign, chain);
  CameraImages images;
  for (const std::vector<int>& image : rows_by_image(campaign)) {
    if (matched[campaign.touch[image.front()].contact].contact != camera) continue;
    images.corners.push_back(corners_of(campaign, matched, chain, image));
    for (const Corner& corner : images.corners.back()) {
      images.pixels.push_back(corner.pixel);
      images.on_board.push_back(corner.on_board);
      images.boards.insert(corner.board);
    }
  }
  std::erase_if(images.corners, [](const std::vector<Corner>& image) { return image.empty(); });
  return images;
}

// The columns of a camera: those of the places of its boards, then of the numbers of its lens.
struct CameraColumns {
  std::vector<int> parameters;
  std::map<int, int> place_of;        // first column of each board
  int lens = 0;                       // first column of the lens
  std::vector<int> held, identified;  // of those of the lens
};

CameraColumns columns_of_camera(const PlainFit& fit, int camera, const std::set<int>& boards) {
  const KinematicChain& chain = fit.result.robot.chain;
  const int first = first_contact_parameter(chain);
  CameraColumns columns;
  for (const int board : boards) {
    columns.place_of[board] = static_cast<int>(columns.parameters.size());
    for (int k = 0; k < kParametersPerPose; ++k)
      columns.parameters.push_back(first + kParametersOfContact * board + k);
  }
  columns.lens = static_cast<int>(columns.parameters.size());
  const std::vector<int>& kept = fit.result.set.kept;
  for (const int k : parameters_of_contact(chain.contacts[camera])) {
    if (k < kFirstIntrinsic) continue;
    const int parameter = first + kParametersOfContact * camera + k;
    const bool is_held = std::ranges::find(kept, parameter) == kept.end();
    (is_held ? columns.held : columns.identified)
        .push_back(static_cast<int>(columns.parameters.size()));
    columns.parameters.push_back(parameter);
  }
  return columns;
}

// The whitened equations of the corners of one image, residual last, and by how much a pixel more
// changes each residual.
struct ImageEquations {
  Eigen::MatrixXd all;
  Eigen::VectorXd of_pixel;
};

ImageEquations equations_of_image(const std::vector<Corner>& corners, const ObservationModel& model,
                                  const ObservationModel::At& at) {
  const double metre_per_pixel = model.campaign().metre_per_pixel;
  Eigen::MatrixXd block(1, model.unknowns() + 1);
  ImageEquations image{Eigen::MatrixXd(std::ssize(corners), block.cols()),
                       Eigen::VectorXd(std::ssize(corners))};
  for (int k = 0; k < std::ssize(corners); ++k) {
    at.block(corners[k].row, block);
    image.all.row(k) = block;
    image.of_pixel[k] = model.whitened(corners[k].row, {metre_per_pixel, 0, 0, 0, 0, 0})[0];
  }
  return image;
}

// Adds an image without the corners that contradict the others.
void add_image(std::vector<Corner> corners, int pose, const ImageEquations& image,
               const CameraColumns& columns, const SensorField& board_field,
               CameraEquations& found) {
  const auto& [all, of_pixel] = image;
  // The place as the model has it: noise of a pixel would move its own column with its residual.
  for (Corner& corner : corners) {
    const auto first_row = (&corner - corners.data()) / 2 * 2;
    for (int axis : {0, 1})
      corner.pixel[axis] -= all(first_row + axis, Eigen::last) / of_pixel[first_row + axis];
  }
  const auto place = Eigen::seqN(columns.place_of.at(corners.front().board), kParametersPerPose);
  std::vector<int> numbers(corners.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  const std::vector<int> sound = agreeing_rows(numbers, all(Eigen::all, place), all.rightCols<1>());
  if (std::ssize(sound) <= kParametersPerPose) return;
  Eigen::MatrixXd of_lens(std::ssize(sound), found.of_lens.choices.back());
  Eigen::MatrixXd of_board(std::ssize(sound), found.of_board.choices.back());
  for (int k = 0; k < std::ssize(sound); ++k) {
    const Corner& corner = corners[sound[k]];
    of_lens.row(k) = of_pixel[sound[k]] * terms_of(found.field, corner.pixel).row(corner.axis);
    const Place scaled = (corner.on_board - board_field.middle).cwiseQuotient(board_field.half);
    of_board.row(k) = all.row(sound[k]).segment<3>(place.first()) *
                      of_each_coordinate(products(scaled, 1, kHighestOfBoard), 3);
    found.corners.push_back(corner);
  }
  const Eigen::MatrixXd of_place = all(sound, place),
                        of_camera = all(sound, Eigen::seq(columns.lens, Eigen::last - 1));
  const Eigen::VectorXd residual = all(sound, Eigen::last);
  append_rows(found.columns, of_lens);
  append(found.of_lens, pose, of_place, of_lens, of_camera, residual);
  append(found.of_board, pose, of_place, of_board, of_camera, residual);
  append(found.of_held, pose, of_place, all(sound, columns.held), all(sound, columns.identified),
         residual);
}

std::optional<CameraEquations> equations_of_camera(const PlainFit& fit, int camera) {
  const CameraImages images = images_of_camera(fit, camera);
  if (images.pixels.empty()) return std::nullopt;
  const CameraColumns columns = columns_of_camera(fit, camera, images.boards);
  CameraEquations found;
  found.field = field_over(camera, images.pixels, kHighestOfLens);
  const SensorField board_field = field_over(0, images.on_board, kHighestOfBoard);
  found.of_lens.choices = counts(kLowestOfLens, kHighestOfLens, [](int d) {
    return (d + 1) * (d + 2) - kFirstOfLens * (kFirstOfLens + 1);
  });
  // Shifts and turns of the board are taken off with its place, and its scale is that of the arm.
  found.of_board.choices =
      counts(1, kHighestOfBoard, [](int d) { return 3 * ((d + 1) * (d + 2) / 2 - 1); });
  found.of_held.choices = {static_cast<int>(columns.held.size())};
  const ObservationModel model(fit.readings, fit.result.robot, columns.parameters, fit.result.sigma,
                               0);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  for (const std::vector<Corner>& corners : images.corners)
    add_image(corners, fit.readings.pose[corners.front().row],
              equations_of_image(corners, model, at), columns, board_field, found);
  if (found.corners.empty()) return std::nullopt;
  return found;
}

Equations equations_of_scanner(const PlainFit& fit, SensorField& field) {
  constexpr double kStep = 1e-6;  // m
  const Campaign& readings = fit.readings;
  std::vector<Place> places;
  for (const ProfilePoint& point : readings.profile) places.emplace_back(point.y, point.z);
  field = field_over(-1, places, kHighestOfScanner);
  Campaign by_y = readings, by_z = readings;
  for (int row = 0; row < readings.rows(); ++row) {
    by_y.profile[row].y += kStep;
    by_z.profile[row].z += kStep;
  }
  const FitEquations fitted = fit_equations(fit, {});
  Equations equations;
  equations.cluster = readings.pose;
  equations.others = fitted.basis;
  equations.residual = fitted.residual;
  equations.choices = counts(1, kHighestOfScanner, count_of_scanner);
  equations.columns.resize(readings.rows(), equations.choices.back());
  const auto model_of = [&](const Campaign& of) {
    return ObservationModel(of, fit.result.robot, {}, fit.result.sigma, 0);
  };
  const ObservationModel here = model_of(readings), beside_y = model_of(by_y),
                         beside_z = model_of(by_z);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(here.unknowns());
  const auto at = here.at(zero), at_y = beside_y.at(zero), at_z = beside_z.at(zero);
  for (int row = 0; row < readings.rows(); ++row) {
    const auto slope = [&](const ObservationModel::At& moved) {
      return here.whitened(row, (moved.residual(row) - at.residual(row)) / kStep)[0];
    };
    equations.columns.row(row) =
        Eigen::RowVector2d(slope(at_y), slope(at_z)) * terms_of(field, places[row]);
  }
  equations.squares = equations.columns.colwise().squaredNorm();
  return equations;
}

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() /
                   static_cast<double>(std::max<Eigen::Index>(1, values.size())));
}

// What one round found of one sensor.
struct Found {
  SensorField field;
  double share = 0, spread = 0;  // spread: of the fit [m]
  std::string size, board;       // size in words; the board's name if that is where the error is
};

// The values of a field of all degrees beside all unknowns of the fit: images differ in
// what they take for a motion of the board. The prior deviation of each value is some times the RMS
// of what was found [px].
Eigen::VectorXd values_beside_fit(const PlainFit& fit, const CameraEquations& equations,
                                  double found) {
  constexpr double kTimesFound = 3;
  std::vector<int> rows;
  for (const Corner& corner : equations.corners) rows.push_back(corner.row);
  const FitEquations fitted = fit_equations(fit, {});
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fitted.basis(rows, Eigen::all));
  const Eigen::MatrixXd basis = first_columns(qr.householderQ(), qr.rank());
  Eigen::MatrixXd columns = equations.columns;
  columns -= basis * (basis.transpose() * columns);
  Eigen::MatrixXd information = columns.transpose() * columns;
  information.diagonal().array() += 1 / (kTimesFound * kTimesFound * found * found);
  const Eigen::VectorXd slope = columns.transpose() * fitted.residual(rows);
  return Eigen::LLT<Eigen::MatrixXd>(information).solve(slope);
}

std::optional<Found> error_of_camera(const Robot& robot, const PlainFit& fit, int camera) {
  auto equations = equations_of_camera(fit, camera);
  if (!equations) return std::nullopt;
  const Evidence lens = Test(equations->of_lens).evidence();
  const Evidence board = Test(equations->of_board).evidence();
  const bool is_of_board = is_no_chance(board) && board.score > lens.score;
  const Evidence& best = is_of_board ? board : lens;
  if (!is_no_chance(best)) return std::nullopt;
  const double sigma = fit.result.sigma.position / fit.readings.metre_per_pixel;
  Found found{equations->field, best.share, fit.result.spread.position};
  found.size = fmt::format(
      "{:.2g} px (RMS per axis beside what the numbers of the lens and the arm "
      "can do, {:.2g} mm at the board)",
      rms(best.explained) * sigma, rms(best.explained) * fit.result.sigma.position / kMillimetre);
  if (is_of_board) {
    found.board = robot.chain.contacts[equations->corners.front().board].name;
    return found;
  }
  found.field.values = values_beside_fit(fit, *equations, rms(lens.explained) * sigma);
  return found;
}

std::optional<Found> error_of_scanner(const PlainFit& fit) {
  SensorField field;
  const Equations equations = equations_of_scanner(fit, field);
  const Evidence found = Test(equations).evidence();
  if (!is_no_chance(found)) return std::nullopt;
  field.degree = 1 + found.choice;
  field.values = found.value;
  return Found{field, found.share, fit.result.spread.position,
               fmt::format("{:.2g} mm (RMS, off the surface)",
                           rms(found.explained) * fit.result.sigma.position / kMillimetre)};
}

// A camera of which numbers are not identified, though its images show other ones.
std::optional<Found> wrong_numbers_of_camera(const PlainFit& fit, int camera) {
  const auto equations = equations_of_camera(fit, camera);
  if (!equations || equations->of_held.choices.front() == 0) return std::nullopt;
  const Evidence held = Test(equations->of_held).evidence();
  if (!is_no_chance(held)) return std::nullopt;
  Found found{equations->field, held.share, fit.result.spread.position};
  found.size = fmt::format(
      "{:.2g} px", rms(held.explained) * fit.result.sigma.position / fit.readings.metre_per_pixel);
  return found;
}

std::vector<Found> errors_of(const Robot& robot, const PlainFit& fit) {
  std::vector<Found> all;
  const auto add = [&](const std::optional<Found>& found) {
    if (found) all.push_back(*found);
  };
  if (fit.readings.has_profiles()) {
    add(error_of_scanner(fit));
    return all;
  }
  const std::vector<Contact>& contacts = robot.chain.contacts;
  for (int camera = 0; camera < std::ssize(contacts); ++camera)
    if (contacts[camera].kind == ContactKind::camera) add(error_of_camera(robot, fit, camera));
  return all;
}

// Whether the other model of a lens fits about as well, and nothing speaks against it.
bool fits_with_other_lens(const Robot& robot, const Campaign& campaign, const Found& found) {
  constexpr double kAlike = 1.2;
  Robot other = robot;
  Contact& camera = other.chain.contacts[found.field.camera];
  camera.lens = camera.lens == Lens::pinhole ? Lens::fisheye : Lens::pinhole;
  camera.intrinsics.tail<kIntrinsics - kK1>().setZero();
  const auto fit = fit_plainly(other, campaign);
  if (!fit) return false;
  const auto left = error_of_camera(other, *fit, found.field.camera);
  return !left && fit->result.spread.position < kAlike * found.spread;
}

std::string in_words(const Robot& robot, const Campaign& campaign, const Found& found) {
  const SensorField& field = found.field;
  if (field.camera < 0) {
    const double shear = field.values[0] / field.half.y(), scale = field.values[1] / field.half.x();
    return fmt::format(
        "the residuals depend on where in the profile a point lies, by {} (p < 0.001): the axes of "
        "the scanner are off a right angle by {:.2g} deg, and the scale of y is {:.2g} % {} than "
        "that of z{}; calibrate and close-loop take this off the readings; correct the export or "
        "the calibration of the sensor",
        found.size, std::abs(shear) / kDegree, 100 * std::abs(scale), scale > 0 ? "more" : "less",
        field.degree > 1 ? ", and straight lines are read bent" : "");
  }
  const Contact& camera = robot.chain.contacts[field.camera];
  const bool is_pinhole = camera.lens == Lens::pinhole;
  if (!found.board.empty())
    return fmt::format(
        "the residuals of camera '{}' depend on where on the board '{}' a corner lies, by {} (p < "
        "0.001): the board is not flat, or its pitch is not that of the robot file; measure the "
        "board, or use one on glass or metal",
        camera.name, found.board, found.size);
  return fmt::format(
      "the residuals of camera '{}' depend on where in the image a corner lies, by {} (p < 0.001): "
      "its lens is not the {} of the robot file; {}; calibrate and close-loop take it off the "
      "readings as a polynomial of degree {} of the place",
      camera.name, found.size, is_pinhole ? "pinhole" : "fisheye",
      fits_with_other_lens(robot, campaign, found)
          ? fmt::format("`lens: {}` fits, state it", is_pinhole ? "fisheye" : "pinhole")
          : "state the numbers of a calibrated lens, or use corners in the middle of the image",
      field.degree);
}

// Adds the cameras whose numbers are held, though the images show other ones: their places, and
// what else is identified, would take up the difference.
void add_wrong_numbers(const Robot& robot, const Campaign& campaign, SensorError& error) {
  if (!campaign.has_pixels_only() || robot.identify == std::vector<std::string>{"auto"}) return;
  const auto fit = fit_as_asked(robot, campaign);
  if (!fit || fit->result.sigma.position < kLeastSigma) return;
  for (int camera = 0; camera < std::ssize(robot.chain.contacts); ++camera) {
    if (robot.chain.contacts[camera].kind != ContactKind::camera) continue;
    const auto found = wrong_numbers_of_camera(*fit, camera);
    if (!found) continue;
    error.is_left |= found->share > kShareThatStays;
    error.words += fmt::format(
        "{}the lens of camera '{}' is not that of the robot file: its numbers, which are held, "
        "miss the images by {} (RMS per axis, p < 0.001), and the place of the camera takes up a "
        "part of it; identify them, such as --identify \"{},camera {}.*\", or state those of a "
        "calibrated lens",
        error.words.empty() ? "" : "; ", robot.chain.contacts[camera].name, found->size,
        fmt::join(robot.identify, ","), robot.chain.contacts[camera].name);
  }
}

}  // namespace

void SensorError::take_off(Campaign& campaign, const KinematicChain& chain) const {
  if (fields.empty()) return;
  const std::vector<ContactPoint> matched =
      campaign.has_pixels() ? match_contacts(campaign, chain) : std::vector<ContactPoint>();
  for (const SensorField& field : fields) {
    if (field.camera < 0) {
      for (ProfilePoint& point : campaign.profile) {
        const Place off = terms_of(field, {point.y, point.z}) * field.values;
        point.y -= off.x();
        point.z -= off.y();
      }
      continue;
    }
    for (const std::vector<int>& image : rows_by_image(campaign))
      for (const Corner& corner : corners_of(campaign, matched, chain, image))
        if (matched[campaign.touch[corner.row].contact].contact == field.camera)
          campaign.distance[corner.row] -=
              campaign.metre_per_pixel *
              (terms_of(field, corner.pixel).row(corner.axis) * field.values)[0];
  }
}

SensorError find_sensor_error(const Robot& robot, const Campaign& campaign) {
  constexpr int kRounds = 5;
  constexpr double kLeastGain = 0.99;
  SensorError error;
  if (!campaign.has_pixels_only() && !campaign.has_profiles()) return error;
  Campaign without = campaign;
  double left = std::numeric_limits<double>::infinity(), share = 0;
  std::vector<SensorField> last;
  std::map<int, Found> first;  // of each sensor, what the first round found
  for (int round = 0; round < kRounds; ++round) {
    const auto fit = fit_plainly(robot, without);
    if (!fit || fit->result.sigma.position < kLeastSigma) break;
    if (fit->result.sigma.position > kLeastGain * left) {
      if (fit->result.sigma.position > left) error.fields = last;
      error.is_left = share > kShareThatStays;
      break;
    }
    left = fit->result.sigma.position;
    last = error.fields;
    const std::vector<Found> found = errors_of(robot, *fit);
    share = 0;
    SensorError next;
    for (const Found& one : found) {
      first.try_emplace(one.field.camera, one);
      share = std::max(share, one.share);
      if (round + 1 == kRounds || !one.board.empty())
        error.is_left |= one.share > kShareThatStays;
      else
        next.fields.push_back(one.field);
    }
    if (next.fields.empty()) break;
    next.take_off(without, robot.chain);
    error.fields.insert(error.fields.end(), next.fields.begin(), next.fields.end());
  }
  std::vector<std::string> sentences;
  for (const auto& [camera, found] : first) sentences.push_back(in_words(robot, campaign, found));
  error.words = fmt::format("{}", fmt::join(sentences, "; "));
  if (error.is_left) error.words += "; the arm takes up what remains of it";
  add_wrong_numbers(robot, campaign, error);
  return error;
}

}  // namespace armtrue
