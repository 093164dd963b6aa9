#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/identification/campaign.h"
#include "armtrue/identification/observation.h"
#include "armtrue/identification/simulation.h"
#include "armtrue/identification/zone.h"

namespace armtrue {

struct PlanOptions {
  bool orientation = true;   ///< is read; false: positions only. Given poses decide for themselves,
                             ///< targets and anchors come without
  std::optional<Box> box;    ///< of the measured point; absent: the whole travel of the joints
  std::optional<Zone> zone;  ///< where the arm shall be accurate; absent: everywhere
  double floor = 0;  ///< height in R_0 that no link origin and no point of the tool passes [m]
  std::uint64_t seed = 1;
};

/// What a geometric calibration from some poses, with those given, promises.
struct PlanQuality {
  double log_determinant;               ///< of the information matrix [SI]; -inf: rank is missing
  std::array<double, 5> observability;  ///< O1 ... O5, as in CalibrationResult
  /// Expected deviation of the predicted position from the true one, three axes together [m]: root
  /// of its mean square over the cloud of candidates, and over the zone (0 without a zone).
  /// Infinite where rank is missing.
  double cloud_deviation, zone_deviation;
};

/// Chooses the poses from which a geometric calibration is best.
///
/// Candidates are a cloud of random configurations within the travel limits, above the floor; an
/// arm that strikes itself or what stands around it is not seen. Every candidate is a block of
/// whitened derivatives of its readings, with the robot's noise (0.1 mm and 0.1 mrad where it
/// states none). The unknowns are what choose_identifiable() finds in cloud and given poses; the
/// robot's effects and priors are left out. With targets every pose reads each of them; with
/// anchors, their distances from each.
class PosePlanner {
 public:
  /// `given`: poses already measured, of which only configurations, targets and sigmas count; no
  /// rows: none. Throws std::invalid_argument if the box cannot be reached, hardly any
  /// configuration stays above the floor, none has its point within the zone, or no allowed
  /// parameter is identifiable.
  PosePlanner(const Robot& robot, const PlanOptions& options, const Campaign& given = {});

  /// `count` different configurations, at most candidate_count(), that with the given poses make
  /// the determinant of the information matrix largest (D-optimal) or, with a zone, the mean
  /// variance of the position predicted in it smallest (I-optimal). Greedy start, then each pose is
  /// exchanged for the best candidate until no exchange helps (Fedorov, "Theory of Optimal
  /// Experiments", 1972, in the variant of Cook and Nachtsheim 1980; for robots Borm and Menq
  /// 1991). A local optimum; the same for the same seed. Random poses all over the travel are
  /// nearly as good for all of it; planning pays for a zone, in a box, and where poses are few.
  std::vector<JointVector> plan(int count) const;

  /// Random configurations under the same limits, for comparison.
  std::vector<JointVector> random(int count, std::uint64_t seed) const;

  PlanQuality quality(const std::vector<JointVector>& configurations) const;

  static constexpr int candidate_count() { return 2000; }

 private:
  std::vector<JointVector> draw(int count, const std::optional<Box>& box, std::uint64_t seed) const;
  std::vector<JointVector> zone_configurations() const;
  Campaign points(const std::vector<JointVector>& configurations) const;
  Campaign readings(const std::vector<JointVector>& configurations) const;
  Eigen::MatrixXd triangle(const Campaign& campaign) const;
  Eigen::MatrixXd position_triangle(const std::vector<JointVector>& configurations) const;

  Robot robot_;
  PlanOptions options_;
  ReadingScale noise_;
  std::vector<JointVector> cloud_;
  std::vector<int> unknowns_;  // parameter indices

  // Upper triangles R; R^T R is, over the unknowns, ...
  Eigen::MatrixXd typical_;                         // the information of an average pose
  Eigen::MatrixXd given_;                           // the information of the given poses
  Eigen::MatrixXd cloud_position_, zone_position_;  // the mean of J^T J of the position [m]
  int given_rows_;
};

}  // namespace armtrue
