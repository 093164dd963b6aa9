#include "calibration/columns_by_session.h"

#include <stdexcept>
#include <string>

#include "armtrue/calibration/observation.h"
#include "armtrue/kinematics/parameters.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr double kLeftOfColumn = 1e-6;

// `place`: among the own parameters of the session.
[[noreturn]] void fail_of_session(const SessionModels& models, const KinematicChain& chain,
                                  int session, Eigen::Index place) {
  const int parameter = models.own(session)[static_cast<size_t>(place)];
  const std::string readings = models.campaign().source + ": the readings of session '" +
                               models.name(session) + "' do not show ";
  if (parameter < kLinkParameters)
    throw std::invalid_argument(readings +
                                "where its instrument stood; measure more poses in it, or leave it "
                                "out");
  throw std::invalid_argument(
      readings + "its own " + parameter_name(chain, parameter) +
      ", which its own base can imitate; take it out of identify_per_session, or measure more "
      "poses in the session");
}

// (rows * row_size) x unknowns, at x = 0.
Eigen::MatrixXd derivatives_of(const ObservationModel& model) {
  const int size = model.row_size(), unknowns = model.unknowns();
  Eigen::MatrixXd blocks(model.rows() * size, unknowns + 1);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(unknowns));
  for_ordered_blocks<int>(
      model.rows(), kRowsPerBlock,
      [&](int begin, int end) {
        for (int row = begin; row < end; ++row) at.block(row, blocks.middleRows(row * size, size));
        return 0;
      },
      [](int) {});
  return blocks.leftCols(unknowns);
}

// Orthonormal.
Eigen::MatrixXd basis_of_own(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                             const SessionModels& models, const KinematicChain& chain,
                             int session) {
  Eigen::MatrixXd basis(columns.rows(), columns.cols());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    Eigen::VectorXd column = columns.col(k);
    for (int twice = 0; twice < 2; ++twice)  // the second time removes rounding errors
      remove_part(basis.leftCols(k), column);
    if (k >= columns.rows() || !is_independent(columns.col(k).norm(), column.norm()))
      fail_of_session(models, chain, session, k);
    basis.col(k) = column.normalized();
  }
  return basis;
}

}  // namespace

bool is_independent(double norm, double left) {
  return norm > 1e-12 && left > kLeftOfColumn * norm;
}

Eigen::VectorXd remove_part(const Eigen::Ref<const Eigen::MatrixXd>& basis,
                            Eigen::Ref<Eigen::VectorXd> column) {
  const Eigen::VectorXd part = basis.transpose() * column;
  column -= basis * part;
  return part;
}

ColumnsBySession::ColumnsBySession(const SessionModels& models, const KinematicChain& chain)
    : of_first_(Eigen::MatrixXd::Zero(models.rows() * models.row_size(),
                                      models.model(0).unknowns())) {
  Eigen::Index top = 0;
  for (int s = 0; s < models.sessions(); ++s) {
    const Eigen::MatrixXd derivatives = derivatives_of(models.model(s));
    int taken = 0;
    for (const SessionModels::Run& run : models.runs(s)) {
      const auto columns = derivatives.middleCols(taken, run.count);
      if (run.first < of_first_.cols())
        of_first_.block(top, run.first, derivatives.rows(), run.count) = columns;
      else
        own_.push_back({top, basis_of_own(columns, models, chain, s)});
      taken += run.count;
    }
    top += derivatives.rows();
  }
}

int ColumnsBySession::rank_of_own() const {
  Eigen::Index rank = 0;
  for (const Own& own : own_) rank += own.basis.cols();
  return static_cast<int>(rank);
}

void ColumnsBySession::remove_own(Eigen::Ref<Eigen::VectorXd> column) const {
  for (const Own& own : own_)
    remove_part(own.basis, column.segment(own.first_row, own.basis.rows()));
}

}  // namespace armtrue
