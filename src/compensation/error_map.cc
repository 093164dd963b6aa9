#include "armtrue/compensation/error_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "compensation/branch.h"
#include "compensation/coverage.h"
#include "compensation/grid_joints.h"
#include "compensation/joint_correction.h"
#include "compensation/near_posture.h"
#include "compensation/programmed_joints.h"
#include "compensation/tcp_way.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kManyMisses = 100;  // targets out of reach, after which fewer starts are tried
constexpr int kFewStarts = 4;

Robot with_effects(Robot robot, std::vector<Effect> effects) {
  robot.effects = std::move(effects);
  return robot;
}

std::vector<Effect> moving_effects(const Robot& robot, bool tool_is_measured) {
  return without_station_effects(robot, tool_is_measured).effects;
}

// Some points, with the parts of the causes in their errors.
struct MappedBlock {
  std::vector<MapPoint> points;
  std::vector<Eigen::Vector3d> parts;
};

// The identified arm and the controller's model, each as a whole, without effects and, of the
// identified arm, with each effect alone.
class ErrorMapper {
 public:
  ErrorMapper(const Robot& identified, const Robot& controller, const CompensationOptions& options,
              const std::vector<std::string>& temperature_names)
      : identified_(identified),
        options_(with_own_tool(options, identified)),
        arm_(identified, options_, options_.tool, temperature_names),
        bare_arm_(with_effects(identified, {}), options_, options_.tool, temperature_names),
        controller_(controller, options_, options_.tool, temperature_names),
        bare_controller_(with_effects(controller, {}), options_, options_.tool, temperature_names) {
    causes_.emplace_back("geometry");
    std::vector<Effect> without_name;
    for (const Effect& effect : moving_effects(identified, options.tool_is_measured)) {
      if (effect.name == kRemainder) {
        without_name.push_back(effect);
        continue;
      }
      single_.emplace_back(with_effects(identified, {effect}), options_, options_.tool,
                           temperature_names);
      causes_.push_back(fmt::format("{} ({} follows {})", effect.name, to_string(effect.parameter),
                                    to_string(effect.driver)));
    }
    if (!without_name.empty()) {
      single_.emplace_back(with_effects(identified, std::move(without_name)), options_,
                           options_.tool, temperature_names);
      causes_.emplace_back("what the arm does without a name");
    }
    controller_has_effects_ = !moving_effects(controller, options.tool_is_measured).empty();
    if (controller_has_effects_) causes_.emplace_back("effects of the controller's model");
  }

  const std::vector<std::string>& causes() const { return causes_; }
  size_t effects() const { return single_.size(); }
  const ProgramArm& controller() const { return controller_; }
  bool motion_matters() const {
    return follows_motion(arm_.robot()) || follows_motion(controller_.robot());
  }
  const CompensationOptions& options() const { return options_; }

  // `visits`: a row for each point, of which those without joint angles are not read; forces in the
  // axes of R_0.
  MappedBlock block(std::vector<MapPoint> points, const Campaign& visits) const {
    MappedBlock mapped{std::move(points), {}};
    mapped.parts.assign(mapped.points.size() * causes_.size(), Eigen::Vector3d::Zero());
    std::vector<int> rows;
    for (size_t k = 0; k < mapped.points.size(); ++k) {
      MapPoint& point = mapped.points[k];
      if (!point.q) {
        point.notes.push_back(CommandNote::unreachable);
      } else if (beyond_travel(controller_.robot().chain, *point.q)) {
        point.notes.push_back(CommandNote::limit);
      } else {
        Context context = visits.context(static_cast<int>(k));
        context.q = *point.q;
        predict(context, point, mapped.parts.data() + k * causes_.size());
        if (has_fewer_axes(arm_)) leave_rest(context, point);
        rows.push_back(static_cast<int>(k));
      }
    }
    cover(mapped.points, rows, visits);
    return mapped;
  }

 private:
  static CompensationOptions with_own_tool(CompensationOptions options, const Robot& identified) {
    if (options.tool_is_measured) options.tool = identified.chain.tool;
    return options;
  }

  void predict(const Context& context, MapPoint& point, Eigen::Vector3d* parts) const {
    const Eigen::Matrix3d program_from_foot = options_.base.rotation.transpose();
    const Pose arm = arm_.pose(context), bare_arm = bare_arm_.pose(context);
    const Pose controller = controller_.pose(context);
    const Pose bare_controller = bare_controller_.pose(context);
    const auto between = [&](const Pose& from, const Pose& to) -> Eigen::Vector3d {
      return program_from_foot * (to.translation - from.translation);
    };
    point.is_predicted = true;
    point.error = between(controller, arm);
    point.turn = difference(controller, arm).orientation;
    point.left_by_constants = between(bare_arm, arm).norm();
    *parts++ = between(bare_controller, bare_arm);
    for (const ProgramArm& single : single_) *parts++ = between(bare_arm, single.pose(context));
    if (controller_has_effects_) *parts++ = between(controller, bare_controller);
    const double bend =
        std::min(arm_.wrist_sine_at(context.q), controller_.wrist_sine_at(context.q));
    if (bend < std::sin(kSingularWrist)) point.notes.push_back(CommandNote::singular);
  }

  // What an arm of fewer than six axes cannot correct.
  void leave_rest(const Context& context, MapPoint& point) const {
    const Pose wanted = controller_.pose(context);
    const JointCorrection correction = correct_joints(arm_, context, wanted, *point.q, controller_);
    Context corrected = context;
    if (correction.is_reached) corrected.q = correction.q;
    point.rest = difference(wanted, arm_.pose(corrected));
    if (std::max(point.rest.position, point.rest.orientation) > kGoodEnough)
      point.notes.push_back(CommandNote::fewer_axes);
  }

  void cover(std::vector<MapPoint>& points, const std::vector<int>& rows,
             const Campaign& visits) const {
    if (!identified_.uncertainty || rows.empty()) return;
    Campaign reached = visits.select(rows);
    for (size_t k = 0; k < rows.size(); ++k) reached.q[k] = *points[rows[k]].q;
    const Coverage known = coverage(identified_, options_, reached);
    const double scatter = identified_.uncertainty->reading.position;
    for (size_t k = 0; k < rows.size(); ++k) {
      MapPoint& point = points[rows[k]];
      point.deviation = std::hypot(known.deviation[k], known.not_applied[k]);
      point.leverage = known.leverage[k];
      point.after = std::hypot(*point.deviation, std::sqrt(3.0) * scatter, point.rest.position);
      if (known.leverage[k] > 1) point.notes.push_back(CommandNote::outside_readings);
    }
  }

  const Robot& identified_;
  CompensationOptions options_;
  ProgramArm arm_, bare_arm_, controller_, bare_controller_;
  std::vector<ProgramArm> single_;
  std::vector<std::string> causes_;
  bool controller_has_effects_ = false;
};

// Predicts all points on all cores. `visits_of(begin, end)` gives the rows of some of them.
template <typename VisitsOf>
void predict_all(ErrorMap& map, const ErrorMapper& mapper, const VisitsOf& visits_of) {
  map.causes = mapper.causes();
  map.effects = mapper.effects();
  std::vector<MapPoint> points;
  points.swap(map.points);
  for_ordered_blocks<MappedBlock>(
      static_cast<int>(points.size()), kRowsPerBlock,
      [&](int begin, int end) {
        return mapper.block({points.begin() + begin, points.begin() + end}, visits_of(begin, end));
      },
      [&](const MappedBlock& block) {
        map.points.insert(map.points.end(), block.points.begin(), block.points.end());
        map.parts.insert(map.parts.end(), block.parts.begin(), block.parts.end());
      });
}

// From the sample before. The first one comes from the start, with any whole turns.
std::optional<JointVector> along_path(const ErrorMapper& mapper, const Context& context,
                                      const Pose& sample, const JointVector& from, bool is_first) {
  const NearPosture posture(
      mapper.controller(), from,
      is_first ? NearPosture::Turns::within_travel : NearPosture::Turns::nearest);
  return posture.reach(context, mapper.options().base * sample, from);
}

// Joint angles on the way to a row, those of the row itself the last: on a line a joint may
// reverse.
std::vector<JointVector> way_to_row(const Program& program, const ErrorMapper& mapper, size_t row,
                                    const Context& context,
                                    const std::optional<JointVector>& previous,
                                    const JointVector& q) {
  std::optional<TcpWay> way;
  if (mapper.motion_matters() && previous && program.is_cartesian() && row > 0)
    way = tcp_way(program, row, row - 1,
                  [&](size_t of) { return mapper.options().base * program.poses[of]; });
  if (!way) return {q};
  std::vector<JointVector> places;
  for (const Waypoint& place :
       waypoints(mapper.controller(), program, context, *way, {*previous, q}))
    places.push_back(place.q);
  return places;
}

// Goes through a program and writes joint angles, directions of arrival and strokes into `visits`.
std::vector<MapPoint> points_of(const Program& program, const ErrorMapper& mapper,
                                Following following, Campaign& visits) {
  const ProgrammedJoints programmed(program, mapper.options(), mapper.controller());
  CommandedMotion motion(visits);
  for (Eigen::Vector3d& force : visits.force_n) force = mapper.options().base.rotation * force;
  visits.arrival.resize(visits.q.size(), Direction{});
  visits.stroke.resize(visits.q.size(),
                       JointVector::Zero(visits.q.empty() ? kMaxJoints : visits.q.front().size()));
  const Pose program_from_foot = inverse(mapper.options().base);
  std::vector<MapPoint> points(visits.q.size());
  std::optional<JointVector> previous;
  int misses = 0;
  for (int row = 0; row < program.rows(); ++row) {
    const size_t r = row;
    MapPoint& point = points[r];
    if (program.is_cartesian()) point.position = program.poses[r].translation;
    Context context = visits.context(row);
    const JointVector hint = programmed.hint(row, previous);
    motion.arrive(context, hint);
    if (following == Following::continuous && program.is_cartesian() && !program.hinted[r])
      point.q = along_path(mapper, context, program.poses[r], hint, !previous);
    try {
      if (!point.q)
        point.q = programmed.at(row, context, hint, misses < kManyMisses ? kAllStarts : kFewStarts);
    } catch (const OutOfReach&) {
      if (!previous) previous = hint;
      ++misses;
      continue;
    }
    const std::vector<JointVector> way =
        way_to_row(program, mapper, r, context, previous, *point.q);
    previous = point.q;
    motion.arrive(context, way);
    motion.go_to(way);
    visits.arrival[r] = context.arrival;
    visits.stroke[r] = context.stroke;
    context.q = *point.q;
    if (!program.is_cartesian())
      point.position = program_from_foot * mapper.controller().pose(context).translation;
  }
  return points;
}

}  // namespace

std::array<int, 3> Grid::place(int point) const {
  return {point % count[0], point / count[0] % count[1], point / (count[0] * count[1])};
}

int Grid::point(const std::array<int, 3>& place) const {
  return place[0] + count[0] * (place[1] + count[1] * place[2]);
}

double Grid::coordinate(int axis, int place) const {
  const int last = count[axis] - 1;
  if (last == 0) return 0.5 * (low[axis] + high[axis]);
  return place == last ? high[axis] : low[axis] + (high[axis] - low[axis]) * place / last;
}

Eigen::Vector3d Grid::position(int point) const {
  const auto [x, y, z] = place(point);
  return {coordinate(0, x), coordinate(1, y), coordinate(2, z)};
}

bool MapPoint::has(CommandNote note) const { return std::ranges::find(notes, note) != notes.end(); }

ErrorMap map_errors(const Robot& identified, const Robot& controller, const Program& program,
                    const CompensationOptions& options, Following following) {
  for (const Robot* robot : {&identified, &controller})
    require_context(*robot, program.visits, options.tool_is_measured);
  const ErrorMapper mapper(identified, controller, options, program.visits.temperature_names);
  ErrorMap map;
  for (int pose : program.visits.pose) map.names.push_back(program.visits.pose_ids[pose]);
  Campaign visits = program.visits;
  map.points = points_of(program, mapper, following, visits);
  predict_all(map, mapper, [&](int begin, int end) {
    std::vector<int> rows;
    for (int row = begin; row < end; ++row) rows.push_back(row);
    return visits.select(rows);
  });
  return map;
}

ErrorMap map_errors(const Robot& identified, const Robot& controller, const Grid& grid,
                    const Campaign& conditions, const CompensationOptions& options) {
  Campaign still = conditions;
  for (const Robot* robot : {&identified, &controller})
    require_context(*robot, still, options.tool_is_measured);
  still.arrival.assign(1, Direction{});
  still.stroke.assign(1, JointVector::Zero(kMaxJoints));
  const ErrorMapper mapper(identified, controller, options, still.temperature_names);
  const Context context = still.context(0);
  ErrorMap map;
  map.grid = grid;
  const auto joints =
      grid_joints(mapper.controller(), context, grid, options.base, options.start.value());
  for (int k = 0; k < grid.points(); ++k) {
    map.names.push_back(std::to_string(k + 1));
    MapPoint& point = map.points.emplace_back();
    point.position = grid.position(k);
    point.q = joints[k];
  }
  predict_all(map, mapper,
              [&](int begin, int end) { return still.select(std::vector<int>(end - begin, 0)); });
  return map;
}

const std::vector<CommandNote>& map_notes() {
  static const std::vector<CommandNote> all{CommandNote::unreachable, CommandNote::limit,
                                            CommandNote::singular, CommandNote::outside_readings,
                                            CommandNote::fewer_axes};
  return all;
}

int count_of(const ErrorMap& map, CommandNote note) {
  return static_cast<int>(
      std::ranges::count_if(map.points, [&](const MapPoint& point) { return point.has(note); }));
}

}  // namespace armtrue
