#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// What may have another value in a part of the readings: consecutive parameters, tried together.
struct Cause {
  enum class Kind { base, tool, zero, scale, range, contact } kind;
  int first_column;  ///< of FitEquations::columns
  int count;
  int parameter;  ///< of the first column
};

struct Causes {
  std::vector<Cause> all;
  std::vector<int> parameters;  ///< of the columns

  void add(Cause::Kind kind, int parameter, int count);
};

/// The causes that a plain fit can distinguish: the base, if `with_base`; the tool, unless there
/// are several targets; the zero of each joint that the fit identifies, unless each session has its
/// own; the scale of the instrument and, of points, the constant of its range. Of images the place
/// of each camera and each board, and the zeros.
Causes possible_causes(const PlainFit& fit, bool with_base);

/// The readings in which something has changed.
struct ChangedPart {
  std::string words;    ///< "in session 'monday'"; of images "between the images of two poses"
  std::string session;  ///< how the user makes a session of them: "a column 'session'"; empty: they
                        ///< are one
};

/// A change in words.
std::string describe_change(const Cause& cause, const Eigen::VectorXd& value, const PlainFit& fit,
                            const ChangedPart& part);

/// Words on a frame that has moved by so much at the middle of the readings [m, rad].
std::string moved_frame_in_words(double moved, double turned, const ChangedPart& part);
/// The same for a tool; `turned`: if orientations were read.
std::string moved_tool_in_words(double moved, std::optional<double> turned,
                                const ChangedPart& part);

}  // namespace armtrue
