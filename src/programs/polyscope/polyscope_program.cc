#include "programs/polyscope/polyscope_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/programs/dialect.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/xml_tags.h"
#include "programs/frame_list.h"
#include "programs/move_reader.h"
#include "programs/point_numbers.h"
#include "programs/text_cursor.h"
#include "programs/ur/urscript_structure.h"

// Programs of PolyScope, the teach pendant of Universal Robots: the tree of a .urp file, in XML. A
// waypoint whose type is Fixed has the joint angles at which it was taught [rad] and its TCP; from
// the joint angles PolyScope computes the pose that it writes into the script of the program. The
// format is known from some 460 public programs of PolyScope 3.5 to 5.25. `crcValue` is equal in
// programs with other waypoints, so it does not depend on them.
//
// PolyScope 3 states of a waypoint its joint angles q, the flange, the TCP and the TCP in the
// feature of its Move, and of the program the arm F (`kinematics`, rows of Denavit and Hartenberg
// with deltaTheta). In 56 of 160 public waypoints F(q) is the flange within 0.0001 mm; the others
// were taught on another arm and miss it by 0.3 to 4 mm. A part that two waypoints have in common
// stands in one of them, and the other refers to it.

namespace armtrue {
namespace {

constexpr size_t kAngles = 6;
constexpr size_t kMostLevels = 1000;  // public programs have 60 at most
constexpr size_t kDepthOfRows = 3;    // URProgram, kinematics, row
// F(q) and the flange of a waypoint that belong together, [m] and [rad].
constexpr double kSamePlace = 1e-5, kSameTurn = 5e-5;

// Whether the text of a Script node drives the arm.
bool names_motion(const std::string& text) {
  bool found = false;
  each_word(text, Statement{1, 0, text.size()},
            [&](const std::string& word, size_t, TextCursor cursor) {
              found |= (is_ur_move(word) || is_other_ur_motion(word)) && cursor.next() == '(';
            });
  return found;
}

class PolyscopeReader : MoveReader {
 public:
  PolyscopeReader(RobotProgram& program, const KnownFrames& known)
      : MoveReader(program), known_(known), text_(program.texts[0].text) {}

  void read() {
    size_t counted = 0;
    for (auto tag = next_tag(text_, 0); tag; tag = next_tag(text_, tag->end)) {
      line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(counted),
                                           text_.begin() + static_cast<std::ptrdiff_t>(tag->begin),
                                           '\n'));
      counted = tag->begin;
      if (!tag->closes) open(*tag);
      if (tag->closes || tag->is_empty) close(*tag);
    }
    program_.warnings = warnings_.list();
    leave_alone(program_, why_left());
  }

 private:
  // An element that is open. `path` names it as references do: Move[2]/children/Waypoint.
  struct Element {
    XmlTag tag;
    std::string path;
    std::map<std::string_view, int> children{};  // so far, by name
  };
  struct Waypoint {
    std::string name, type, path;
    int line = 0;
    std::optional<XmlSpan> angles;
    std::string_view tcp;
    double blend = 0;
    // Beside its joint angles: of the TCP, of the TCP in the feature, of the flange.
    std::optional<XmlSpan> pose, in_feature, flange;
    std::vector<StatedPose> poses{};  // those of them that follow the joint angles
    Pose tool{};                      // by them

    bool states_pose() const { return pose || in_feature || flange; }
  };
  // What the moves of a Move node do.
  struct Move {
    std::string_view type;
    bool has_active_tcp = false;  // drives the TCP that is active when it runs to a stated pose
    bool follows = false;         // the arm stands at the last target
  };
  // A circular move, with its auxiliary point and its end.
  struct Circle {
    size_t first_target;
    int line;
    std::string why_left{};
  };

  std::string path_of(std::string_view name) {
    if (elements_.empty()) return "/" + std::string(name);
    const int number = ++elements_.back().children[name];
    std::string path = elements_.back().path + "/" + std::string(name);
    if (number > 1) path += "[" + std::to_string(number) + "]";
    return path;
  }

  std::string_view parent() const {
    return elements_.size() < 2 ? std::string_view() : elements_[elements_.size() - 2].tag.name;
  }

  void open(const XmlTag& tag) {
    if (elements_.size() == kMostLevels)
      throw InputError(fmt::format("{}:{}: is more than {} levels deep, which no program is",
                                   program_.texts[0].name, line_, kMostLevels));
    elements_.push_back({tag, path_of(tag.name)});
    const std::string_view name = tag.name;
    if (name != "Waypoint" && attribute_span(text_, tag, "reference"))
      refer_to_part(attribute_text(text_, tag, "reference"));
    if (name == "SuppressedNode") {
      ++suppressed_;
    } else if (name == "Move") {
      moves_.push_back({attribute_text(text_, tag, "motionType"),
                        attribute_text(text_, tag, "useActiveTCP") != "false"});
    } else if (name == "CircleMove") {
      circle_ = Circle{program_.targets.size(), line_};
    } else if (name == "Waypoint") {
      open_waypoint(tag);
    } else if (name == "JointAngles" && waypoint_ && parent() == "position") {
      waypoint_->angles = attribute_span(text_, tag, "angles");
    } else if (name == "TCPOffset" && waypoint_ && parent() == "position") {
      waypoint_->tcp = attribute_text(text_, tag, "pose");
    } else if (name == "position" && waypoint_) {
      if (const auto joints = attribute_span(text_, tag, "joints")) waypoint_->angles = joints;
      waypoint_->pose = attribute_span(text_, tag, "pose");
    } else if (name == "poseInFeatureCoordinates" && waypoint_ && parent() == "Waypoint") {
      waypoint_->in_feature = attribute_span(text_, tag, "pose");
    } else if (name == "outputFlangePose" && waypoint_ && parent() == "Waypoint") {
      waypoint_->flange = attribute_span(text_, tag, "pose");
    } else if ((parent() == "kinematics" && elements_.size() == kDepthOfRows) ||
               (parent() == "Kinematics" && waypoint_)) {
      if (const auto value = attribute_span(text_, tag, "value"))
        arm_[name] = values_of(numbers_in(*value));
    } else if (name == "kinematics" || name == "Kinematics") {
      arm_.clear();
    } else if (name == "tcp" && parent() == "Set") {
      sets_tcp_ |= suppressed_ == 0;
    } else if (name == "motionParameters" && waypoint_) {
      const std::string_view blend = attribute_text(text_, tag, "blendRadius");
      waypoint_->blend = TextCursor(blend, 0, blend.size()).take_number().value_or(0);
    } else if (name == "Script") {
      script_.emplace();
    } else if (name == "ExpressionChar" && script_) {
      *script_ += attribute_text(text_, tag, "character");
    } else if (name.ends_with("MoveDirectionNode")) {
      leave_here("its end is a direction, which a condition ends at run time");
    } else if (name == "SafeHome") {
      leave_here("its point is HOME, which the installation declares");
    } else if (stands_where_it_may_move(name)) {
      stop_following();
    }
  }

  // Comments, and what belongs to a waypoint, drive no arm; any other node may.
  bool stands_where_it_may_move(std::string_view name) const {
    return parent() == "children" && name != "Comment";
  }

  void close(const XmlTag& tag) {
    if (elements_.empty() || elements_.back().tag.name != tag.name)
      throw InputError(fmt::format("{}:{}: is no program of PolyScope: </{}> closes nothing",
                                   program_.texts[0].name, line_, tag.name));
    const Element element = std::move(elements_.back());
    elements_.pop_back();
    const std::string_view name = element.tag.name;
    if (name == "SuppressedNode") {
      --suppressed_;
    } else if (name == "Move" && !moves_.empty()) {
      moves_.pop_back();
      stop_following();
    } else if (name == "kinematics" && elements_.size() + 1 < kDepthOfRows) {
      program_.stated_arm = stated_arm();
      note_arm(program_.stated_arm);
    } else if (name == "Kinematics" && waypoint_) {
      note_arm(stated_arm());
    } else if (name == "CircleMove" && circle_) {
      close_circle();
    } else if (name == "Waypoint") {
      if (waypoint_ && waypoint_->path == element.path) close_waypoint();
    } else if (name == "cachedContents" && script_) {
      *script_ += text_.substr(element.tag.end, tag.begin - element.tag.end);
    } else if (name == "Script" && script_) {
      if (names_motion(*script_)) leave_here("its Script node is not followed");
      sets_tcp_ |= suppressed_ == 0 && script_->find("set_tcp") != std::string::npos;
      stop_following();
      script_.reset();
    }
  }

  void stop_following() {
    if (!moves_.empty()) moves_.back().follows = false;
  }

  void leave_here(const std::string& reason) { leave(line_, reason); }

  // Either point of a circular move leaves it alone.
  void leave(int line, const std::string& reason) {
    stop_following();
    if (!circle_)
      leave_move(line, reason, suppressed_ == 0);
    else if (circle_->why_left.empty())
      circle_->why_left = reason;
  }

  void close_circle() {
    const Circle circle = *std::exchange(circle_, std::nullopt);
    std::vector<ProgramTarget>& targets = program_.targets;
    constexpr size_t kPoints = 2;
    if (circle.why_left.empty() && targets.size() - circle.first_target == kPoints) {
      targets[circle.first_target].motion = MotionKind::via;
      targets.back().motion = MotionKind::arc;
      return;
    }
    for (size_t k = circle.first_target; k < targets.size(); ++k) note_name_left(k);
    targets.resize(circle.first_target);
    with_active_tcp_.erase(with_active_tcp_.lower_bound(targets.size()), with_active_tcp_.end());
    leave(circle.line, circle.why_left.empty() ? "it has not two points" : circle.why_left);
  }

  void open_waypoint(const XmlTag& tag) {
    if (attribute_span(text_, tag, "reference"))
      return refer(attribute_text(text_, tag, "reference"));
    const std::string_view type = attribute_text(text_, tag, "type");
    if (type.empty()) return;
    waypoint_ = Waypoint{std::string(attribute_text(text_, tag, "name")), std::string(type),
                         elements_.back().path, line_};
  }

  // A waypoint that stands elsewhere in the tree, and is read or driven to here: it must stay.
  void refer(std::string_view reference) {
    const auto known = waypoints_.find(resolved(reference));
    if (known != waypoints_.end() && suppressed_ == 0) used_.insert(known->second);
    if (!moves_.empty() && parent() == "children")
      leave_here("its waypoint stands in another move");
  }

  // A part of a waypoint that is a part of another one, too: what corrects one would change both.
  void refer_to_part(std::string_view reference) {
    std::string path = resolved(reference);
    for (const char* const part :
         {"/JointAngles", "/position", "/poseInFeatureCoordinates", "/outputFlangePose"})
      if (path.ends_with(part)) {
        path.resize(path.size() - std::string_view(part).size());
        if (const auto known = waypoints_.find(path); known != waypoints_.end())
          used_.insert(known->second);
      }
  }

  // "../../Move/children/Waypoint" from the element that is open.
  std::string resolved(std::string_view reference) const {
    std::vector<std::string> parts;
    const auto add = [&](std::string_view path) {
      for (size_t begin = 0; begin <= path.size();) {
        const size_t end = std::min(path.find('/', begin), path.size());
        const std::string_view part = path.substr(begin, end - begin);
        if (part == ".." && !parts.empty())
          parts.pop_back();
        else if (!part.empty())
          parts.emplace_back(part);
        begin = end + 1;
      }
    };
    add(elements_.back().path);
    add(reference);
    std::string path;
    for (const std::string& part : parts) path += "/" + part;
    return path;
  }

  void close_waypoint() {
    Waypoint waypoint = *std::exchange(waypoint_, std::nullopt);
    const bool is_move =
        !moves_.empty() && !elements_.empty() && elements_.back().tag.name == "children";
    // Of the waypoints of one name PolyScope writes the one that runs into the script.
    const bool is_off = suppressed_ > 0;
    if (!is_move && !is_off) names_elsewhere_.insert(waypoint.name);
    if (const std::string why = why_not(waypoint); !why.empty()) {
      if (is_move) leave(waypoint.line, why);
      if (is_move && !is_off) names_left_.insert(waypoint.name);
      return;
    }
    ProgramPoint point;
    point.name = waypoint.name;
    point.line = waypoint.line;
    point.kind = TargetKind::joints;
    std::tie(point.begin, point.end) = std::pair(waypoint.angles->begin, waypoint.angles->end);
    point.numbers = numbers_in(*waypoint.angles);
    point.poses = waypoint.poses;
    program_.points.push_back(point);
    const int index = static_cast<int>(program_.points.size()) - 1;
    waypoints_[waypoint.path] = index;
    tools_.push_back(waypoint.poses.empty() ? tool_of(waypoint.tcp) : tool_of(waypoint.tool));
    if (is_move)
      add_to_point(index, waypoint.line, waypoint.blend);
    else if (!is_off)
      used_.insert(index);
  }

  // Why a waypoint stays; empty if it does not, and then its poses are found.
  std::string why_not(Waypoint& waypoint) const {
    if (waypoint.type == "Variable") return "its point is a variable, calculated at run time";
    if (waypoint.type != "Fixed") return "its point is relative to others";
    if (!waypoint.angles || numbers_in(*waypoint.angles).size() != kAngles)
      return "it has no plain numbers";
    return waypoint.states_pose() ? why_poses_stay(waypoint) : "";
  }

  // The poses of a waypoint change with its joint angles, if they belong together.
  std::string why_poses_stay(Waypoint& waypoint) const {
    std::vector<std::pair<std::vector<ProgramNumber>, Pose>> stated;
    for (const auto& span : {waypoint.flange, waypoint.pose, waypoint.in_feature}) {
      if (!span) return "it states joint angles and poses, but not all of those that follow them";
      stated.emplace_back(numbers_in(*span), Pose{});
      if (stated.back().first.size() != kAngles) return "it has no plain numbers";
      stated.back().second = program_.dialect->pose_of_numbers(values_of(stated.back().first));
    }
    if (!program_.stated_arm)
      return "the program does not state its arm, by which joint angles and poses belong together";
    JointVector q(kAngles);
    std::ranges::copy(values_of(numbers_in(*waypoint.angles)), q.begin());
    const Pose reached = ChainEvaluator(*program_.stated_arm).pose(q);
    const Pose flange = stated[0].second, pose = stated[1].second, in_feature = stated[2].second;
    const Pose off = inverse(reached) * flange;
    if (!(off.translation.norm() < kSamePlace && rotation_log(off.rotation).norm() < kSameTurn))
      return "its joint angles and its poses are those of two arms; teach it again on this one, or "
             "correct the .script beside it";
    waypoint.tool = inverse(flange) * pose;
    waypoint.poses = {{stated[0].first, Pose{}, off},
                      {stated[1].first, Pose{}, inverse(reached) * pose},
                      {stated[2].first, in_feature * inverse(pose), inverse(reached) * pose}};
    return "";
  }

  // The arm by the rows of `kinematics`; nothing if they are not six of each.
  std::optional<KinematicChain> stated_arm() const {
    KinematicChain rows;
    rows.links.resize(kAngles);
    for (const auto& [name, part] : {std::pair("deltaTheta", &Link::theta),
                                     {"a", &Link::d},
                                     {"d", &Link::r},
                                     {"alpha", &Link::alpha}}) {
      const auto values = arm_.find(name);
      if (values == arm_.end() || values->second.size() != kAngles) return std::nullopt;
      for (size_t i = 0; i < kAngles; ++i) rows.links[i].*part = values->second[i];
    }
    return from_standard(rows);
  }

  void note_arm(const std::optional<KinematicChain>& arm) {
    if (arm && arms_.insert(arm_).second) program_.stated_arms.push_back({line_, *arm});
  }

  // "a, b, c"; nothing of anything else.
  std::vector<ProgramNumber> numbers_in(const XmlSpan& span) const {
    TextCursor cursor(text_, span.begin, span.end);
    std::vector<ProgramNumber> numbers;
    do {
      cursor.next();
      const size_t begin = cursor.at();
      const auto value = cursor.take_number();
      if (!value) return {};
      numbers.push_back({0, begin, cursor.at(), *value, ""});
    } while (cursor.take(','));
    return cursor.done() ? numbers : std::vector<ProgramNumber>();
  }

  int tool_of(const Pose& tool) {
    const std::vector<double> n =
        program_.dialect->numbers_of_pose(tool, std::vector(kAngles, 0.0));
    return add_frame(program_.frames, known_,
                     fmt::format("TCP p[{:.5f}, {:.5f}, {:.5f}, {:.5f}, {:.5f}, {:.5f}]", n[0],
                                 n[1], n[2], n[3], n[4], n[5]),
                     tool);
  }

  int tool_of(std::string_view tcp) {
    const auto begin = static_cast<size_t>(tcp.data() - text_.data());
    if (tcp.empty()) return -1;
    const std::vector<double> values = values_of(numbers_in({begin, begin + tcp.size()}));
    if (values.size() != kAngles) return -1;
    return add_frame(program_.frames, known_, "TCP p[" + std::string(tcp) + "]",
                     program_.dialect->pose_of_numbers(values));
  }

  void add_to_point(int index, int line, double blend) {
    const ProgramPoint& point = program_.points[static_cast<size_t>(index)];
    Move& move = moves_.back();
    ProgramTarget target;
    target.kind = TargetKind::joints;
    target.line = line;
    target.begin = point.begin;
    target.end = point.end;
    target.tool = tools_[static_cast<size_t>(index)];
    target.never_runs = suppressed_ > 0;
    target.follows_target = move.follows;
    target.blend = blend;
    target.motion = motion_of(move.type == "MoveJ" ? 'J' : 'L', true);
    if (target.motion != MotionKind::joint)
      target.obstacle = "PolyScope has its moves in nodes, to which none is added";
    if (move.has_active_tcp && !point.poses.empty() && target.motion != MotionKind::joint)
      with_active_tcp_.insert(program_.targets.size());
    add_target_at(target, index);
    move.follows = !target.never_runs;
  }

  const std::string& name_of(size_t target) const {
    return program_.points[static_cast<size_t>(program_.targets[target].point)].name;
  }

  // A move that runs stays: the waypoint of this name must.
  void note_name_left(size_t target) {
    if (!program_.targets[target].never_runs) names_left_.insert(name_of(target));
  }

  // Targets whose waypoint an expression reads or another move has, too, and poses of a TCP that is
  // not certain. All waypoints of one name are one and the same to PolyScope.
  std::map<size_t, std::string> why_left() {
    std::map<size_t, std::string> why;
    if (sets_tcp_)
      for (const size_t k : with_active_tcp_)
        why[k] =
            "its TCP is not certain: it drives the one that is active, and the program sets one";
    for (size_t k = 0; k < program_.targets.size(); ++k)
      if (used_.contains(program_.targets[k].point) || names_elsewhere_.contains(name_of(k)))
        why[k] = "an expression or another move has its waypoint, too";
    for (const auto& [k, reason] : why) note_name_left(k);
    for (size_t k = 0; k < program_.targets.size(); ++k)
      if (names_left_.contains(name_of(k)))
        why.try_emplace(k, "a move that stays has its waypoint, too");
    return why;
  }

  const KnownFrames& known_;
  const std::string& text_;
  int line_ = 1;  // of the tag that is read
  std::vector<Element> elements_;
  std::vector<Move> moves_;  // in one another
  int suppressed_ = 0;       // nodes that are switched off, in one another
  std::optional<Waypoint> waypoint_;
  std::optional<Circle> circle_;
  std::optional<std::string> script_;
  std::map<std::string, int> waypoints_;   // points, by the paths of their elements
  std::vector<int> tools_;                 // of the points
  std::set<int> used_;                     // points that stand elsewhere, too
  std::set<std::string> names_elsewhere_;  // of waypoints that are written out in expressions
  std::set<std::string> names_left_;       // of waypoints of moves that stay
  // Rows of the arm that is read, by name, and all that were read.
  std::map<std::string_view, std::vector<double>> arm_;
  std::set<std::map<std::string_view, std::vector<double>>> arms_;
  std::set<size_t> with_active_tcp_;                     // targets
  bool sets_tcp_ = false;                                // the program changes the active TCP
};

}  // namespace

void parse_polyscope_program(RobotProgram& program, const KnownFrames& known) {
  PolyscopeReader(program, known).read();
}

}  // namespace armtrue
