#include "armtrue/programs/krl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/division.h"
#include "armtrue/programs/matching.h"
#include "armtrue/text/input_error.h"
#include "programs/krl_syntax.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
// How far off the path a point of the program may lie: less is rounding on the way to the path.
constexpr double kMatch = 1e-4;  // [m]

KrlValues unknown() { return KrlValues::Constant(kUnknown); }

// What is given, else what was before.
KrlValues inherit(const KrlValues& before, const KrlValues& given) {
  return given.array().isFinite().select(given, before);
}

// What two poses have in common; the rest is unknown.
KrlValues common(const KrlValues& a, const KrlValues& b) {
  return (a.array() == b.array()).select(a, unknown());
}

Vector3d position(const KrlValues& pose) { return pose.head<3>(); }

// The pose between two: position left open, orientation by rotation about one axis, external axes
// linear.
KrlValues between(const KrlValues& start, const KrlValues& end, double t) {
  KrlValues pose = start + t * (end - start);
  const Vector3d from = start.segment<3>(3), to = end.segment<3>(3);
  if (from.allFinite() && to.allFinite() && from != to) {
    const Eigen::Matrix3d rotation = rotation_from_abc(from[0], from[1], from[2]);
    const Vector3d turn =
        rotation_log(rotation.transpose() * rotation_from_abc(to[0], to[1], to[2]));
    pose.segment<3>(3) = abc_from_rotation(rotation * rotation_exp(t * turn));
  }
  return pose;
}

// Warnings of one kind are one warning with its lines.
class Warnings {
 public:
  explicit Warnings(std::string file) : file_(std::move(file)) {}

  void add(int line, const std::string& text) {
    auto kind = std::find_if(kinds_.begin(), kinds_.end(),
                             [&](const Kind& known) { return known.text == text; });
    if (kind == kinds_.end()) kind = kinds_.insert(kind, {text, {}});
    kind->lines.push_back(line);
  }

  std::vector<std::string> list() const {
    constexpr size_t kShown = 5;
    std::vector<std::string> result;
    for (const Kind& kind : kinds_) {
      std::string text = fmt::format("{}:{}: {}", file_, kind.lines.front(), kind.text);
      for (size_t i = 1; i < std::min(kind.lines.size(), kShown); ++i)
        text += fmt::format("{}{}", i == 1 ? "; also lines " : ", ", kind.lines[i]);
      if (kind.lines.size() > kShown)
        text += fmt::format(" and {} more", kind.lines.size() - kShown);
      result.push_back(text);
    }
    return result;
  }

 private:
  struct Kind {
    std::string text;
    std::vector<int> lines;
  };
  std::string file_;
  std::vector<Kind> kinds_;
};

// A move with the poses that the program means, and where on the path they lie (NaN: nowhere).
struct PlannedMove {
  bool known = false;  // the positions of all its points
  KrlValues start, auxiliary, end;
  double start_place = kUnknown, auxiliary_place = kUnknown, end_place = kUnknown;
  double from = 0, to = 0;  // the part of the path between the found points before and behind
};

std::vector<PlannedMove> plan(const KrlSyntax& syntax) {
  std::vector<PlannedMove> plans;
  plans.reserve(syntax.moves.size());
  KrlValues pose = unknown();
  for (const KrlMove& move : syntax.moves) {
    if (move.start_unknown) pose = unknown();
    PlannedMove plan;
    plan.start = plan.auxiliary = pose;
    plan.end = unknown();
    const bool circle = move.motion == KrlMotion::circle;
    const auto has_frame = [](const KrlTarget& target) {
      return target.kind == KrlTargetKind::frame;
    };
    const auto values = [&](const KrlTarget& target) -> const KrlValues& {
      return syntax.frames[static_cast<size_t>(target.frame)].values;
    };
    if (!move.relative && has_frame(move.target) && (!circle || has_frame(move.auxiliary))) {
      if (circle) {
        plan.auxiliary = inherit(pose, values(move.auxiliary));
        pose = common(pose, plan.auxiliary);
      }
      plan.end = inherit(pose, values(move.target));
      plan.known =
          position(plan.end).allFinite() && (!circle || position(plan.auxiliary).allFinite());
    }
    pose = plan.end;
    if (move.circle_angle) pose = unknown();  // the move ends elsewhere
    plans.push_back(plan);
  }
  return plans;
}

// Finds the points on the path. Throws InputError if there are none.
void place(const KrlProgram& program, const KrlSyntax& syntax, const Path& path,
           std::vector<PlannedMove>& plans) {
  std::vector<Vector3d> points;
  std::vector<double*> places;
  std::vector<int> lines;
  for (size_t i = 0; i < plans.size(); ++i) {
    if (!plans[i].known) continue;
    if (syntax.moves[i].motion == KrlMotion::circle) {
      points.push_back(position(plans[i].auxiliary));
      places.push_back(&plans[i].auxiliary_place);
      lines.push_back(syntax.moves[i].line);
    }
    points.push_back(position(plans[i].end));
    places.push_back(&plans[i].end_place);
    lines.push_back(syntax.moves[i].line);
  }
  if (points.empty())
    throw InputError(fmt::format(
        "{}: none of its {} moves goes to a position that is known here; the points of a program "
        "stand in its .dat, which belongs beside it",
        program.src.name, syntax.moves.size()));
  Eigen::Matrix3Xd columns(3, static_cast<Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) columns.col(static_cast<Index>(i)) = points[i];
  const Eigen::VectorXd found = places_in_order(path.position, columns, kMatch);
  if (found.array().isNaN().all()) {
    const NearestPoint nearest = nearest_to(path.position, columns);
    const Vector3d point = columns.col(nearest.point) / kMillimetre;
    throw InputError(fmt::format(
        "{}: no point of the program lies on the programmed path; the nearest, in line {} at "
        "({:.3f}, "
        "{:.3f}, {:.3f}) mm, is {:.3f} mm off. Is this the program of that path, and are its "
        "coordinates in the $BASE of the program?",
        program.src.name, lines[static_cast<size_t>(nearest.point)], point.x(), point.y(),
        point.z(), nearest.distance / kMillimetre));
  }
  for (size_t i = 0; i < places.size(); ++i) *places[i] = found[static_cast<Index>(i)];
  double last = 0;
  for (size_t i = 0; i < plans.size(); ++i) {
    plans[i].from = last;
    if (std::isfinite(plans[i].end_place)) last = plans[i].end_place;
    if (i > 0 && !syntax.moves[i].start_unknown && !syntax.moves[i - 1].circle_angle)
      plans[i].start_place = plans[i - 1].end_place;
  }
  last = static_cast<double>(path.samples());
  for (size_t i = plans.size(); i-- > 0;) {
    if (std::isfinite(plans[i].end_place)) last = plans[i].end_place;
    plans[i].to = last;
  }
}

// Where on a move a sample lies: t from 0 to 1, NaN if beside it. What is within the tolerance
// [share of the length] of an end lies on that end.
double within_move(double t, double tolerance) {
  if (!(t >= -tolerance && t <= 1 + tolerance)) return kUnknown;
  return t <= tolerance ? 0 : t >= 1 - tolerance ? 1 : t;
}

double place_on_line(const Vector3d& start, const Vector3d& end, const Vector3d& sample) {
  const Vector3d chord = end - start;
  const double t = chord.dot(sample - start) / chord.squaredNorm();
  if ((start + t * chord - sample).norm() > kMatch) return kUnknown;
  return within_move(t, kMatch / chord.norm());
}

double place_on_arc(const Arc& arc, const Vector3d& sample) {
  if (arc.distance(sample) > kMatch) return kUnknown;
  const double share = kMatch / (arc.radius * arc.angle);
  const double t = arc.foot(sample), turn = 2 * std::numbers::pi / arc.angle;
  return within_move(t > turn - share ? t - turn : t, share);
}

// The samples of the path on a move, with the displacement there. Its ends are the first and the
// last knot; one that is not on the path is not displaced, and from the other the path counts as
// far as it follows the move.
template <class PlaceOn>
std::vector<Knot> knots_on(const PlannedMove& plan, const Path& path,
                           const Eigen::Matrix3Xd& displacement, PlaceOn place_on) {
  const bool from_start = std::isfinite(plan.start_place), to_end = std::isfinite(plan.end_place);
  const auto begin = static_cast<Index>(std::ceil(plan.from));
  const auto end = std::min(static_cast<Index>(plan.to) + 1, path.samples());
  std::vector<Knot> inside;
  const auto add = [&](Index k) {
    const double t = place_on(path.position.col(k));
    if (t > 0 && t < 1) inside.push_back({t, displacement.col(k)});
    return std::isfinite(t);
  };
  if (from_start) {
    for (Index k = begin; k < end; ++k)
      if (!add(k) && !to_end) break;
  } else if (to_end) {
    for (Index k = end - 1; k >= begin; --k)
      if (!add(k)) break;
    std::reverse(inside.begin(), inside.end());
  }
  const auto at_end = [&](double place) -> Vector3d {
    return std::isfinite(place) ? at_place(displacement, place) : Vector3d::Zero();
  };
  std::vector<Knot> knots{{0, at_end(plan.start_place)}};
  for (const Knot& knot : inside)
    if (knot.t > knots.back().t) knots.push_back(knot);
  knots.push_back({1, at_end(plan.end_place)});
  return knots;
}

struct Edit {
  bool in_dat;
  size_t begin, end;
  std::string text;
};

std::string apply(const std::string& text, const std::vector<Edit>& edits, bool in_dat) {
  std::vector<const Edit*> order;
  for (const Edit& edit : edits)
    if (edit.in_dat == in_dat) order.push_back(&edit);
  std::stable_sort(order.begin(), order.end(),
                   [](const Edit* a, const Edit* b) { return a->begin < b->begin; });
  std::string result;
  size_t from = 0;
  for (const Edit* edit : order) {
    result.append(text, from, edit->begin - from);
    result += edit->text;
    from = edit->end;
  }
  result.append(text, from, std::string::npos);
  return result;
}

// Goes through the moves in order and collects what has to change.
class Writer {
 public:
  Writer(const KrlProgram& program, const KrlSyntax& syntax, const Path& path,
         const Eigen::Matrix3Xd& corrected, const KrlCorrectionOptions& options)
      : program_(program),
        syntax_(syntax),
        path_(path),
        displacement_(corrected - path.position),
        options_(options),
        warnings_(program.src.name),
        uses_(syntax.frames.size()) {}

  CorrectedKrl write(const std::vector<PlannedMove>& plans) {
    if (syntax_.absolute_accuracy_line)
      warnings_.add(
          syntax_.absolute_accuracy_line,
          "$ABS_ACCUR: the controller corrects the arm's geometry itself; measure and run "
          "with it in the same state, or both corrections add up");
    note_few_found(plans);
    for (size_t i = 0; i < plans.size(); ++i) write_move(syntax_.moves[i], plans[i]);
    edit_targets();
    result_.src = apply(program_.src.text, edits_, false);
    if (program_.dat) result_.dat = apply(program_.dat->text, edits_, true);
    result_.warnings = warnings_.list();
    return std::move(result_);
  }

 private:
  // What a target, by itself or by name, is to say.
  struct Use {
    const KrlTarget* target;
    std::string text;
  };

  std::string_view text_of(const KrlFrame& frame) const {
    return frame.in_dat ? program_.dat->text : program_.src.text;
  }
  std::string_view src(size_t begin, size_t end) const {
    return std::string_view(program_.src.text).substr(begin, end - begin);
  }
  const KrlFrame& frame(const KrlTarget& target) const {
    return syntax_.frames[static_cast<size_t>(target.frame)];
  }

  // The target with other values; `pose` is what was before it and becomes what it says.
  std::string target_text(const KrlTarget& target, const KrlValues& values, KrlValues& pose) const {
    const std::string text = krl_frame_text(text_of(frame(target)), frame(target), values, pose);
    pose = inherit(inherit(pose, frame(target).values), values);
    return text;
  }

  void write_target(const KrlTarget& target, const KrlValues& values, KrlValues& pose) {
    uses_[static_cast<size_t>(target.frame)].push_back(
        {&target, target_text(target, values, pose)});
  }

  void write_move(const KrlMove& move, const PlannedMove& plan) {
    if (move.start_unknown) pose_ = unknown();
    const bool circle = move.motion == KrlMotion::circle;
    if (std::isfinite(plan.end_place)) {
      ++result_.corrected;
      note_surroundings(move);
    } else {
      ++result_.left_alone;
      note_left_alone(move, plan);
    }
    if (circle && plan.known)
      write_circle(move, plan);
    else if (plan.known)
      write_line(move, plan);
    else
      leave(move);
    if (move.circle_angle) pose_ = unknown();
  }

  // What cannot be corrected is a use of its names none the less, and what it gives is inherited.
  void leave(const KrlMove& move) {
    const bool circle = move.motion == KrlMotion::circle;
    const bool via = move.auxiliary.kind == KrlTargetKind::frame;
    const bool to = move.target.kind == KrlTargetKind::frame;
    KrlValues pose = pose_;
    if (via) write_target(move.auxiliary, unknown(), pose);
    pose = common(pose_, pose);
    if (to) write_target(move.target, unknown(), pose);
    pose_ = to && (via || !circle) ? pose : unknown();
  }

  // Approach and retreat lie off the path; where most of the program does, it is another path's.
  void note_few_found(const std::vector<PlannedMove>& plans) {
    int known = 0, found = 0, first_off = 0;
    for (size_t i = 0; i < plans.size(); ++i) {
      if (!plans[i].known) continue;
      const bool on_path = std::isfinite(plans[i].end_place);
      ++known;
      found += on_path;
      if (!on_path && first_off == 0) first_off = syntax_.moves[i].line;
    }
    if (2 * found < known)
      warnings_.add(first_off, fmt::format("only {} of the {} points of the program lie on the "
                                           "programmed path; is this the program of that path?",
                                           found, known));
  }

  void note_surroundings(const KrlMove& move) {
    if (!base_) base_ = {move.base, move.line};
    if (base_->first != move.base)
      warnings_.add(move.line, fmt::format("$BASE is another one than for the first corrected move "
                                           "(line {}); its coordinates were taken as they stand",
                                           base_->second));
    if (move.in_loop)
      warnings_.add(move.line, "stands in a loop; every turn gets the correction of the first");
  }

  void note_left_alone(const KrlMove& move, const PlannedMove& plan) {
    const auto what = [&]() -> std::string {
      if (plan.known) return "ends off the path";
      if (move.relative) return "relative to the (corrected) point before it";
      const bool by_target =
          move.motion != KrlMotion::circle || move.auxiliary.kind == KrlTargetKind::frame;
      switch (by_target ? move.target.kind : move.auxiliary.kind) {
        case KrlTargetKind::axes:
          return "axis angles, which need the robot";
        case KrlTargetKind::undeclared:
          return "its point is declared neither here nor in " +
                 (program_.dat ? program_.dat->name : "a .dat beside this file");
        case KrlTargetKind::reassigned:
          return "its point is given a value more than once, or in a way not understood";
        case KrlTargetKind::expression:
          return "its target is not understood";
        case KrlTargetKind::frame:
          break;
      }
      return "coordinates are left out and the point before is not known";
    };
    warnings_.add(move.line, "left alone: " + what());
  }

  KrlValues displaced(KrlValues pose, double place) const {
    if (std::isfinite(place)) pose.head<3>() += at_place(displacement_, place);
    return pose;
  }

  // Why no moves can be inserted before this one; empty if they can.
  std::string obstacle(const KrlMove& move, const PlannedMove& plan) const {
    if (move.in_spline_block) return "a spline block";
    if (move.after_trigger) return "a TRIGGER refers to this move";
    const KrlValues& given = frame(move.target).values;
    for (int i = 3; i < kKrlComponents; ++i)
      if (std::isfinite(given[i]) && !(std::isfinite(plan.start[i]) && std::isfinite(plan.end[i])))
        return "the orientation or an external axis before it is not known";
    return "";
  }

  void write_line(const KrlMove& move, const PlannedMove& plan) {
    const Vector3d start = position(plan.start), end = position(plan.end);
    const bool on_path = std::isfinite(plan.start_place) || std::isfinite(plan.end_place);
    if (move.motion == KrlMotion::line && on_path && start.allFinite() && start != end) {
      std::vector<Knot> knots = knots_on(plan, path_, displacement_, [&](const Vector3d& sample) {
        return place_on_line(start, end, sample);
      });
      // What moves along the line bends nothing, but is where the rest of the displacement belongs.
      const Vector3d along = (end - start).normalized();
      for (size_t k = 0; k < knots.size(); ++k) {
        const double forward = along.dot(knots[k].displacement);
        knots[k].displacement -= forward * along;
        knots[k].t += forward / (end - start).norm();
        if (k > 0) knots[k].t = std::max(knots[k].t, knots[k - 1].t);
      }
      const std::vector<size_t> divisions =
          divide_line(knots, options_.tolerance, options_.spacing / (end - start).norm());
      if (may_insert(move, plan, divisions.size() - 2))
        for (size_t i = 1; i + 1 < divisions.size(); ++i) {
          const Knot& knot = knots[divisions[i]];
          KrlValues pose = between(plan.start, plan.end, std::clamp(knot.t, 0.0, 1.0));
          pose.head<3>() = start + knot.t * (end - start) + knot.displacement;
          insert(move,
                 std::string(src(move.keyword_end, move.target.begin)) +
                     target_text(move.target, pose, pose_),
                 false);
        }
    }
    write_end(move, plan);
  }

  // On the path every component is as planned, whatever was before; elsewhere the text stands.
  void write_end(const KrlMove& move, const PlannedMove& plan) {
    write_target(move.target,
                 std::isfinite(plan.end_place) ? displaced(plan.end, plan.end_place) : unknown(),
                 pose_);
  }

  void write_circle(const KrlMove& move, const PlannedMove& plan) {
    const auto arc =
        arc_through(position(plan.start), position(plan.auxiliary), position(plan.end));
    if (!arc || move.circle_angle || !std::isfinite(plan.start_place) ||
        !std::isfinite(plan.end_place)) {
      write_circle_points(move, plan);
      return;
    }
    const std::vector<Knot> knots =
        knots_on(plan, path_, displacement_,
                 [&](const Vector3d& sample) { return place_on_arc(*arc, sample); });
    const double via = arc->foot(position(plan.auxiliary));
    const std::vector<size_t> divisions = divide_arc(*arc, via, knots, options_.tolerance,
                                                     options_.spacing / (arc->radius * arc->angle));
    if (!may_insert(move, plan, divisions.size() - 2)) {
      KrlValues auxiliary = unknown();
      auxiliary.head<3>() = position(plan.auxiliary) + displacement_at(knots, via);
      write_auxiliary(move, auxiliary);
      write_end(move, plan);
      return;
    }
    for (size_t i = 1; i < divisions.size(); ++i) {
      const Knot& knot = knots[divisions[i]];
      const double middle = (knots[divisions[i - 1]].t + knot.t) / 2;
      const bool last = i + 1 == divisions.size();
      const bool straight =
          is_straight(*arc, knots, divisions[i - 1], divisions[i], options_.tolerance);
      const auto at = [&](double t) {
        KrlValues pose = between(plan.start, plan.end, t);
        pose.head<3>() = arc->at(t) + displacement_at(knots, t);
        return pose;
      };
      KrlValues auxiliary = at(middle);
      // What the auxiliary point does not say, it need not.
      for (int k = 3; k < kKrlComponents; ++k)
        if (!std::isfinite(frame(move.auxiliary).values[k])) auxiliary[k] = kUnknown;
      if (!last) {
        std::string points(src(move.keyword_end, move.auxiliary.begin));
        if (!straight) {
          KrlValues via_pose = pose_;
          points += target_text(move.auxiliary, auxiliary, via_pose);
          points += src(move.auxiliary.end, move.target.begin);
          pose_ = common(pose_, via_pose);
        }
        insert(move, points + target_text(move.target, at(knot.t), pose_), straight);
        continue;
      }
      if (straight) {
        KrlValues unused = pose_;
        write_target(move.auxiliary, unknown(), unused);
        edits_.push_back(
            {false, move.begin, move.target.begin,
             line_keyword(move) + std::string(src(move.keyword_end, move.auxiliary.begin))});
      } else {
        write_auxiliary(move, auxiliary);
      }
      write_end(move, plan);
    }
  }

  void write_auxiliary(const KrlMove& move, const KrlValues& auxiliary) {
    KrlValues pose = pose_;
    write_target(move.auxiliary, auxiliary, pose);
    pose_ = common(pose_, pose);
  }

  // Each point by its own displacement.
  void write_circle_points(const KrlMove& move, const PlannedMove& plan) {
    KrlValues auxiliary = unknown();
    if (std::isfinite(plan.auxiliary_place))
      auxiliary.head<3>() = displaced(plan.auxiliary, plan.auxiliary_place).head<3>();
    write_auxiliary(move, auxiliary);
    write_end(move, plan);
    if (std::isfinite(plan.auxiliary_place) || std::isfinite(plan.end_place))
      warnings_.add(move.line,
                    "CIRC that starts or ends off the path, or has an angle: only its points are "
                    "corrected, what lies between follows");
  }

  bool may_insert(const KrlMove& move, const PlannedMove& plan, size_t count) {
    if (count == 0) return false;
    const std::string reason = obstacle(move, plan);
    if (reason.empty()) return true;
    warnings_.add(move.line,
                  "the correction bends along this move, but no points are inserted: " + reason);
    return false;
  }

  static std::string line_keyword(const KrlMove& move) { return move.spline ? "SLIN" : "LIN"; }

  // A move like this one (or a straight one), blended, on a line of its own before it.
  void insert(const KrlMove& move, const std::string& points, bool straight) {
    const std::string& text = program_.src.text;
    std::string line(src(move.line_begin, move.begin));
    line += straight ? line_keyword(move) : std::string(src(move.begin, move.keyword_end));
    const std::string_view rest = src(move.target.end, move.end);
    line += points;
    line += rest;
    if (!is_blended(rest)) line += move.spline ? " C_SPL" : " C_DIS";
    size_t newline = text.find('\n', move.end);
    if (newline == std::string::npos && move.line_begin > 0) newline = move.line_begin - 1;
    const bool returns = newline != std::string::npos && newline > 0 && text[newline - 1] == '\r';
    line += returns ? "\r\n" : "\n";
    edits_.push_back({false, move.line_begin, move.line_begin, line});
    ++result_.inserted;
    if (move.in_inline_form)
      warnings_.add(move.line,
                    "points are inserted in an inline form; changing it on the pendant drops them");
  }

  static bool is_blended(std::string_view rest) {
    std::string capitals(rest);
    for (char& c : capitals)
      if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    for (const char* word : {"C_DIS", "C_SPL", "C_VEL", "C_ORI", "C_PTP"})
      if (capitals.find(word) != std::string::npos) return true;
    return false;
  }

  // A frame is changed where it stands; a name that its moves want different is replaced by frames.
  void edit_targets() {
    for (size_t i = 0; i < uses_.size(); ++i) {
      const KrlFrame& frame = syntax_.frames[i];
      const std::string_view now = text_of(frame).substr(frame.begin, frame.end - frame.begin);
      const std::vector<Use>& uses = uses_[i];
      if (uses.empty()) continue;
      const bool agreed = std::all_of(
          uses.begin(), uses.end(), [&](const Use& use) { return use.text == uses.front().text; });
      if (agreed && !uses.front().target->shared) {
        if (uses.front().text != now)
          edits_.push_back({frame.in_dat, frame.begin, frame.end, uses.front().text});
        continue;
      }
      for (const Use& use : uses)
        if (use.text != now)
          edits_.push_back({false, use.target->begin, use.target->end, use.text});
    }
  }

  const KrlProgram& program_;
  const KrlSyntax& syntax_;
  const Path& path_;
  const Eigen::Matrix3Xd displacement_;
  const KrlCorrectionOptions options_;
  Warnings warnings_;
  std::vector<std::vector<Use>> uses_;  // of each frame
  std::vector<Edit> edits_;
  KrlValues pose_ = unknown();               // where the moves so far, as written, end
  std::optional<std::pair<int, int>> base_;  // of the first corrected move, and its line
  CorrectedKrl result_;
};

}  // namespace

CorrectedKrl correct_krl(const KrlProgram& program, const Path& programmed,
                         const Eigen::Matrix3Xd& corrected, const KrlCorrectionOptions& options) {
  const KrlSyntax syntax = parse_krl(program);
  std::vector<PlannedMove> plans = plan(syntax);
  place(program, syntax, programmed, plans);
  return Writer(program, syntax, programmed, corrected, options).write(plans);
}

}  // namespace armtrue
