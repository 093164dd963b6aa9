#pragma once

#include <optional>
#include <string>

#include "armtrue/certification/certificate.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// One HTML page to print on A4 and to sign: what was measured by whom, result, figures, budget,
/// comparison, poses and the SHA-256 of the files. Its numbers are those of armtrue-certificate/1,
/// with the decimals of their uncertainties.
std::string certificate_page(const Certificate& certificate,
                             const std::optional<Comparison>& comparison, const PageHead& head);

/// How many decimals of a mm the largest AP and its U show: those of two significant digits of U,
/// more where AP would read 0, or up to three more where rounding would contradict the decision.
int decimals_shown(const Certificate& certificate);

}  // namespace armtrue
