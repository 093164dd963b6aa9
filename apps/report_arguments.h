#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/report/report.h"
#include "command_line.h"

namespace armtrue::app {

/// The options of a page, the same for every command that has one.
struct ReportArguments {
  std::string report, plots, about;

  bool is_wanted() const { return !report.empty() || !plots.empty(); }
};

/// --report, --plots and --about; returns the first two. `what`: what the page is about, to follow
/// "Write a page ".
std::vector<Option> add_report(Command& command, ReportArguments& arguments,
                               const std::string& what);

/// Reads --about, if it is given. Call it with the other inputs: a mistake in it shows before hours
/// of work, and page and product name the same inputs.
std::optional<About> read_about(Command& command, const ReportArguments& arguments);

/// The head of the page of a product, which must outlive it, with the warnings so far.
PageHead page_head(const Command& command, const Document& product,
                   const std::optional<About>& about);

/// Writes the page, and the pictures as files of their own. The name of what was written is
/// reported.
void write_report(const Command& command, const ReportArguments& arguments, const Report& report);

}  // namespace armtrue::app
