#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/units.h"
#include "search/cycle_nodes.h"
#include "search/linearization.h"

namespace armtrue {

/// An effect that the model may lack, with its charge for the number of candidates.
struct Candidate {
  Effect effect;  ///< without coefficients
  /// ln of the number of candidates of its kind and of the kinds searched before it.
  double log_choices = 0;
  bool only_positive = false;
  bool from_catalogue = false;
  std::string separated_by{};  ///< in words, from the catalogue
  /// One cycle over the travel covered [cycles per turn]. Two frequencies of a periodogram that
  /// differ by less are the same. 0: the frequency is fixed.
  double frequency_resolution = 0;
  /// A curve of many coefficients, which can imitate almost any function of its driver.
  bool fine = false;
  /// A fine curve, or a piece of one: a step, a kink or a narrow bump of a joint over its own
  /// angle. It may enter the model only when no simpler candidate is left. Pieces that entered
  /// earlier would use up the effects of a model before the curve that they are parts of could
  /// enter.
  bool detail = false;
  /// One degree of the driver [rad], or the corresponding width of a prismatic joint [m]. The grids
  /// of inner values are multiples of it.
  double degree = kDegree;
  std::string in_words{};  ///< from the catalogue
  bool of_most_arms = false;
  std::string of_family{};     ///< name of the family of which it is a member; empty: of none
  /// It may enter the model only with its family, and the family only in place of another effect.
  /// Also true of the family.
  bool only_together = false;
  bool alike = false;          ///< all members of its family have one sign
  /// Largest change of its parameter over a campaign, with its only possible sign [SI]; 0: any
  /// sign, and any size that is_possible().
  double furthest = 0;
};

/// Values of shapes at readings; those in one context have the same values.
struct ScanValues {
  std::vector<int> context_of_reading;
  std::vector<int> readings_of_context;  ///< their number
  Eigen::MatrixXf values;  ///< contexts x values; float is precise enough to rank candidates
};

/// All candidates of a search with the values of their drivers and shapes in every row of a
/// campaign. Candidates that differ only in the parameter share the values. The values are in two
/// parts: those that joint angles and payload determine are the same at every visit of a pose; the
/// others (time, direction of arrival, temperature, ...) differ between visits.
class CandidateScan {
 public:
  static constexpr int kPosture = 0, kVisit = 1, kParts = 2;

  CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                const Campaign& campaign);

  const std::vector<Candidate>& candidates() const { return candidates_; }

  /// Whitened columns X of one candidate, before projection, at every reading of the campaign:
  /// (readings * row_size) x coefficients.
  Eigen::MatrixXd columns_at_readings(const Linearization& fit, int candidate) const;

  /// Largest standard deviation over the campaign of what the candidate adds to a parameter, as a
  /// share of what is possible: 20 mm, 20 mrad, or a scale of 1e-3 (of wires 2 %). For parameters
  /// of the instrument, which the model does not fit as constants, it is the RMS.
  double share_of_possible(int candidate, const Eigen::VectorXd& coefficients) const;

  /// Whether the law of a candidate allows these coefficients: their sign and, if it has a bound of
  /// its own (Candidate::furthest), what it adds between the least and the largest value of its
  /// driver. Several coefficients may have either sign: they are first moments of masses that the
  /// robot file does not state.
  bool is_allowed(int candidate, const Eigen::VectorXd& coefficients) const;

  /// Whether a candidate may have these coefficients: its law allows them and the size is possible.
  bool is_possible(int candidate, const Eigen::VectorXd& coefficients) const;

 private:
  friend class ProjectedCandidates;

  int parameters() const { return static_cast<int>(first_column_.size()) - 1; }

  // column = d(reading)/d(parameter) * value of a shape; the columns of one parameter stand
  // together, and among them those of one part, of which a periodogram's are the last.
  struct Term {
    int coefficient, parameter, column;
  };
  // Where the values of effects come from, each once.
  struct Source {
    BoundEffect bound;
    int part, first_value;  // within the part
  };
  struct Columns {
    int begin, end;
  };
  // The columns of a periodogram with clearly more frequencies than nodes, from the `first` on:
  // sine and cosine of one frequency after the other.
  struct Periodogram {
    CycleNodes nodes;
    std::map<int, CycleNodes::Near> near_of_sine;  // of each frequency, by the value of its sine
    int first = 0;

    bool has(int value) const {
      return near_of_sine.contains(value) || near_of_sine.contains(value - 1);
    }
  };
  Columns columns_of(int parameter, int part) const {
    const int first = first_column_[parameter], middle = first_visit_column_[parameter];
    return part == kPosture ? Columns{first, middle}
                            : Columns{middle, first_column_[parameter + 1]};
  }

  void find_periodograms(const std::vector<std::vector<Term>>& terms_by_value,
                         const Campaign& campaign, const std::vector<int>& readings);
  void share_columns(std::vector<std::vector<Term>> terms_by_value, size_t parameters);
  void fill_values(const std::vector<Source>& sources, int part, const Robot& robot,
                   const Campaign& campaign, const std::vector<int>& readings);

  std::vector<Candidate> candidates_;
  ParameterLayout layout_;
  double max_scale_;
  std::vector<std::vector<Term>> terms_;
  std::vector<int> coefficient_count_;
  std::vector<int> part_;  // of each candidate
  std::array<ScanValues, kParts> parts_;
  std::vector<int> value_of_column_;  // its column in the values of its part
  std::vector<int> first_column_;     // per parameter and one past
  std::vector<int> first_visit_column_;
  std::map<int, Periodogram> periodograms_;  // by parameter
};

}  // namespace armtrue
