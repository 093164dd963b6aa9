#include "report/residual_pictures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kHistogramBins = 40;
constexpr Eigen::Index kMostReadings = 800;  // in one picture

double in_mm(double metres) { return metres / kMillimetre; }

double largest_error(const std::vector<Judged>& models) {
  double largest = 0;
  for (const Judged& model : models)
    for (double error : model.evaluation.reading_errors()) largest = std::max(largest, error);
  return in_mm(largest);
}

// " Of 12000 readings 800 are drawn, evenly spread.", or nothing if all are.
std::string thinned_note(Eigen::Index all, size_t drawn, const std::string& what) {
  if (std::cmp_equal(drawn, all)) return "";
  return fmt::format(" Of {} {} {} are drawn, evenly spread.", all, what, drawn);
}

// Mean residual and mean place by pose and target, in the order of the first visits.
struct PlacedResiduals {
  std::vector<std::string> names;
  std::vector<Eigen::Vector3d> places;
  std::vector<std::vector<Eigen::Vector3d>> residuals;  // per model
};

PlacedResiduals by_pose(const std::vector<Judged>& models, const Campaign& campaign) {
  std::map<std::array<int, 3>, size_t> number;
  std::vector<double> counts;
  PlacedResiduals placed;
  placed.residuals.resize(models.size());
  for (int row = 0; row < campaign.rows(); ++row) {
    const size_t r = row;
    const auto [at, is_new] =
        number.try_emplace({campaign.pose[r], campaign.channel(row),
                            campaign.session.empty() ? 0 : campaign.session[r]},
                           counts.size());
    const size_t k = at->second;
    if (is_new) {
      counts.push_back(0);
      placed.names.push_back("pose " + campaign.pose_ids[campaign.pose[r]]);
      placed.places.emplace_back(Eigen::Vector3d::Zero());
      for (auto& residuals : placed.residuals) residuals.emplace_back(Eigen::Vector3d::Zero());
    }
    counts[k] += 1;
    placed.places[k] += campaign.position[r];
    for (size_t m = 0; m < models.size(); ++m)
      placed.residuals[m][k] += models[m].evaluation.residuals[r].head<3>();
  }
  for (size_t k = 0; k < counts.size(); ++k) {
    placed.places[k] /= counts[k];
    for (auto& residuals : placed.residuals) residuals[k] /= counts[k];
  }
  return placed;
}

// The worst poses by the largest error of their readings: "Worst, with its effects: pose P7
// (0.42 mm), ..."
std::string worst_poses(const Judged& model, const Campaign& campaign) {
  constexpr size_t kShown = 5;
  std::map<std::string, double> worst;
  const std::vector<double> errors = model.evaluation.reading_errors();
  for (size_t reading = 0; reading < errors.size(); ++reading) {
    double& of_pose = worst[reading_name(campaign, model.evaluation, reading)];
    of_pose = std::max(of_pose, errors[reading]);
  }
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [name, error] : worst) order.emplace_back(-error, name);
  std::ranges::sort(order);
  std::vector<std::string> texts;
  for (size_t k = 0; k < std::min(kShown, order.size()); ++k)
    texts.push_back(fmt::format("{} ({:.3g} mm)", order[k].second, in_mm(-order[k].first)));
  return fmt::format("Worst, {}: {}.", model.name, fmt::join(texts, ", "));
}

}  // namespace

std::string reading_name(const Campaign& campaign, const Evaluation& evaluation, size_t reading) {
  const size_t row = evaluation.first_rows.empty() ? reading : evaluation.first_rows[reading];
  return "pose " + campaign.pose_ids[campaign.pose[row]];
}

double round_magnification(double longest, double extent) {
  constexpr double kShareOfExtent = 0.2;
  if (!(longest > 0) || !(extent > 0)) return 1;
  const double wanted = kShareOfExtent * extent / longest;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  const double digit = wanted / decade;
  return std::max(1.0, decade * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1));
}

Drawing histogram_picture(const std::vector<Judged>& models, const std::string& readings) {
  const Axis x = round_axis(0, largest_error(models), "length of the error, mm");
  const double width = x.high / kHistogramBins;
  auto picture = std::make_shared<Picture>(
      "histogram", "How large the errors are",
      "Number of " + readings + " with an error of this size, one row for each model.", x);
  for (const Judged& model : models) {
    std::vector<double> counts(kHistogramBins, 0);
    for (double error : model.evaluation.reading_errors())
      ++counts[static_cast<size_t>(
          std::min<double>(kHistogramBins - 1, std::floor(in_mm(error) / width)))];
    std::vector<std::string> texts;
    for (int k = 0; k < kHistogramBins; ++k)
      texts.push_back(
          fmt::format("{:.3g} to {:.3g} mm: {:g}", k * width, (k + 1) * width, counts[k]));
    Panel& panel = picture->panel(count_axis(std::ranges::max(counts), "", 3), 74);
    panel.bars(0, width, counts, texts, model.look, "");
    panel.rule_x(in_mm(summarize(model.evaluation.reading_errors()).mean), Look::mark, "mean");
    panel.corner(model.name);
  }
  return picture;
}

Drawing axes_picture(const std::vector<Judged>& models, const Campaign& campaign) {
  double low = 0, high = 0;
  std::vector<std::vector<AxisErrors>> axes;
  for (const Judged& model : models) {
    axes.push_back(axis_errors(model.evaluation, campaign));
    for (const AxisErrors& axis : axes.back()) {
      low = std::min(low, in_mm(axis.min));
      high = std::max(high, in_mm(axis.max));
    }
  }
  const double count = static_cast<double>(axes.front().size());
  auto picture = std::make_shared<Picture>(
      "axes", "Mean and range along each axis",
      "Mean (mark), smallest and largest (ends) of the errors along each axis of the instrument's "
      "frame.",
      Axis{0, count, 1, ""});
  Panel& panel = picture->panel(round_axis(low, high, "error, mm"), 200);
  panel.rule_y(0, Look::mark, "");
  std::vector<std::pair<double, std::string>> words;
  for (int k = 0; k < std::ssize(axes.front()); ++k) {
    words.emplace_back(k + 0.5,
                       axes[0][k].axis == 'l' ? "length" : std::string(1, axes[0][k].axis));
    for (int m = 0; m < std::ssize(models); ++m) {
      const double place = k + (m + 1) / (static_cast<double>(models.size()) + 1);
      const AxisErrors& axis = axes[m][k];
      panel.range(
          place, in_mm(axis.min), in_mm(axis.mean), in_mm(axis.max), models[m].look, models[m].name,
          fmt::format("{}, {}: mean {:.3g}, from {:.3g} to {:.3g} mm", models[m].name,
                      words.back().second, in_mm(axis.mean), in_mm(axis.min), in_mm(axis.max)));
    }
  }
  picture->words(std::move(words));
  return picture;
}

namespace {

// Of each reading, whether any of its rows is left out; empty if none is.
std::vector<bool> of_readings(const std::vector<bool>& left_out, const std::vector<int>& first) {
  if (left_out.empty() || first.empty()) return left_out;
  std::vector<bool> readings(first.size());
  size_t reading = 0;
  for (int row = 0; row < std::ssize(left_out); ++row) {
    if (reading + 1 < first.size() && row == first[reading + 1]) ++reading;
    if (left_out[row]) readings[reading] = true;
  }
  return readings;
}

}  // namespace

Drawing campaign_picture(const std::vector<Judged>& models, const Campaign& campaign,
                         const std::vector<bool>& left_out_rows) {
  const Evaluation& first = models.front().evaluation;
  const std::vector<bool> left_out = of_readings(left_out_rows, first.first_rows);
  const auto rows = std::ssize(first.reading_errors());
  const std::vector<int> drawn = evenly(rows, kMostReadings);
  auto picture = std::make_shared<Picture>(
      "campaign", "Errors along the campaign",
      "Each reading, in the order of the file: a drift or a jump shows here. " +
          worst_poses(models.back(), campaign) + thinned_note(rows, drawn.size(), "readings"),
      count_axis(static_cast<double>(rows), "reading"));
  Panel& panel =
      picture->panel(round_axis(0, largest_error(models), "length of the error, mm"), 190);
  Points out;
  for (const Judged& model : models) {
    Points points;
    std::vector<std::string> texts;
    const std::vector<double> errors = model.evaluation.reading_errors();
    for (const int row : drawn) {
      const Eigen::Vector2d point(row + 1, in_mm(errors[row]));
      points.push_back(point);
      texts.push_back(fmt::format("{}: {:.3g} mm, {}", reading_name(campaign, first, row),
                                  point.y(), model.name));
      if (&model == &models.back() && !left_out.empty() && left_out[row]) out.push_back(point);
    }
    panel.points(points, model.look, model.name, texts);
  }
  if (!out.empty()) panel.points(out, Look::mark, "left out of the fit");
  return picture;
}

namespace {

struct View {
  int right, up;  // axes
  const char* from;
};

// The three views along the axes of the frame, named from above, from the side and from the front.
// If no axis is within 30 deg of the vertical, they are named by the axes.
std::vector<View> views(const Eigen::Vector3d& upwards) {
  constexpr double kUpright = 30 * kDegree;
  int k = 0;
  const double along = upwards.cwiseAbs().maxCoeff(&k);
  const bool is_down = upwards[k] < 0;
  // Right and up axis: with the direction towards the viewer they are right-handed.
  const int a = k == 2 ? 0 : k == 0 ? 1 : 2, b = k == 2 ? 1 : k == 0 ? 2 : 0;
  if (along < std::cos(kUpright) * upwards.norm())
    return {{0, 1, "along z"}, {0, 2, "along y"}, {1, 2, "along x"}};
  return {{is_down ? b : a, is_down ? a : b, "from above"},
          {a, k, is_down ? "from the side, upside down" : "from the side"},
          {b, k, is_down ? "from the front, upside down" : "from the front"}};
}

// The same vectors in three dimensions, with the box of the places.
Drawing field_in_space(const std::vector<Eigen::Vector3d>& places,
                       const std::vector<VectorField>& fields, const FieldText& text,
                       const std::vector<int>& drawn, double factor) {
  constexpr int kHeight = 300;
  constexpr double kLabelAt = 1.06;  // of the way along an edge
  Eigen::Vector3d low = places.front(), high = places.front();
  for (const Eigen::Vector3d& place : places) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  for (const VectorField& field : fields)
    for (Eigen::Index k : drawn) {
      low = low.cwiseMin(places[k] + factor * field.vectors[k]);
      high = high.cwiseMax(places[k] + factor * field.vectors[k]);
    }
  const Eigen::Vector3d middle = 0.5 * (low + high);
  const double radius = std::max(0.5 * (high - low).norm(), kMillimetre);
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(text.up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const auto in_ball = [&](const Eigen::Vector3d& place) -> Eigen::Vector3d {
    return turn * (place - middle) / radius;
  };
  auto picture = std::make_shared<Picture>(
      text.file + "-space", text.title + ", in three dimensions",
      fmt::format("The same arrows from their places, without heads. The box is {:.4g} "
                  "x {:.4g} x {:.4g} mm. On a page a pointer or the arrow keys turn it.",
                  in_mm(high.x() - low.x()), in_mm(high.y() - low.y()), in_mm(high.z() - low.z())),
      Axis{});
  Panel& panel = picture->space(kHeight);
  Places from, to;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool second : {false, true})
      for (const bool third : {false, true}) {
        Eigen::Vector3d corner = low;
        if (second) corner[(axis + 1) % 3] = high[(axis + 1) % 3];
        if (third) corner[(axis + 2) % 3] = high[(axis + 2) % 3];
        from.push_back(in_ball(corner));
        corner[axis] = high[axis];
        to.push_back(in_ball(corner));
      }
  panel.segments(from, to, std::nullopt, "");
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d end = low;
    end[axis] += kLabelAt * (high[axis] - low[axis]);
    panel.label(in_ball(end), std::string(1, "xyz"[axis]));
  }
  from.clear();
  for (Eigen::Index k : drawn) from.push_back(in_ball(places[k]));
  panel.dots(from);
  for (const VectorField& field : fields) {
    to.clear();
    std::vector<std::string> texts;
    for (Eigen::Index k : drawn) {
      to.push_back(in_ball(places[k] + factor * field.vectors[k]));
      if (!text.names.empty())
        texts.push_back(fmt::format("{}: {:.3g} mm, {}", text.names[k],
                                    in_mm(field.vectors[k].norm()), field.name));
    }
    panel.segments(from, to, field.look, field.name, texts);
  }
  return picture;
}

}  // namespace

std::vector<Drawing> field_maps(const std::vector<Eigen::Vector3d>& places,
                                const std::vector<VectorField>& fields, const FieldText& text) {
  Eigen::Vector3d low = places.front(), high = places.front();
  for (const Eigen::Vector3d& place : places) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  double longest = 0;
  const std::vector<int> drawn = evenly(places.size(), text.most);
  for (const VectorField& field : fields)
    for (Eigen::Index k : drawn) longest = std::max(longest, field.vectors[k].norm());
  const double factor = round_magnification(longest, (high - low).maxCoeff());
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(1.05 * factor * longest + 0.02 * (high - low).maxCoeff());
  low = (low - margin) / kMillimetre;
  high = (high + margin) / kMillimetre;
  std::vector<Drawing> drawings;
  for (const auto& [right, up, view] : views(text.up)) {
    const char x = "xyz"[right], y = "xyz"[up];
    const MapAxes axes =
        map_axes({low[right], low[up]}, {high[right], high[up]},
                 fmt::format("{} of {}, mm", x, text.frame), fmt::format("{}, mm", y));
    auto picture = std::make_shared<Picture>(
        fmt::format("{}-{}{}", text.file, x, y), text.title + ", " + view,
        fmt::format("{} Arrows are {:g} times as long as the {}; the longest is {:.3g} mm.{}",
                    text.note, factor, text.what, in_mm(longest),
                    thinned_note(places.size(), drawn.size(), "places")),
        axes.x);
    Panel& panel = picture->panel(axes.y, axes.height);
    Points drawn_places;
    for (Eigen::Index k : drawn) {
      const Eigen::Vector3d& place = places[k];
      drawn_places.emplace_back(in_mm(place[right]), in_mm(place[up]));
    }
    panel.dots(drawn_places);
    for (const VectorField& field : fields) {
      Points from, to;
      std::vector<std::string> texts;
      for (Eigen::Index k : drawn) {
        if (!text.names.empty())
          texts.push_back(fmt::format("{}: {:.3g} mm, {}", text.names[k],
                                      in_mm(field.vectors[k].norm()), field.name));
        const Eigen::Vector3d& place = places[k];
        const Eigen::Vector3d end = place + factor * field.vectors[k];
        from.emplace_back(in_mm(place[right]), in_mm(place[up]));
        to.emplace_back(in_mm(end[right]), in_mm(end[up]));
      }
      panel.vectors(from, to, field.look, field.name, texts);
    }
    drawings.push_back(std::move(picture));
  }
  drawings.push_back(field_in_space(places, fields, text, drawn, factor));
  return drawings;
}

std::vector<Drawing> residual_maps(const std::vector<Judged>& models, const Campaign& campaign,
                                   const Eigen::Vector3d& up) {
  if (campaign.reads_one_number()) return {};
  const PlacedResiduals placed = by_pose(models, campaign);
  std::vector<VectorField> fields;
  for (size_t m = 0; m < models.size(); ++m)
    fields.push_back({models[m].name, models[m].look, placed.residuals[m]});
  return field_maps(
      placed.places, fields,
      {.file = "map",
       .title = "Errors in the workspace",
       .frame = "the instrument's frame",
       .note = campaign.session_names.size() > 1
                   ? "Mean error of each pose, measured minus model, at its place in the "
                     "frame of its session."
                   : "Mean error of each pose, measured minus model, at its place.",
       .names = placed.names,
       .up = up});
}

}  // namespace armtrue
