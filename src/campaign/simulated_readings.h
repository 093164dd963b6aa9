#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/campaign/touch_sights.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/statistics/random.h"

namespace armtrue {

/// Errors of the readings, noise and blunders.
class ReadingErrors {
 public:
  /// `options` and `random` outlive it.
  ReadingErrors(const SimulationOptions& options, Random& random)
      : options_(&options), random_(&random) {}

  double of_length() const;             ///< [m]
  Eigen::Vector3d of_point() const;     ///< [m]
  Eigen::Vector2d of_pixel() const;     ///< [px]
  Eigen::Vector3d of_rotation() const;  ///< rotation vector [rad]
  /// Of the numbers that a touch reads [m].
  Eigen::VectorXd of_touch(Eigen::Index numbers) const;

 private:
  bool is_blunder() const { return random_->uniform(0, 1) < options_->blunders; }

  const SimulationOptions* options_;
  Random* random_;
};

/// The arm stands still.
struct Visit {
  Context context;
  Pose a_from_measured;               ///< without errors of an instrument
  std::optional<TouchSight> touched;  ///< what the arm touches there
};

/// A row as a file has it. What it does not read stays as it is here.
struct ReadRow {
  int target = 0, anchor = 0;
  int name = -1;  ///< of what is touched or seen, an index into contact_names
  bool is_pixel = false;
  Eigen::Vector3d position{0, 0, 0};  ///< [m], of a pixel [px]
  double length = 0;                  ///< [m]
  ProfilePoint profile{};
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// What one of the instruments and sensors reads at a visit.
using Instrument = std::function<std::vector<ReadRow>(const Visit&)>;

/// Those that the options name. Adds the names of what they read to the campaign. `truth` outlives
/// them.
std::vector<Instrument> instruments_of(const Robot& truth, const SimulationOptions& options,
                                       const ReadingErrors& errors, Campaign& campaign);

/// Adds the reading to the columns of a campaign of these kinds.
void append_reading(const ReadRow& row, const Robot& truth, const SimulationOptions& options,
                    Campaign& campaign);

}  // namespace armtrue
