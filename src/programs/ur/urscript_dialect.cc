
#include "programs/dialects.h"
#include "programs/insertion.h"
#include "programs/point_numbers.h"
#include "programs/statement.h"
#include "programs/ur/urscript_program.h"
#include "programs/ur/urscript_structure.h"

namespace armtrue {
namespace {

class UrWriter : public MoveWriter {
 public:
  using MoveWriter::MoveWriter;
  std::string ending(double blend) const override {
    constexpr int kDecimals = 5;
    return rounded_text(blend, 1, kDecimals) + ")";
  }
};

class UrscriptDialect : public Dialect {
 public:
  UrscriptDialect()
      : Dialect({.name = "urscript",
                 .maker = "UR",
                 .endings = {".SCRIPT", ".URSCRIPT"},
                 .comment = '#',
                 .length = 1,
                 .angle = 1,
                 .tool = "its TCP",
                 .sets_active_tool = "set_tcp",
                 .has_frames_in_base = true}) {}

  void parse(RobotProgram& program, const KnownFrames& known, TargetParts parts) const override {
    parse_urscript_program(program, known, parts);
  }

  // x y z rx ry rz
  Pose pose_of_numbers(const std::vector<double>& n) const override {
    return {rotation_exp({n[3], n[4], n[5]}), Eigen::Vector3d(n[0], n[1], n[2])};
  }
  std::vector<double> numbers_of_pose(const Pose& pose,
                                      const std::vector<double>& written) const override {
    const Eigen::Vector3d& p = pose.translation;
    const Eigen::Vector3d v =
        rotation_vector_near(pose.rotation, {written[3], written[4], written[5]});
    return {p[0], p[1], p[2], v[0], v[1], v[2]};
  }

  int decimals(TargetKind, size_t) const override { return 7; }

  // `end` ends blocks, too.
  std::optional<OpenPart> open_part(const std::string& text) const override {
    std::string plain = masked(text, facts().comment, "\"'");
    const std::vector<Statement> statements = split_statements(plain, '\n');
    const auto open = structure_of_urscript(plain, statements).open;
    return open ? std::optional(OpenPart{*open, "end"}) : std::nullopt;
  }

  std::unique_ptr<MoveWriter> move_writer(const RobotProgram& program) const override {
    return std::make_unique<UrWriter>(program);
  }

 protected:
  bool begins_program(const std::string& word) const override { return word == "DEF"; }
};

}  // namespace

const Dialect& urscript_dialect() {
  static const UrscriptDialect dialect;
  return dialect;
}

}  // namespace armtrue
