#include "report_arguments.h"

#include "armtrue/io/output_folder.h"

namespace armtrue::app {

std::vector<Option> add_report(Command& command, ReportArguments& arguments,
                               const std::string& what) {
  const Option report =
      command.add_output("--report", arguments.report, "Write a page " + what + " here (HTML)");
  const Option plots = command.add_output_folder(
      "--plots", arguments.plots,
      "Write the pictures of the page into this folder, each as an SVG file; what armtrue wrote "
      "there before is replaced");
  command
      .file("--about", arguments.about,
            "Robot, operator, date and instrument for the head of the page (armtrue-about/1)")
      .needs(report);
  return {report, plots};
}

std::optional<About> read_about(Command& command, const ReportArguments& arguments) {
  if (arguments.about.empty()) return std::nullopt;
  return command.read_about(arguments.about);
}

PageHead page_head(const Command& command, const Document& product,
                   const std::optional<About>& about) {
  return {product, command.provenance().warnings, about, command.arm_in_doubt};
}

void write_report(const Command& command, const ReportArguments& arguments, const Report& report) {
  if (!arguments.report.empty()) {
    write_output(arguments.report, report.html);
    command.report_written(arguments.report);
  }
  if (arguments.plots.empty()) return;
  std::vector<Product> pictures;
  for (const PictureFile& picture : report.pictures)
    pictures.push_back({picture.name, picture.text});
  replace_folder(arguments.plots, pictures);
  command.report("wrote " + std::to_string(pictures.size()) + " pictures into " + arguments.plots +
                 "\n");
}

}  // namespace armtrue::app
