#include "programs/insertion.h"

#include <algorithm>
#include <utility>

#include "armtrue/programs/dialect.h"
#include "programs/statement.h"

namespace armtrue {

std::string MoveWriter::inserted_point(const ProgramPoint& point,
                                       const std::vector<TextEdit>& changes) {
  return on_one_line(changed(point, changes));
}

std::string MoveWriter::own_point(const ProgramTarget& target,
                                  const std::vector<TextEdit>& changes) {
  return inserted_point(program_.points[target.point], changes);
}

std::string MoveWriter::placed(const std::string& text) { return on_one_line(text); }

std::string MoveWriter::ending(double) const { return ""; }

void MoveWriter::insert(const Move& move) { replace(move.at, move.at, move.head + move.rest); }

std::vector<TextEdit> MoveWriter::take() {
  finish();
  return std::move(edits_);
}

std::string MoveWriter::changed(const ProgramPoint& point, std::vector<TextEdit> edits) const {
  for (TextEdit& edit : edits) {
    edit.begin -= point.begin;
    edit.end -= point.begin;
  }
  const std::string& text = program_.texts[point.text].text;
  return apply_edits(text.substr(point.begin, point.end - point.begin), edits, point.text);
}

// Without comments.
std::string MoveWriter::on_one_line(std::string point) const {
  point = masked(point, program_.dialect->facts().comment, "");
  std::ranges::replace_if(
      point, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return point;
}

int moves_of(const std::vector<ProgramPointBetween>& between) {
  return static_cast<int>(std::ranges::count_if(
      between, [](const auto& point) { return point.motion != MotionKind::via; }));
}

std::vector<TextEdit> insertion_edits(const RobotProgram& program,
                                      const std::vector<ProgramPointBetween>& between,
                                      const std::vector<std::vector<TextEdit>>& changes,
                                      const std::vector<OwnPoint>& own) {
  if (between.empty() && own.empty()) return {};
  const std::unique_ptr<MoveWriter> writer = program.dialect->move_writer(program);
  for (const OwnPoint& point : own) {
    const ProgramTarget& target = program.targets[point.target];
    writer->replace(
        target.begin, target.end,
        point.text.empty() ? writer->own_point(target, point.changes) : writer->placed(point.text));
  }
  std::string via;
  for (size_t i = 0; i < between.size(); ++i) {
    const ProgramPointBetween& point = between[i];
    const ProgramTarget& target = program.targets[point.target];
    if (point.is_left_out) {
      const ProgramTarget& end = program.targets[point.target + 1];
      writer->replace(end.insertion.at, end.begin, end.insertion.before_line);
      continue;
    }
    const std::string text = writer->inserted_point(program.points[target.point], changes[i]);
    if (point.motion == MotionKind::via) {
      if (i + 1 < between.size() && between[i + 1].target == point.target + 1)
        via = text + program.targets[point.target + 1].insertion.middle;
      else
        writer->replace(target.begin, target.end, text);
      continue;
    }
    const ProgramInsertion& beside = target.insertion;
    const bool is_piece = point.motion == MotionKind::line && target.motion == MotionKind::arc;
    writer->insert({beside.at, is_piece ? beside.before_line : beside.before,
                    via + text + beside.behind + writer->ending(point.blend) + beside.line_end});
    via.clear();
  }
  return writer->take();
}

}  // namespace armtrue
