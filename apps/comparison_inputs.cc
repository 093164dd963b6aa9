#include "comparison_inputs.h"

namespace armtrue::app {

void add_comparison_options(Command& command, ComparisonArguments& arguments) {
  command.add_input("The later run: a calibrated robot, a loop or an evaluation");
  command.add_output(ProductKind::document);
  command
      .file("--before", arguments.before,
            "The earlier run, or the other model of the same readings; a document of the same kind")
      .required();
  const Option loop_before =
      command.file("--loop-before", arguments.loop_before,
                   "Loop document of the earlier robot: error and verdict are compared, too");
  const Option loop = command.file("--loop", arguments.loop, "Loop document of the later robot");
  loop_before.needs(loop);
  loop.needs(loop_before);
  command.flag("--two-arms", arguments.two_arms,
               "The runs are of two arms of one type, not of one arm at two times: what differs, "
               "and by how much a program of one errs on the other");
  command.file("--poses", arguments.poses,
               "Joint targets at which the arms are compared [200 poses over the travel of the "
               "joints that both runs cover]");
  command
      .option("--max-change-mm", arguments.max_change_mm,
              "Exit with 3 if the arms differ by more than this on average")
      .check(above_zero());
  command.flag(
      "--require-unchanged", arguments.require_unchanged,
      "Exit with 3 if the arm changed by more than chance (--two-arms: they differ), or if "
      "that cannot be tested or is undecided");
  add_report(command, arguments.page, "with the changes and their intervals");
}

}  // namespace armtrue::app
