#include "armtrue/compensation/compensation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iterator>
#include <numeric>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "compensation/arms.h"
#include "compensation/branch.h"
#include "compensation/coverage.h"
#include "compensation/joint_correction.h"
#include "compensation/posture_search.h"
#include "compensation/program_arm.h"
#include "compensation/programmed_joints.h"
#include "compensation/row_ways.h"
#include "compensation/tcp_way.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kMostTries = 20;         // for the motion to be that of the command
constexpr double kSameStroke = 1e-12;  // [rad]

bool changes_turn(const KinematicChain& chain, const JointVector& a, const JointVector& b) {
  for (int j = 0; j < static_cast<int>(a.size()); ++j)
    if (!is_prismatic(joint_link(chain, j)) && (a[j] < 0) != (b[j] < 0)) return true;
  return false;
}

// Whether each row states its joint angles, so that it does not depend on the row before.
bool states_joints(const Program& program) {
  for (int row = 0; row < program.rows(); ++row)
    if (const size_t r = row; program.is_cartesian(r) && !program.hinted[r]) return false;
  return true;
}

// Goes through the rows of one program.
class Compensation {
 public:
  Compensation(const Robot& identified, const Robot& controller, const Program& program,
               const CompensationOptions& options)
      : program_(program),
        options_(options),
        visits_(program.visits),
        arms_(arms_of(identified, controller, program, options)),
        ways_(program),
        postures_(ways_.count()),
        found_(program.rows()),
        at_begin_{CommandedMotion(visits_), CommandedMotion(visits_)},
        motion_(at_begin_),
        targets_(program.rows()) {
    motion_matters_ =
        follows_motion(arms_[0].identified.robot()) || follows_motion(arms_[0].controller.robot());
    for (size_t row = 0; row < visits_.force_n.size(); ++row)
      visits_.force_n[row] = arms(row).options.base.rotation * visits_.force_n[row];
    if (motion_matters_) behind_.resize(visits_.q.size(), at_begin_);
    by_unknown_directions_.resize(visits_.q.size());
    visits_.arrival.resize(visits_.q.size(), Direction{});
    visits_.stroke.resize(
        visits_.q.size(),
        JointVector::Zero(visits_.q.empty() ? kMaxJoints : visits_.q.front().size()));
  }

  bool motion_matters() const { return motion_matters_; }

  // Throws UnreachableTarget once all rows are done, so that it names all that are out of reach.
  std::vector<CorrectedTarget> run(const Robot& identified) {
    find_postures();
    throw_if_unreachable();
    find_directions();
    for (const int node : ways_.order())
      if (const int row = ways_.row_of(node); row != kNoRow) targets_[row] = target_at(row);
    for (int row = 0; row < program_.rows(); ++row) visits_.q[row] = targets_[row].programmed;
    if (identified.uncertainty)
      for (const Arms& arms : arms_) cover_rows_of(arms, identified);
    for (CorrectedTarget& target : targets_) {
      if (target.is_corrected && changes_turn(identified.chain, target.programmed, target.q))
        target.notes.push_back(CommandNote::turn);
      std::ranges::sort(target.notes);
    }
    return std::move(targets_);
  }

 private:
  const Arms& arms(size_t row) const { return arms_[set_up_of(program_, row)]; }
  const ProgramArm& arm() const { return arms_now_->identified; }
  const ProgramArm& controller() const { return arms_now_->controller; }

  static constexpr int kNoRow = -1;
  // Where the arm may stand: joint angles, and the row that has them; none before all rows.
  struct Posture {
    JointVector q;
    int row;
    Branch branch;
  };
  // What is found for a row.
  struct Found {
    int from = kNoRow;  // the row from which the arm comes; one of them
    std::vector<Posture> before{}, own{};
    std::vector<Branch> tried{};  // of those before
    std::optional<std::string> failure{};
    bool is_out_of_reach = false;  // the failure
  };
  struct Motions {
    CommandedMotion commanded, programmed;
  };

  // The posture of a row may follow from those of the rows from which the arm comes. A loop comes
  // from a row behind it, so this is repeated until no way brings another one.
  void find_postures() {
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const int node : ways_.order()) {
        std::vector<Posture> now = postures_before(node);
        if (const int row = ways_.row_of(node); row != kNoRow) {
          find_postures_of(row, now);
          if (!found_[row].own.empty()) now = found_[row].own;
        }
        is_changed |= now.size() != postures_[node].size() ||
                      (!now.empty() && now[0].row != postures_[node][0].row);
        postures_[node] = std::move(now);
      }
    }
  }

  std::vector<Posture> postures_before(int node) const {
    std::vector<Posture> before;
    for (const int from : ways_.from(node))
      for (const Posture& posture : postures_[from]) add_new(posture, before);
    if (ways_.from(node).empty() && options_.start)
      before.push_back({*options_.start, kNoRow, arms_[0].controller.branch_at(*options_.start)});
    return before;
  }

  static bool is_equal(const Branch& a, const Branch& b) {
    return a.shoulder == b.shoulder && a.elbow == b.elbow && a.wrist == b.wrist;
  }

  // The first one of a branch stands for all.
  static void add_new(const Posture& posture, std::vector<Posture>& all) {
    if (std::ranges::none_of(
            all, [&](const Posture& other) { return is_equal(other.branch, posture.branch); }))
      all.push_back(posture);
  }

  // Whether the posture of a row is that in which the arm comes to it.
  bool follows_way(size_t row, const std::vector<Posture>& before) const {
    if (!program_.is_cartesian(row) || program_.hinted[row]) return false;
    if (program_.configurations.empty()) return true;
    const Configuration& stated = program_.configurations[row];
    const auto is_row = [](const Posture& posture) { return posture.row != kNoRow; };
    return !stated.is_stated() || (stated.continues && std::ranges::any_of(before, is_row));
  }

  void find_postures_of(int row, const std::vector<Posture>& before) {
    Found& found = found_[row];
    if (found.from == kNoRow && !before.empty()) found.from = before[0].row;
    found.before = before;
    if (!follows_way(row, before)) {
      const bool is_new = found.own.empty() && !found.failure;
      const bool is_known = !before.empty() && before[0].row != kNoRow;
      if (is_new) try_row(row, is_known ? std::optional(before[0].q) : std::nullopt);
      return;
    }
    for (const Posture& posture : before) {
      const auto is_it = [&](const Branch& branch) { return is_equal(branch, posture.branch); };
      if (std::ranges::any_of(found.tried, is_it)) continue;
      found.tried.push_back(posture.branch);
      try_row(row, posture.row == kNoRow ? std::nullopt : std::optional(posture.q));
    }
  }

  void try_row(int row, const std::optional<JointVector>& previous) {
    arms_now_ = &arms(row);
    Found& found = found_[row];
    try {
      const JointVector q = programmed_at(row, visits_.context(row), previous);
      add_new({q, row, controller().branch_at(q)}, found.own);
    } catch (const OutOfReach& error) {
      found.failure = error.what();
      found.is_out_of_reach = true;
    } catch (const UnreachableTarget& error) {
      found.failure = error.what();
    }
  }

  // It names all rows that are out of reach or in doubt.
  void throw_if_unreachable() const {
    std::optional<UnreachableTarget> all;
    bool is_any_found = false;
    for (int row = 0; row < program_.rows(); ++row) {
      const Found& found = found_[row];
      is_any_found |= !found.own.empty();
      if (found.own.size() == 1) continue;
      const bool is_in_doubt = found.own.size() > 1 || (!found.failure && is_any_found);
      const std::string why = found.own.size() > 1 ? why_in_doubt(found)
                              : found.failure      ? *found.failure
                                                   : arms(row).programmed.why_no_hint();
      if (!all) all.emplace(row, why);
      all->lacks_start |= found.own.empty() && !found.is_out_of_reach && !options_.start;
      if (is_in_doubt)
        all->in_doubt.emplace_back(row, why);
      else if (found.is_out_of_reach)
        all->out_of_reach.emplace_back(row, why);
      else
        throw *all;
    }
    if (all) throw *all;
  }

  std::string why_in_doubt(const Found& found) const {
    std::string names;
    for (const Posture& posture : found.before)
      names +=
          fmt::format("{}{}", names.empty() ? "" : ", ",
                      posture.row == kNoRow ? "--start" : program_.visits.pose_ids[posture.row]);
    return fmt::format(
        "ways with several postures lead to it (from {}), and its point states none; state it "
        "(KUKA S and T, ABB ConfL \\On, UR qnear), or bring the arm to one posture before it",
        names);
  }

  // Where several ways lead to a row, a joint has a direction there only if it comes from one side
  // by all of them, along the programmed joint angles.
  void find_directions() {
    const auto is_meeting = [&](int node) { return ways_.from(node).size() > 1; };
    if (!motion_matters_ || std::ranges::none_of(ways_.order(), is_meeting)) return;
    directions_.resize(program_.rows());
    std::vector<std::vector<Coming>> comings;
    for (int row = 0; row < program_.rows(); ++row) comings.push_back(comings_to(row));
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const int node : ways_.order()) {
        const int row = ways_.row_of(node);
        if (row == kNoRow) continue;
        for (const auto& [before, moved] : comings[row]) {
          if (before != kNoRow && !directions_[before]) continue;
          Direction came = moved;
          for (size_t j = 0; j < came.size(); ++j)
            if (came[j] == 0 && before != kNoRow) came[j] = (*directions_[before])[j];
          is_changed |= join(came, directions_[row]);
        }
      }
    }
  }

  static constexpr std::int8_t kBothSides = 2;  // or not known by one way
  // A row from which the arm may come, or none, and how its joints move at the end of the way; 0: a
  // joint stands.
  struct Coming {
    int before;
    Direction moved{};
  };
  std::vector<Coming> comings_to(int row) {
    arms_now_ = &arms(row);
    Context context = visits_.context(row);
    context.q = found_[row].own[0].q;
    std::vector<Coming> all;
    for (const int before : ways_.rows_before(ways_.node_of(row))) {
      all.push_back({before});
      if (before == kNoRow) continue;
      const JointVector& from = found_[before].own[0].q;
      const bool is_end_of_arc = motion_to(program_, row).kind == MotionKind::arc && row > 0;
      Arrival arrival(from);
      for (const Waypoint& place :
           way_to(row, context, is_end_of_arc ? found_[row - 1].from : before, from).places)
        arrival.go_to(place.q);
      all.back().moved = arrival.direction();
    }
    return all;
  }

  // Returns whether `all` has changed.
  static bool join(const Direction& one, std::optional<Direction>& all) {
    if (!all) {
      all = one;
      return true;
    }
    const Direction before = *all;
    for (size_t j = 0; j < one.size(); ++j)
      if ((*all)[j] != one[j]) (*all)[j] = kBothSides;
    return *all != before;
  }

  // The last motion to a row in a context, as far as all ways agree on it.
  void arrive(size_t row, const CommandedMotion& motion, std::span<const JointVector> way,
              Context& context) const {
    motion.arrive(context, way);
    if (directions_.empty() || !directions_[row]) return;
    for (int j = 0; j < static_cast<int>(context.q.size()); ++j)
      if ((*directions_[row])[j] == kBothSides) {
        context.arrival[j] = 0;
        context.stroke[j] = 0;
      }
  }

  // The state in which the arm comes to a row.
  void stand_before(int row) {
    const auto from = [&](int of) {
      const int before = of == kNoRow ? kNoRow : found_[of].from;
      return before != kNoRow && targets_[before].q.size() > 0 ? before : kNoRow;
    };
    const auto correction = [&](int of) {
      return of == kNoRow ? std::nullopt
                          : std::optional<JointVector>(targets_[of].q - targets_[of].programmed);
    };
    const int before = from(row);
    reached_.reset();
    if (before != kNoRow) reached_ = targets_[before].programmed;
    last_correction_ = correction(before);
    correction_before_last_ = correction(from(before));
    if (motion_matters_) motion_ = before == kNoRow ? at_begin_ : behind_[before];
  }

  CorrectedTarget target_at(int row) {
    arms_now_ = &arms(row);
    Context context = visits_.context(row);
    CorrectedTarget target;
    stand_before(row);
    target.programmed = found_[row].own[0].q;
    if (program_.is_cartesian(row) && follows_motion(controller().robot())) {
      arrive(row, motion_.commanded, std::span(&target.programmed, 1), context);
      target.programmed = arms_now_->programmed.at(row, context, target.programmed);
    }
    target.q = target.programmed;
    context.q = target.programmed;
    const bool is_arc = motion_to(program_, row).kind == MotionKind::arc && row > 0;
    const ProgrammedWay way = way_to(row, context, found_[is_arc ? row - 1 : row].from, reached_);
    const std::vector<Waypoint>& places = way.places;
    std::vector<JointVector> programmed;
    for (const Waypoint& place : places) programmed.push_back(place.q);
    arrive(row, motion_.programmed, programmed, context);
    motion_.programmed.go_to(programmed);
    const Pose intended = program_.is_cartesian(row) ? wanted_at(row) : controller().pose(context);
    settle(row, target, context, intended, way);
    const std::vector<JointVector> commands = commands_on(way, target);
    motion_.commanded.go_to(commands);
    if (places.size() > 1) target.pace = pace_of(way, commands, target);
    if (motion_matters_) behind_[row] = motion_;
    visits_.arrival[row] = context.arrival;
    visits_.stroke[row] = context.stroke;
    finish(target, context, intended);
    by_unknown_directions_[row] = by_unknown_directions(context, target.q);
    target.reached_q = target.programmed;
    if (!program_.is_cartesian(row))
      if (const JointCorrection there = joints_of_pose(
              controller(), context, arms_now_->options.base * target.reached, target.programmed);
          there.is_reached)
        target.reached_q = there.q;
    return target;
  }

  // R_0 from the TCP that `row` has, as the program has it at another row.
  Pose programmed_pose(size_t other, size_t row) const {
    const Arms &own = arms(row), &of_other = arms(other);
    if (program_.is_cartesian(other))
      return of_other.options.base * program_.poses[other] * inverse(of_other.options.tool) *
             own.options.tool;
    return own.controller.pose(visits_.context(static_cast<int>(other)));
  }

  // The programmed way to a row.
  struct ProgrammedWay {
    std::vector<Waypoint> places;
    double middle = 0;  // of the end of an arc: where on the arc its auxiliary point is
  };

  // From the joint angles `before`; the line or arc begins at the row `start`. The joint angles of
  // the context are those of the row.
  ProgrammedWay way_to(size_t row, const Context& context, int start,
                       const std::optional<JointVector>& before) const {
    std::optional<TcpWay> way;
    if (motion_matters_ && before && start != kNoRow)
      way = tcp_way(program_, row, start, [&](size_t of) { return programmed_pose(of, row); });
    if (!way) return {{{1, context.q}}, 0};
    return {waypoints(controller(), program_, context, *way, {*before, context.q}),
            way->way.arc ? way->from : 0};
  }

  // The parabola through the corrections at the start, the middle and the end of an arc is
  // start + (end - start) t + bend (t - 1) t; zero elsewhere.
  JointVector bend_of_arc(double middle, const JointVector& here) const {
    if (middle == 0 || !correction_before_last_) return JointVector::Zero(here.size());
    const JointVector& start = *correction_before_last_;
    return (start + (here - start) * middle - *last_correction_) / (middle * (1 - middle));
  }

  // Change of the commands at the end of a way, as if it lasted over all of it. The bend of an arc
  // is a guess: a joint whose direction hangs on it has none.
  JointVector pace_of(const ProgrammedWay& way, const std::vector<JointVector>& commands,
                      const CorrectedTarget& target) const {
    const size_t n = commands.size();
    JointVector pace =
        (commands[n - 1] - commands[n - 2]) / (way.places[n - 1].share - way.places[n - 2].share);
    const JointVector of_bend =
        bend_of_arc(way.middle, target.q - target.programmed) * std::pow(1 - way.middle, 2);
    return (pace.array().abs() > of_bend.array().abs()).select(pace, 0);
  }

  // From command to command the correction of the joint angles changes evenly, as far as directions
  // need it. On an arc, which the controller draws through three commands, it changes as the
  // parabola through their corrections.
  std::vector<JointVector> commands_on(const ProgrammedWay& way,
                                       const CorrectedTarget& target) const {
    const JointVector here = target.q - target.programmed;
    const JointVector before = last_correction_.value_or(here);
    const double middle = way.middle;
    const JointVector bend = bend_of_arc(middle, here);
    std::vector<JointVector> commands;
    for (const Waypoint& place : way.places) {
      const double at = middle + place.share * (1 - middle);  // of the arc
      commands.push_back(place.q + before + place.share * (here - before) +
                         (at - middle) * (at - 1) * bend);
    }
    return commands;
  }

  // The arm moves from command to command: the commands, not the program, give its motion. Where a
  // joint reverses, it moves less from point to point than the correction, and commands for either
  // direction are consistent: the direction of the program is tried first, or commands would
  // alternate.
  void settle(size_t row, CorrectedTarget& target, Context& context, const Pose& intended,
              const ProgrammedWay& way) const {
    correct(target, context, intended);
    if (!motion_matters_) return;
    Context assumed;
    for (int k = 0; k < kMostTries; ++k) {
      assumed = context;
      arrive(row, motion_.commanded, commands_on(way, target), context);
      if (context.arrival == assumed.arrival &&
          (context.stroke - assumed.stroke).cwiseAbs().maxCoeff() < kSameStroke)
        return;
      correct(target, context, intended);
    }
    // A command for the mean of both: half of their difference remains on either side.
    for (int j = 0; j < static_cast<int>(context.q.size()); ++j)
      if (context.arrival[j] != assumed.arrival[j]) context.arrival[j] = 0;
    context.stroke = (context.stroke + assumed.stroke) / 2;
    correct(target, context, intended);
    arrive(row, motion_.commanded, commands_on(way, target), context);
    target.notes.push_back(CommandNote::arrival);
  }

  void correct(CorrectedTarget& target, const Context& context, const Pose& intended) const {
    target.notes.clear();
    target.q = target.programmed;
    target.is_corrected = false;
    Context here = context;
    here.q = target.programmed;
    target.before = difference(intended, arm().pose(here));
    const JointCorrection correction =
        correct_joints(arm(), context, intended, target.programmed, controller());
    const KinematicChain& travel = controller().robot().chain;
    // The controller's own inverse kinematics is singular there too.
    const double bend = std::min(arm().wrist_sine_at(target.programmed),
                                 controller().wrist_sine_at(target.programmed));
    if (correction.is_damped || bend < std::sin(kStretchedWrist))
      target.notes.push_back(CommandNote::singular);
    if (!correction.is_reached) {
      target.notes.push_back(CommandNote::unreachable);
    } else if (beyond_travel(travel, correction.q) || beyond_travel(travel, target.programmed)) {
      target.notes.push_back(CommandNote::limit);
    } else if (target.before.position > options_.max_correction) {
      target.notes.push_back(CommandNote::beyond_max);
    } else {
      target.q = correction.q;
      target.is_corrected = true;
      here.q = target.q;
      const PoseDifference rest = difference(intended, arm().pose(here));
      if (correction.is_nearest && std::max(rest.position, rest.orientation) > kGoodEnough)
        target.notes.push_back(CommandNote::fewer_axes);
    }
  }

  // R_0 from the TCP of a Cartesian target.
  Pose wanted_at(int row) const { return arms_now_->options.base * program_.poses[row]; }

  JointVector programmed_at(int row, const Context& context,
                            const std::optional<JointVector>& previous) const {
    const size_t r = row;
    if (program_.is_cartesian(r) && !program_.configurations.empty() && !program_.hinted[r])
      if (const Configuration& stated = program_.configurations[r];
          stated.is_stated() && !(stated.continues && previous))
        if (const auto q = stated_at(row, context, stated, previous)) return *q;
    return arms_now_->programmed.at(row, context, arms_now_->programmed.hint(row, previous));
  }

  // The posture that the target states; nothing if its configuration is weak and no posture has it.
  std::optional<JointVector> stated_at(int row, const Context& context, const Configuration& stated,
                                       const std::optional<JointVector>& previous) const {
    const std::optional<JointVector> before = previous ? previous : options_.start;
    const Pose wanted = wanted_at(row);
    const PostureSearch search(controller(), context, wanted, stated, before);
    if (search.is_one_of_several())
      throw OutOfReach(row,
                       "the controller's model reaches it with its elbow on either side, and which "
                       "one the arm takes is not known; teach the point as joint angles");
    if (const auto q = search.find()) return q;
    if (search.is_reached() && stated.is_weak && previous) return std::nullopt;
    throw OutOfReach(
        row, search.is_reached()
                 ? "the controller's model reaches it, but not in the configuration that the "
                   "program states (KUKA S and T, ABB confdata, FANUC CONFIG); check the frames, "
                   "the tool and --controller"
                 : "the controller's model does not reach it; check the frames, the tool and "
                   "--controller");
  }

  // The figures that follow from the command.
  void finish(CorrectedTarget& target, Context context, const Pose& intended) const {
    const Pose program_from_foot = inverse(arms_now_->options.base);
    target.intended = program_from_foot * intended;
    context.q = target.programmed;
    const Pose reached = arm().pose(context);
    target.before = difference(intended, reached);
    target.reached = program_from_foot * reached;
    context.q = target.q;
    target.after = difference(intended, arm().pose(context));
    target.pose =
        target.is_corrected ? program_from_foot * controller().pose(context) : target.intended;
  }

  // A direction of arrival that is not known counts as 0, the mean of both: the standard deviation
  // of the position about it.
  double by_unknown_directions(Context context, const JointVector& q) const {
    if (!motion_matters_) return 0;
    context.q = q;
    double squares = 0;
    for (int j = 0; j < static_cast<int>(context.q.size()); ++j) {
      if (context.arrival[j] != 0) continue;
      Context up = context, down = context;
      up.arrival[j] = 1;
      down.arrival[j] = -1;
      squares += std::pow(difference(arm().pose(up), arm().pose(down)).position / 2, 2);
    }
    return std::sqrt(squares);
  }

  // Rows with one frame and tool.
  void cover_rows_of(const Arms& own, const Robot& identified) {
    std::vector<int> rows;
    for (int row = 0; row < program_.rows(); ++row)
      if (&arms(row) == &own) rows.push_back(row);
    if (rows.empty()) return;
    const Coverage known = coverage(identified, own.options, visits_.select(rows));
    const double rest = std::sqrt(3.0) * identified.uncertainty->rest;
    for (size_t k = 0; k < rows.size(); ++k)
      cover(rows[k], known.deviation[k],
            std::hypot(rest, known.not_applied[k], by_unknown_directions_[rows[k]]),
            known.leverage[k]);
  }

  void cover(size_t row, double deviation, double rest, double leverage) {
    CorrectedTarget& target = targets_[row];
    target.deviation = std::hypot(deviation, rest);
    target.leverage = leverage;
    if (leverage > 1) target.notes.push_back(CommandNote::outside_readings);
    if (deviation > target.before.position) target.notes.push_back(CommandNote::below_std);
    const bool covered = leverage <= 1 && deviation <= target.before.position;
    if (covered || options_.correct_uncovered || !target.is_corrected) return;
    target.q = target.programmed;
    target.pose = target.intended;
    target.after = target.before;
    target.is_corrected = false;
  }

  const Program& program_;
  const CompensationOptions& options_;
  Campaign visits_;                 // forces in the axes of R_0
  std::deque<Arms> arms_;           // they refer to their own members: they must not move
  const Arms* arms_now_ = nullptr;  // of the row
  bool motion_matters_ = false;
  const RowWays ways_;
  std::vector<std::vector<Posture>> postures_;  // of each node
  std::vector<Found> found_;                    // of each row
  // Of each row: 0 where a joint has not moved; empty: one way leads to each row.
  std::vector<std::optional<Direction>> directions_;
  const Motions at_begin_;
  std::vector<Motions> behind_;  // each row, if motion matters
  Motions motion_;
  std::vector<double> by_unknown_directions_;  // of each row [m]
  std::vector<CorrectedTarget> targets_;
  std::optional<JointVector> reached_;  // joint angles of the row before
  // Corrections of these joint angles, and of those before.
  std::optional<JointVector> last_correction_, correction_before_last_;
};

// The rows of a program on all threads of the machine, if none depends on another.
std::vector<CorrectedTarget> compensate_rows(const Robot& identified, const Robot& controller,
                                             const Program& program,
                                             const CompensationOptions& options) {
  Compensation whole(identified, controller, program, options);
  if (program.rows() < 2 * kRowsPerBlock || whole.motion_matters() || !states_joints(program))
    return whole.run(identified);
  struct Block {
    std::vector<CorrectedTarget> targets;
    std::optional<UnreachableTarget> unreachable;
  };
  std::vector<CorrectedTarget> targets;
  std::optional<UnreachableTarget> unreachable;
  for_ordered_blocks<Block>(
      program.rows(), kRowsPerBlock,
      [&](int begin, int end) {
        std::vector<int> rows(end - begin);
        std::iota(rows.begin(), rows.end(), begin);
        const Program block = select(program, rows);
        try {
          return Block{Compensation(identified, controller, block, options).run(identified), {}};
        } catch (const UnreachableTarget& error) {
          UnreachableTarget of_program(begin + error.row, error.what());
          for (const auto& [row, why] : error.out_of_reach)
            of_program.out_of_reach.emplace_back(begin + row, why);
          return Block{{}, of_program};
        }
      },
      [&](const Block& block) {
        targets.insert(targets.end(), block.targets.begin(), block.targets.end());
        if (!block.unreachable) return;
        if (!unreachable)
          unreachable = block.unreachable;
        else
          std::ranges::copy(block.unreachable->out_of_reach,
                            std::back_inserter(unreachable->out_of_reach));
      });
  if (unreachable) throw *unreachable;
  return targets;
}

}  // namespace

bool may_hold_flange_in_tool(const Robot& controller) {
  constexpr double kRounded = 1e-3;  // of right angles that are written as 1.571 rad or 3.14
  const Link& last = controller.chain.links.back();
  const bool changes_nothing = last.joint == JointKind::fixed && last.alpha == 0 && last.d == 0 &&
                               last.theta == 0 && last.r == 0 && last.beta == 0;
  const Eigen::Matrix3d& turn = controller.chain.tool.rotation;
  const Eigen::Matrix3d rounded = turn.array().round();
  return changes_nothing && !rounded.isIdentity(0) &&
         (turn - rounded).cwiseAbs().maxCoeff() < kRounded;
}

double turn_of_last_frame(const Robot& robot, const Robot& controller) {
  constexpr double kSameAxis = 5 * kDegree;  // more than a calibration turns it
  // Of the last joint and of the last link, from the foot of the arm, in the middle of the travel.
  const auto last_frames = [](const Robot& of) {
    const KinematicChain& chain = of.chain;
    const int joints = joint_count(chain);
    JointVector q = JointVector::Zero(joints);
    for (int j = 0; j < joints; ++j) {
      const auto [low, high] = travel(joint_link(chain, j));
      q[j] = (low + high) / 2;
    }
    const LinkFrames frames = ChainEvaluator(chain).link_frames(q);
    const Pose foot = of.ground_link ? inverse(frames[*of.ground_link]) : Pose{};
    return std::array{foot * frames[link_of_joint(chain, joints - 1)], foot * frames.back()};
  };
  const auto [own_joint, own] = last_frames(robot);
  const auto [joint, link] = last_frames(controller);
  const Eigen::Vector3d own_axis = own_joint.rotation.col(2), axis = joint.rotation.col(2);
  if (std::atan2(own_axis.cross(axis).norm(), own_axis.dot(axis)) > kSameAxis) return 0;
  return rotation_log(own.rotation * link.rotation.transpose()).norm();
}

std::vector<std::string> parameters_of_station(const Robot& robot) {
  std::vector<int> identified;
  if (robot.uncertainty)
    for (const std::string& name : robot.uncertainty->parameters) {
      if (robot.std.empty() || robot.std.contains(name))  // else no pose shows it
        identified.push_back(find_parameter(robot.chain, name).value_or(-1));
    }
  else
    for (const auto& [name, deviation] : robot.std)
      identified.push_back(find_parameter(robot.chain, name).value_or(-1));
  const auto lacks = [&](int first) {
    for (int k = 0; k < 6; ++k)
      if (std::ranges::count(identified, first + k) == 0) return true;
    return false;
  };
  const ParameterLayout layout = layout_of(robot.chain);
  const bool lacks_base = lacks(kFirstBaseParameter), lacks_tool = lacks(layout.tool);
  const int first = link_of_joint(robot.chain, 0);
  const int last = link_of_joint(robot.chain, joint_count(robot.chain) - 1);
  std::vector<std::string> names;
  for (int k : identified) {
    const bool follows_base = k >= kFirstLinkParameter &&
                              k < link_parameter(first + 1, LinkParameter::alpha) && lacks_base;
    const bool follows_tool =
        (k == link_parameter(last, LinkParameter::theta) ||
         k == link_parameter(last, LinkParameter::r) ||
         (k >= link_parameter(last + 1, LinkParameter::alpha) && k < layout.tool)) &&
        lacks_tool;
    if (follows_base || follows_tool) names.push_back(parameter_name(robot.chain, k));
  }
  return names;
}

Robot in_session(Robot robot, const std::string& session) {
  std::string names;
  bool differ = false;
  for (const auto& [name, of] : robot.sessions) {
    names += (names.empty() ? "" : ", ") + name;
    differ |= !of.zero.empty();
  }
  if (session.empty()) {
    if (differ)
      throw std::invalid_argument("its sessions (" + names +
                                  ") have zero offsets of their own; say with --session which of "
                                  "them hold now");
    return robot;
  }
  // Later sessions are forgotten, so that this one is the last that the effects know.
  for (Effect& effect : robot.effects)
    if (std::vector<std::string>& known = effect.driver.sessions;
        std::ranges::find(known, session) != known.end())
      known.erase(std::ranges::find(known, session) + 1, known.end());
  const auto found = robot.sessions.find(session);
  if (found == robot.sessions.end())
    throw std::invalid_argument("has no session '" + session + "'" +
                                (names.empty() ? "" : "; it has " + names));
  for (const auto& [link, zero] : found->second.zero) zero_of(robot.chain.links[link]) = zero;
  return robot;
}

std::vector<CorrectedTarget> compensate(const Robot& identified, const Robot& controller,
                                        const Program& program,
                                        const CompensationOptions& options) {
  for (const Robot* robot : {&identified, &controller})
    require_context(*robot, program.visits, options.tool_is_measured);
  if (!options.tool_is_measured) return compensate_rows(identified, controller, program, options);
  CompensationOptions own = options;
  const Program with_tool = with_measured_tool(identified, program, own);
  return compensate_rows(identified, controller, with_tool, own);
}

}  // namespace armtrue
