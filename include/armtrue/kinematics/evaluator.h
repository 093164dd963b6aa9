#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <span>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// Derivative of the pose with respect to each geometric parameter, in the axes of R_A.
/// Column k belongs to the parameter of index k (see parameters.h).
/// Rows 0-2: derivative of the translation [m per unit of the parameter].
/// Rows 3-5: derivative of the rotation vector dr of the left perturbation R <- exp([dr]x) R
/// [rad per unit of the parameter].
using PoseJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxGeometricParameters>;

/// The Jacobians of up to four poses, interleaved for SIMD lanes: entry (row, column) of one pose
/// stands beside that of the next. A copy into a matrix for each pose takes as long as the
/// computation.
class LaneJacobians {
 public:
  static constexpr int kCount = 4;
  using OfPose = Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic>, Eigen::Unaligned,
                            Eigen::Stride<6 * kCount, kCount>>;

  /// The Jacobian of one pose, to read and to change.
  OfPose operator[](size_t lane) { return {entries_.data() + lane, 6, columns_}; }
  Eigen::Index columns() const { return columns_; }
  void set_columns(Eigen::Index columns) { columns_ = columns; }
  /// The entries (row, column) of all poses.
  double* entries(int row, int column) { return entries_.data() + kCount * (6 * column + row); }

 private:
  Eigen::Index columns_ = 0;
  alignas(kCount *
          sizeof(double)) std::array<double, kCount * 6 * kMaxGeometricParameters> entries_;
};

/// Some columns of a Jacobian.
using ColumnSet = std::bitset<kMaxGeometricParameters>;

/// Difference of each geometric parameter from its constant value for one reading [m, rad].
using ParameterOffsets = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxGeometricParameters, 1>;

/// Frames of the links in one posture, R_0 from R_1 ... R_n.
class LinkFrames {
 public:
  LinkFrames() = default;
  explicit LinkFrames(int count) : count_(count) {}

  size_t size() const { return count_; }
  Pose& operator[](size_t link) { return frames_[link]; }
  const Pose& operator[](size_t link) const { return frames_[link]; }
  const Pose& back() const { return frames_[count_ - 1]; }
  const Pose* begin() const { return frames_.data(); }
  const Pose* end() const { return frames_.data() + count_; }

 private:
  std::array<Pose, kMaxLinks> frames_;
  size_t count_ = 0;
};

/// Computes the forward kinematics of one chain for many poses. The constructor computes sine and
/// cosine of the constant angles once. Each call makes one pass over the chain and does not
/// allocate.
class ChainEvaluator {
 public:
  /// Throws std::invalid_argument if the chain is longer than kMaxLinks or kMaxJoints.
  explicit ChainEvaluator(const KinematicChain& chain);

  /// Returns R_A_from_measured; q are encoder values [rad or m], one per driven joint. `offsets`
  /// are added to the constants.
  Pose pose(const JointVector& q) const;
  Pose pose(const JointVector& q, const ParameterOffsets& offsets) const;

  /// Returns R_A_from_measured and writes its derivative to `jacobian`.
  Pose pose(const JointVector& q, PoseJacobian& jacobian) const;
  Pose pose(const JointVector& q, const ParameterOffsets& offsets, PoseJacobian& jacobian) const;

  /// The same for many q, four at a time in SIMD lanes. `offsets` is empty or holds one for each q.
  /// Each pose equals pose() but for rounding, since the lanes have sines of their own
  /// (src/kinematics/lanes.h), and does not depend on the others.
  void poses(std::span<const JointVector> q, std::span<const ParameterOffsets> offsets,
             std::span<Pose> a_from_measured) const;
  /// `jacobians`: one for every four q, the last for those that are left. Only `columns` are
  /// written; the others are undefined.
  void poses(std::span<const JointVector> q, std::span<const ParameterOffsets> offsets,
             std::span<Pose> a_from_measured, std::span<LaneJacobians> jacobians,
             const ColumnSet& columns = ColumnSet().set()) const;

  /// Whether the chain is the usual arm, see chain.h.
  bool is_six_axis_arm() const { return is_six_axis_arm_; }

  /// Returns R_0_from_R_j of every link.
  LinkFrames link_frames(const JointVector& q) const;

 private:
  struct Trigonometry {
    double cos_alpha, sin_alpha, cos_beta, sin_beta;
    double alpha, d, theta, r, beta, sign;
    int joint;    // -1: without encoder
    bool slides;  // prismatic
    bool moves;   // with an encoder or others
    int zero;     // parameter to which the joint adds
  };
  // A coupling with the number of its coefficient among the parameters.
  struct BoundCoupling : Coupling {
    int parameter = 0;
  };
  // Of each link what its joint adds to its constant, and of each coupling what the derivatives
  // need.
  template <typename Number>
  struct Motions {
    std::array<Number, kMaxLinks> of_link;
    std::array<Number, kMaxCouplings> of_followed;  // value of the joint that is followed
    std::array<Number, kMaxCouplings> factor;  // of the follower's motion by that of the followed
  };
  template <bool kWithOffsets, typename Number, typename Encoder, typename Offset>
  void find_motions(const Encoder& encoder, const Offset& offset, Motions<Number>& motions) const;
  // Moves `frame` from R_0 to the last link; see pass_along(). Sets `motions` unless kFixedCount is
  // above zero.
  template <bool kWithOffsets, bool kWithJacobian, int kFixedCount, typename Number,
            typename Encoder, typename Offset, typename Frame, typename Axes>
  void move_along(const Encoder& encoder, const Offset& offset, Motions<Number>& motions,
                  Frame& frame, Axes& axes) const;
  // Adds to the columns of followed joints those of their followers, and sets those of
  // coefficients. `column(parameter)` gives six Numbers to read and write.
  template <typename Number, typename Column>
  void follow(const Motions<Number>& motions, const Column& column) const;
  // The columns that these are made of.
  ColumnSet with_followers(ColumnSet columns) const;

  // kFixedCount: number of the links, if known when compiled and no joint follows another;
  // otherwise 0.
  template <bool kWithOffsets, bool kWithJacobian, int kFixedCount>
  Pose evaluate(const JointVector& q, const ParameterOffsets* offsets,
                PoseJacobian* jacobian) const;
  template <bool kWithOffsets, bool kWithJacobian>
  Pose dispatch(const JointVector& q, const ParameterOffsets* offsets,
                PoseJacobian* jacobian) const;
  // A pose for each lane.
  template <bool kWithOffsets, bool kWithJacobian, int kFixedCount>
  void evaluate_lanes(std::span<const JointVector> q, std::span<const ParameterOffsets> offsets,
                      std::span<Pose> a_from_measured, LaneJacobians* jacobians,
                      const ColumnSet& columns) const;

  Pose base_, tool_;
  std::array<Trigonometry, kMaxLinks> links_;
  int count_ = 0;                         // of the links
  std::vector<BoundCoupling> couplings_;  // in the order of coupling_order()
  bool is_six_axis_arm_ = false;
};

/// Derivative of the pose with respect to the encoder value of a joint (0-based), a column of the
/// Jacobian with the encoder's sign.
Eigen::Matrix<double, 6, 1> joint_column(const KinematicChain& chain, const PoseJacobian& jacobian,
                                         int joint);

/// Moves the translation rows from the origin of the measured frame to a point fixed in that frame:
///     J_t <- J_t - [lever]x J_r,    i.e. dp = dt + dr x lever.
/// J_t: rows 0-2, J_r: rows 3-5. `lever`: point minus origin, in the axes of R_A [m].
void move_to_point(PoseJacobian& jacobian, const Eigen::Vector3d& lever);

}  // namespace armtrue
