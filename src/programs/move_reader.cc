#include "programs/move_reader.h"

#include <utility>

#include "armtrue/programs/dialect.h"
#include "programs/point_numbers.h"
#include "programs/statement.h"

namespace armtrue {

void MoveReader::leave_move(int line, const std::string& reason, bool may_run) {
  warnings_.add(line, "left alone: " + reason);
  if (!may_run) return;
  ++program_.left_alone;
  program_.why_left_alone.push_back(reason);
}

ProgramTarget& MoveReader::add_target_at(ProgramTarget target, int point) {
  target.point = point;
  target.kind = program_.points[point].kind;
  if (target.kind == TargetKind::joints)
    target.q = joints_of_point(*program_.dialect, program_.points[point]);
  else if (target.has_orientation)
    target.pose = program_.dialect->pose_of_numbers(values_of(program_.points[point].numbers));
  if (target.is_inverse) target.pose = inverse(target.pose);
  program_.targets.push_back(std::move(target));
  return program_.targets.back();
}

void MoveReader::find_ways(const ProgramFlow& flow) {
  std::vector<size_t> places;
  for (const ProgramTarget& target : program_.targets) places.push_back(target.begin);
  const auto calls = flow.calls_of_others();
  std::vector<size_t> passed;
  for (const auto& [at, name] : calls) {
    program_.calls_of_others.push_back({line_at(program_.texts[0].text, at), name,
                                        static_cast<int>(places.size() + passed.size())});
    passed.push_back(at);
  }
  program_.routines = flow.routine_names();
  program_.ways = flow.ways(places, passed);
  for (size_t i = 0; i < program_.targets.size(); ++i) {
    program_.targets[i].node = static_cast<int>(i);
    program_.targets[i].never_runs |= program_.ways[i].empty();
  }
}

bool MoveReader::drives_alike(const ProgramTarget& a, const ProgramTarget& b) {
  return a.kind == b.kind && a.base == b.base && a.tool == b.tool && a.is_inverse == b.is_inverse &&
         a.before.translation == b.before.translation && a.is_room_tool == b.is_room_tool &&
         a.near == b.near;
}

MotionKind MoveReader::motion_of(char kind, bool is_last) {
  if (kind == 'L') return MotionKind::line;
  if (kind != 'C') return MotionKind::joint;
  return is_last ? MotionKind::arc : MotionKind::via;
}

}  // namespace armtrue
