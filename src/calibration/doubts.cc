#include "armtrue/calibration/doubts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/number_text.h"

namespace armtrue {
namespace {

constexpr double kNoChance = 1e-3;
constexpr int kFewest = 3;  // visits or readings

// Readings of one pose, one after the other.
struct Visit {
  int first_row, last_row;
  bool is_left_out;
};

std::vector<Visit> visits_of(const Campaign& campaign, const std::vector<bool>& left_out) {
  std::vector<int> order(campaign.rows());
  std::iota(order.begin(), order.end(), 0);
  if (!campaign.time_s.empty())
    std::ranges::stable_sort(order, {}, [&](int row) { return campaign.time_s[row]; });
  std::vector<Visit> visits;
  for (int row : order) {
    if (visits.empty() || campaign.pose[visits.back().last_row] != campaign.pose[row])
      visits.push_back({row, row, false});
    visits.back().last_row = row;
    if (left_out[row]) visits.back().is_left_out = true;
  }
  return visits;
}

// The stretch of visits, from one that is left out to another, that has the most surprising number
// of them: p by the hypergeometric law, times the number of stretches.
std::string in_a_stretch(const Campaign& campaign, const std::vector<bool>& left_out) {
  const std::vector<Visit> visits = visits_of(campaign, left_out);
  const auto all = static_cast<int>(visits.size());
  std::vector<int> left;  // visits that are left out
  for (int k = 0; k < all; ++k)
    if (visits[k].is_left_out) left.push_back(k);
  const auto count = static_cast<int>(left.size());
  double least = kNoChance / (0.5 * all * (all + 1.0));
  int first = -1, last = -1;
  for (int from = 0; from < count; ++from)
    for (int within = kFewest; from + within <= count; within += 1 + within / 8) {
      const int to = from + within - 1, length = left[to] - left[from] + 1;
      if (static_cast<double>(within) * all <= static_cast<double>(count) * length) continue;
      const double p = hypergeometric_at_least(within, length, count, all);
      if (p >= least) continue;
      least = p;
      first = from;
      last = to;
    }
  if (first < 0) return "";
  const auto place = [&](int row) {
    return campaign.time_s.empty() ? fmt::format("line {}", campaign.line[row])
                                   : fmt::format("t_s = {:.10g}", campaign.time_s[row]);
  };
  return fmt::format(
      "readings are left out in {} of {} visits from {} to {}: no blunders, but something that was "
      "off for a while (a brake, a loose tool, somebody at the instrument); find out what it was, "
      "or "
      "measure these poses again",
      last - first + 1, left[last] - left[first] + 1, place(visits[left[first]].first_row),
      place(visits[left[last]].last_row));
}

// Things of one kind, such as targets, of which a reading shows one.
struct Things {
  std::string_view kind, remedy;  // in words
  std::vector<std::string> names{};
  std::vector<int> of_row{};  // index into the names; -1: none
};

Things targets_of(const Campaign& campaign) {
  return {"target", "look whether it is damaged, dirty or loose, or leave its readings out",
          campaign.target_names, campaign.target};
}

// Without images, which show corners one by one.
Things contacts_of(const Campaign& campaign) {
  Things contacts{"contact",
                  "was it moved, or named like another, or is it loose or dirty? Where it was "
                  "moved, give it another name from there on"};
  std::vector<int> of_name;
  for (const std::string& text : campaign.contact_names) {
    const size_t begin = text.find(':') + 1;  // behind the name of a beam, if there is one
    const std::string name = text.substr(begin, text.find('/', begin) - begin);
    const auto known = std::ranges::find(contacts.names, name);
    of_name.push_back(static_cast<int>(known - contacts.names.begin()));
    if (known == contacts.names.end()) contacts.names.push_back(name);
  }
  for (int row = 0; row < campaign.rows() && campaign.has_touches(); ++row)
    contacts.of_row.push_back(
        campaign.kind(row) == ReadingKind::touch ? of_name[campaign.touch[row].contact] : -1);
  return contacts;
}

Things anchors_of(const Campaign& campaign) {
  Things anchors{"anchor",
                 "was it moved, or hung its wire? Where it was moved, give it another name from "
                 "there on",
                 campaign.anchor_names};
  for (int row = 0; row < campaign.rows() && !campaign.anchor.empty(); ++row)
    anchors.of_row.push_back(campaign.kind(row) == ReadingKind::distance ? campaign.anchor[row]
                                                                         : -1);
  return anchors;
}

// Readings of one pose and thing may err together, so they count as one.
std::string on_one_of(const Things& things, const Campaign& campaign,
                      const std::vector<bool>& left_out) {
  const auto number = static_cast<int>(things.names.size());
  if (number < 2 || things.of_row.empty()) return "";
  std::map<std::pair<int, int>, bool> visits;  // by thing and pose, whether one is left out
  for (int row = 0; row < campaign.rows(); ++row)
    if (things.of_row[row] >= 0) visits[{things.of_row[row], campaign.pose[row]}] |= left_out[row];
  std::vector<int> seen(number, 0), left(number, 0);
  for (const auto& [visit, is_left_out] : visits) {
    ++seen[visit.first];
    left[visit.first] += is_left_out;
  }
  const int all = std::accumulate(left.begin(), left.end(), 0);
  const auto count = static_cast<int>(visits.size());
  for (int thing = 0; thing < number; ++thing)
    if (left[thing] >= kFewest &&
        number * hypergeometric_at_least(left[thing], seen[thing], all, count) < kNoChance)
      return fmt::format(
          "in {} of {} poses readings of the {} '{}' are left out, more than of the others: {}",
          left[thing], seen[thing], things.kind, things.names[thing], things.remedy);
  return "";
}

std::string on_one_thing(const Campaign& campaign, const std::vector<bool>& left_out) {
  for (const Things& things : {targets_of(campaign), contacts_of(campaign), anchors_of(campaign)})
    if (std::string words = on_one_of(things, campaign, left_out); !words.empty()) return words;
  return "";
}

}  // namespace

std::string lines_in_words(const std::vector<int>& lines) {
  constexpr size_t kMostShown = 12;
  if (lines.empty()) return "";
  const bool all = lines.size() <= kMostShown;
  return fmt::format("{} of the file{}: {}{}", counted(lines.size(), "line"),
                     all ? "" : ", the first",
                     fmt::join(lines.begin(), all ? lines.end() : lines.begin() + kMostShown, ", "),
                     all ? "" : ", ...");
}

std::string left_out_together(const Campaign& campaign, const std::vector<int>& lines) {
  if (lines.empty()) return "";
  std::vector<bool> left_out(campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row)
    left_out[row] = std::ranges::binary_search(lines, campaign.line[row]);
  const std::string on_thing = on_one_thing(campaign, left_out);
  return on_thing.empty() ? in_a_stretch(campaign, left_out) : on_thing;
}

std::string contradiction_of_noise(const Robot& robot, const Campaign& campaign,
                                   const CalibrationResult& fit, const NoiseFloor& noise) {
  constexpr double kMuchMore = 1.25, kMuchLess = 0.33;  // of the stated one
  if (noise.are_copies)
    return "readings of one pose agree to the last digit, as copies of one do: they "
           "say nothing of the noise and do not count as repeats; give readings of several "
           "visits";
  const bool of_rows = !campaign.sigma_position.empty();
  const double stated =
      of_rows ? median(campaign.sigma_position) : stated_position_noise(robot, campaign);
  const std::string where = campaign.has_pixels_only() ? of_rows ? "sigma_px" : "noise: pixel_px"
                            : campaign.has_pixels()    ? "sigma_mm and sigma_px"
                            : of_rows                  ? "sigma_mm"
                                                       : "noise: position_mm";
  if (stated <= 0) return "";
  const double freedom = noise.degrees_of_freedom, ratio = noise.position / stated;
  // Of replicates the sigma of the rows only weighs them.
  if (noise.source == NoiseFloor::Source::replicates && !of_rows && ratio > kMuchMore &&
      chi_squared_above(freedom * ratio * ratio, freedom) < kNoChance)
    return fmt::format(
        "replicates scatter {:.3g} times as much as the noise that the robot file states, {:.4g} "
        "mm "
        "per axis: the instrument is noisier, or something changes from visit to visit, which all "
        "figures here take for noise",
        ratio, stated / kMillimetre);
  const double left_freedom = noise.axes * campaign.rows() - fit.determined[0];
  // Beside readings that are off by far the width of their law is smaller than the scatter of the
  // others.
  const double scatter = std::max(fit.sigma.position, fit.spread.position), less = scatter / stated;
  if (noise.source == NoiseFloor::Source::instrument && scatter > kFinestReading &&
      less < kMuchLess && left_freedom > 1 &&
      1 - chi_squared_above(left_freedom * less * less, left_freedom) < kNoChance)
    return fmt::format(
        "{} a noise of {:.4g} mm per axis, and the readings scatter by {:.4g} mm about the model: "
        "correct {}, beside which hardly anything can be found",
        of_rows ? "the rows state" : "the robot file states", stated / kMillimetre,
        scatter / kMillimetre, where);
  const double sigma = fit.sigma.position, left = sigma / stated;
  constexpr double kAnotherUnit = 100;  // um, or m, in place of mm are 1000
  if (noise.source == NoiseFloor::Source::instrument && left > kAnotherUnit)
    return fmt::format(
        "{} a noise of {:.4g} mm per axis, and the readings scatter by {:.4g} mm about the best "
        "model, {:.3g} times as much: is it in another unit? Correct {}, or nothing looks "
        "explained",
        of_rows ? "the rows state" : "the robot file states", stated / kMillimetre,
        sigma / kMillimetre, left, where);
  const double turned = robot.noise.orientation;
  if (campaign.has_orientation() && campaign.sigma_orientation.empty() && turned > 0 &&
      noise.source == NoiseFloor::Source::instrument && fit.sigma.orientation > kFinestReading)
    if (const double times = fit.sigma.orientation / turned;
        times > kAnotherUnit || times * kAnotherUnit < 1)
      return fmt::format(
          "the robot file states a noise of {:.4g} mrad per axis, and the orientations scatter by "
          "{:.4g} mrad about the best model: is it in another unit? Correct noise: "
          "orientation_mrad",
          turned / kMilliradian, fit.sigma.orientation / kMilliradian);
  return "";
}

namespace {

constexpr double kFarAbove = 5;
constexpr double kLeastNoise = 1e-6;  // m, rad: below it is a simulation without noise

// In position and orientation.
std::array<double, 2> ratios(const FitQuality& quality) {
  const auto ratio = [](double left, double pure) {
    return pure > 0 ? left / std::max(kLeastNoise, pure) : 0.0;
  };
  return {ratio(quality.left.position, quality.pure.position),
          ratio(quality.left.orientation, quality.pure.orientation)};
}

}  // namespace

double times_of_noise(const FitQuality& quality) {
  const double times = std::ranges::max(ratios(quality));
  return times > kFarAbove ? times : 1;
}

std::string far_above_noise(const FitQuality& quality) {
  const auto [in_position, in_orientation] = ratios(quality);
  const double times = std::max(in_position, in_orientation);
  if (times <= kFarAbove) return "";
  const bool is_of_position = in_position >= in_orientation;
  return fmt::format(
      "the readings scatter about the model by {:.4g} {} per axis, {:.3g} times {}: the model "
      "lacks something, and standard deviations are {:.3g} times as wide for it; close-loop looks "
      "for what it is, or compare zeros and lengths of the robot file with the arm",
      is_of_position ? quality.left.position / kMillimetre
                     : quality.left.orientation / kMilliradian,
      is_of_position ? "mm" : "mrad", times,
      quality.noise.source == NoiseFloor::Source::replicates ? "as much as replicates of a pose"
                                                             : "the stated noise",
      times);
}

void widen_deviations(double factor, CalibrationResult& fit) {
  for (auto& [name, deviation] : fit.robot.std) deviation *= factor;
  for (auto& [name, session] : fit.robot.sessions)
    for (auto& [parameter, deviation] : session.std) deviation *= factor;
  for (Effect& effect : fit.robot.effects)
    for (Coefficient& c : effect.coefficients) {
      c.std *= factor;
      for (double& bound : c.ci95) bound = c.value + factor * (bound - c.value);
    }
}

std::string broken_bounds(const Robot& robot, const Campaign& campaign,
                          const Evaluation& evaluation,
                          const std::vector<Prediction>& predictions) {
  constexpr double kFewInside = 0.8;
  if (!robot.uncertainty || predictions.empty()) return "";
  const auto share_inside = [&](const std::vector<Prediction>& bounds) {
    double inside = 0;
    for (size_t row = 0; row < bounds.size(); ++row)
      inside += evaluation.position[row] <= bounds[row].bound_95;
    return inside / static_cast<double>(bounds.size());
  };
  double inside = share_inside(predictions);
  if (inside >= kFewInside) return "";
  // A noisier instrument is no other arm.
  Robot judged = robot;
  InstrumentNoise& reading = judged.uncertainty->reading;
  const NoiseFloor floor = noise_floor(robot, campaign, evaluation);
  const double usual = floor.median_sigma > 0 ? usual_sigma(campaign) / floor.median_sigma : 1;
  const double noise = usual * floor.position;
  if (noise > reading.position) {
    reading.position = noise;
    inside = share_inside(predict(judged, campaign));
  }
  if (inside >= kFewInside || p_of_errors(judged, campaign) >= kNoChance) return "";
  std::set<int> beyond;
  for (int row = 0; row < campaign.rows(); ++row)
    if (predictions[row].leverage > 1) beyond.insert(campaign.pose[row]);
  const size_t poses = campaign.pose_ids.size();
  return fmt::format(
      "only {:.0f} % of the readings lie within the 95 % bounds that the robot file promises, at "
      "{} poses, which is no chance: {}",
      100 * inside, poses,
      2 * beyond.size() > poses
          ? fmt::format("{} of them lie outside what the calibration measured, where its model "
                        "does not hold; measure there, or look for effects with close-loop",
                        beyond.size())
          : "this is another arm or set-up than the calibrated one, or its model lacks something; "
            "refit base and tool if they are others, or calibrate anew");
}

std::string contradiction_of_uncertainty(const Robot& robot, const Campaign& campaign,
                                         const Evaluation& evaluation) {
  constexpr double kMuchTooLarge = 30;
  if (!robot.uncertainty) return "";
  const MeanSquare stated = mean_square_by_uncertainty(robot, campaign);
  const double seen = summarize(evaluation.position).rms;
  if (stated.expected <= 0 || kMuchTooLarge * seen > std::sqrt(stated.expected)) return "";
  const double squares = stated.freedom * seen * seen / stated.expected;
  if (1 - chi_squared_above(squares, stated.freedom) > kNoChance) return "";
  return fmt::format(
      "by the 'uncertainty' of the robot file positions err by {:.4g} mm (RMS), and they err by "
      "{:.4g} mm, which is no chance: is its 'root' in another unit? Its bounds and deviations say "
      "nothing; calibrate again",
      std::sqrt(stated.expected) / kMillimetre, seen / kMillimetre);
}

std::string not_converged(const CalibrationResult& fit) {
  if (fit.converged) return "";
  return fmt::format(
      "not converged after {} ({}); measure poses that move every joint over its "
      "travel, or identify fewer parameters",
      counted(fit.iterations, "iteration"), fit.termination);
}

std::string lost_in_words(const Robot& robot, const Campaign& campaign,
                          const CalibrationResult& fit) {
  const KinematicChain& chain = robot.chain;
  std::string names;
  for (int k : lost_to_poses(robot, campaign, fit.set))
    names += (names.empty() ? "" : ", ") + parameter_name(chain, k);
  std::vector<std::string> of_tool;
  for (const int k : fit.set.by_small_angles)
    of_tool.push_back(
        shown_by_small_angles(chain, k, fit.robot.chain.tool.translation[k - layout_of(chain).tool],
                              fit.robot.std.at(parameter_name(chain, k))));
  if (!names.empty()) {
    for (const int k : set_up_not_shown(chain, fit.set)) of_tool.push_back(not_shown(chain, k));
    names = "these poses cannot show " + names +
            ", which other poses could; measure poses that move every joint over its travel";
    of_tool.insert(of_tool.begin(), names);
  }
  return fmt::format("{}", fmt::join(of_tool, "; "));
}

std::string near_nominal_in_words(const CalibrationResult& fit, const Campaign& campaign) {
  const NearNominal near = near_nominal(fit, campaign);
  if (near.parameters.empty()) return "";
  std::string names;
  for (int k : near.parameters) names += (names.empty() ? "" : ", ") + fit.names[k];
  return names + ": near the nominal value for lack of readings; " +
         (near.poses > 0
              ? fmt::format("some {} like these would determine them",
                            counted(near.poses, "more pose"))
              : "no number of poses like these would determine them; move every joint over its "
                "travel");
}

std::string far_from_readings(const WeightedZone& zone) {
  if (zone.nearest_outside <= zone.zone.radius) return "";
  return fmt::format(
      "no reading lies in the zone or near it, the nearest {:.4g} mm outside: what the robot will "
      "do there is extrapolated; measure poses in it (plan-poses --zone), or correct --zone, which "
      "is x,y,z,radius in mm in the instrument's frame",
      zone.nearest_outside / kMillimetre);
}

std::string left_out_in_words(const Robot& robot, const LeftOut& left_out) {
  constexpr size_t kNamed = 6;
  std::string names;
  for (size_t k = 0; k < std::min(kNamed, left_out.parameters.size()); ++k)
    names += (k > 0 ? ", " : "") + parameter_name(robot.chain, left_out.parameters[k]);
  if (left_out.parameters.size() > kNamed)
    names += fmt::format(" and {} more", left_out.parameters.size() - kNamed);
  return fmt::format(
      "'identify' of the robot file leaves out parameters that the readings show ({}): the best "
      "values of those that it names leave {:.3g} mm in these poses, all together {:.3g}; no "
      "effect "
      "is named in their place{}, and 'identify: auto' identifies them",
      names, left_out.without / kMillimetre, left_out.with / kMillimetre,
      left_out.beside.empty()
          ? ""
          : fmt::format(" ({} beside them: {})", left_out.beside.size(),
                        to_string(left_out.beside.front().parameter) + " follows " +
                            to_string(left_out.beside.front().driver)));
}

namespace {

// Poses with one cause are one finding. `what`: what becomes of them.
std::vector<std::string> in_words(const std::vector<GrossPose>& gross, std::string_view of_one,
                                  std::string_view of_several) {
  std::vector<std::pair<std::string, std::vector<const GrossPose*>>> causes;
  for (const GrossPose& pose : gross) {
    const auto known = pose.is_explained ? std::ranges::find(causes, pose.likely,
                                                             [](const auto& c) { return c.first; })
                                         : causes.end();
    if (known == causes.end())
      causes.push_back({pose.likely, {&pose}});
    else
      known->second.push_back(&pose);
  }
  std::vector<std::string> sentences;
  for (const auto& [likely, poses] : causes) {
    if (poses.size() == 1) {
      sentences.push_back(fmt::format("all readings of pose {} share an error of {:.4g} mm{}: {}",
                                      poses.front()->id, poses.front()->off / kMillimetre, of_one,
                                      likely));
      continue;
    }
    std::vector<std::string> ids;
    double most = 0;
    for (const GrossPose* pose : poses) {
      ids.push_back(pose->id);
      most = std::max(most, pose->off);
    }
    sentences.push_back(fmt::format("readings of the poses {} are up to {:.4g} mm off{}: {}",
                                    fmt::join(ids, ", "), most / kMillimetre, of_several, likely));
  }
  return sentences;
}

}  // namespace

std::vector<std::string> off_as_wholes(const std::vector<GrossPose>& gross) {
  return in_words(gross, "; it is left out", "; they are left out");
}

std::vector<std::string> off_and_counted(const std::vector<GrossPose>& gross) {
  return in_words(gross, ", which the figures contain", ", which the figures contain");
}

std::vector<std::string> not_shown_by_touches(const Robot& robot, const Campaign& campaign,
                                              const IdentifiableSet& set) {
  if (!campaign.has_touches_only()) return {};
  if (campaign.has_pixels_only())
    return {
        "images do not show where the frame R_A is, nor where the measured frame is on the flange: "
        "'base' and 'tool' are held as the robot file has them, and the places of cameras and "
        "boards are relative to them; the scale is that of the board, whose pitch counts as exact"};
  if (campaign.has_beams_only())
    return {
        "beams do not show where the frame R_A is, nor where the measured frame is on the flange: "
        "'base' and 'tool' are held as the robot file has them, and the places of planes and beams "
        "are relative to them; the scale is that of the sensor, whose readings count as exact but "
        "for noise and a zero"};
  if (campaign.has_profiles())
    return {
        "profiles do not show where the frame R_A is: 'base' is held as the robot file has it, and "
        "the places of the contacts are relative to it; the scale is that of the sensor, whose "
        "readings count as exact but for noise"};
  std::vector<std::string> sentences = {
      "touches do not show where the instrument's frame R_A is: 'base' is held as the robot file "
      "has it, and the places of the contacts are relative to it"};
  const std::optional<int> scale = length_of_scale(robot, campaign, set);
  if (!scale) return sentences;
  const Link& link = robot.chain.links[link_of_parameter(*scale)];
  const double length =
      std::abs(kind_of_parameter(*scale) == LinkParameter::d ? link.d : link.r) / kMillimetre;
  sentences.push_back(fmt::format(
      "touches do not show the scale of the arm: {} is held at its nominal value of {:.6g} mm, and "
      "an error of 1 mm in it is one of {:.3g} % in all lengths, which no standard deviation "
      "counts; touch two points of a known artefact, such as a scale bar",
      parameter_name(robot.chain, *scale), length, 100 / length));
  return sentences;
}

HiddenError hidden_by_refit(const std::vector<std::string>& refit, const Robot& given,
                            const Campaign& campaign) {
  if (refit.empty()) return {};
  constexpr double kMostHidden = 0.2;  // of the RMS error
  Robot fitted = given;
  fitted.identify = refit;
  fitted.identify_per_session.clear();
  fitted.effects.clear();
  const std::vector<int> kept = choose_identifiable(fitted, campaign).kept;
  const bool has_sessions = rows_by_session(campaign).size() > 1;  // each further one has its base
  const double unknowns = has_sessions
                              ? SessionModels(campaign, fitted, kept, {1.0, 1.0}).unknowns()
                              : static_cast<double>(kept.size());
  std::set<std::tuple<int, int, int>> readings;
  for (int row = 0; row < campaign.rows(); ++row)
    readings.emplace(campaign.pose[row], campaign.session.empty() ? 0 : campaign.session[row],
                     campaign.channel(row));
  const double numbers = static_cast<double>(readings.size()) * campaign.reading_size().all();
  const double freedom = std::max(0.0, numbers - unknowns);
  const double left = std::sqrt(freedom / numbers);
  if (1 - left <= kMostHidden) return {unknowns, freedom, ""};
  return {unknowns, freedom,
          fmt::format("--refit {} fits {} unknowns to the {} numbers of these readings "
                      "and so hides about {:.0f} % "
                      "of the error; measure more poses",
                      fmt::join(refit, ","), unknowns, numbers, 100 * (1 - left))};
}

double most_with_hidden(const HiddenError& hidden, double probability) {
  if (hidden.unknowns == 0) return 1;
  if (hidden.freedom == 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(1 + hidden.unknowns / hidden.freedom *
                           fisher_f_quantile(probability, hidden.unknowns, hidden.freedom));
}

}  // namespace armtrue
