#include "io/campaign_columns.h"

#include <algorithm>
#include <set>
#include <utility>

#include "armtrue/campaign/campaign.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "io/joint_columns.h"
#include "io/mistaken_columns.h"

namespace armtrue {
namespace {

// All columns that a file of measured poses may have, except temperatures, whose names are the
// user's.
std::vector<std::string> columns_of_a_campaign(const std::vector<JointName>& joints) {
  std::vector<std::string> known{"pose",    "repeat",     "t_s",  "target", "anchor",   "contact",
                                 "session", "payload_kg", "fx_n", "fy_n",   "fz_n",     "camera",
                                 "board",   "corner",     "u_px", "v_px",   "sigma_px", "beam"};
  for (const char* component : {"qw", "qx", "qy", "qz"}) known.emplace_back(component);
  for (const char* length : {"x", "y", "z", "l", "sigma", "profile_y", "profile_z"})
    for (const char* unit : {"_mm", "_m"}) known.push_back(std::string(length) + unit);
  for (const char* angle : {"a", "b", "c", "sigma"})
    for (const char* unit : {"_deg", "_rad"}) known.push_back(std::string(angle) + unit);
  for (const auto& of_joints :
       {encoder_names(joints), stroke_columns(joints), numbered_columns("dir", joints),
        numbered_columns("tau", joints, "_nm")})
    known.insert(known.end(), of_joints.begin(), of_joints.end());
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) known.push_back(covariance_column(row, column));
  return known;
}

class ColumnFinder {
 public:
  ColumnFinder(const CsvTable& table, const std::vector<JointName>& joints,
               const std::string& source)
      : table_(table), joints_(joints), source_(source) {}

  CampaignColumns find() {
    find_needed();
    find_others();
    check_beside_pixels();
    check_beside_profiles();
    find_covariances();
    columns_.context.emplace(table_, joints_);
    used_.insert(columns_.context->used().begin(), columns_.context->used().end());
    for (int c = 0; c < std::ssize(table_.columns()); ++c)
      if (!used_.contains(c)) columns_.unknown.push_back(table_.columns()[c]);
    refuse_mistaken_columns(
        table_, columns_.unknown, columns_of_a_campaign(joints_),
        {.orientation = columns_.has_points && !columns_.abc[0] && !columns_.quaternion[0],
         .time = !table_.find("t_s"),
         .repeat = !columns_.repeat});
    columns_.unknown =
        with_likely_columns(table_, columns_.unknown, columns_of_a_campaign(joints_));
    return std::move(columns_);
  }

 private:
  void find_needed() {
    std::vector<std::string> missing;
    const auto need = [&](auto found, const std::string& name) {
      if (!use(found)) missing.push_back(name);
      return found;
    };
    columns_.pose = need(table_.find("pose"), "pose");
    columns_.q = find_encoders(table_, joints_);
    for (size_t j = 0; j < joints_.size(); ++j) need(columns_.q[j], joints_[j].encoder());
    columns_.pixel = {use(table_.find("u_px")), use(table_.find("v_px"))};
    const bool has_pixels = columns_.pixel[0] || columns_.pixel[1];
    if (has_pixels) {
      for (int i = 0; i < 2; ++i) need(columns_.pixel[i], i == 0 ? "u_px" : "v_px");
      columns_.corner = need(table_.find("corner"), "corner");
      columns_.camera = use(table_.find("camera"));
      columns_.board = use(table_.find("board"));
    }
    columns_.distance = use(table_.find_length("l"));
    columns_.contact = use(table_.find("contact"));
    columns_.profile = {use(table_.find_length("profile_y")), use(table_.find_length("profile_z"))};
    const bool has_profiles = columns_.profile[0] || columns_.profile[1];
    if (has_profiles) {
      need(columns_.profile[0], "profile_y_mm");
      need(columns_.profile[1], "profile_z_mm");
      need(columns_.contact, "contact");
    }
    if (columns_.contact || columns_.distance) columns_.beam = use(table_.find("beam"));
    if (columns_.beam && !columns_.contact) missing.emplace_back("contact");
    if (columns_.beam && !columns_.distance) missing.emplace_back("l_mm");
    for (int i = 0; i < 3; ++i) columns_.position[i] = table_.find_length(std::string(1, "xyz"[i]));
    columns_.has_points =
        (!columns_.distance && !columns_.contact && !has_pixels && !has_profiles) ||
        columns_.position[0] || columns_.position[1] || columns_.position[2];
    for (int i = 0; columns_.has_points && i < 3; ++i)
      need(columns_.position[i], std::string(1, "xyz"[i]) + "_mm");
    if (!missing.empty()) table_.fail_missing(missing, used_);
  }

  bool has_others_than_pixels() const {
    return columns_.has_points || columns_.distance || columns_.contact;
  }

  void check_beside_profiles() const {
    if (!columns_.profile[0]) return;
    for (const char* other : {"x_mm", "x_m", "y_mm", "y_m", "z_mm", "z_m", "l_mm", "l_m", "beam",
                              "u_px", "target", "a_deg", "a_rad", "qw", "sigma_deg", "sigma_rad"})
      if (table_.find(other))
        throw InputError(source_ + ": has profile_y_mm and the column '" + other +
                         "'; profiles stand in a file of their own, without other readings, "
                         "targets and orientations: leave the column out");
  }

  void check_beside_pixels() const {
    if (!columns_.corner) return;
    for (const char* other : {"a_deg", "a_rad", "qw", "sigma_deg", "sigma_rad"})
      if (table_.find(other))
        throw InputError(source_ + ": has u_px and the column '" + other +
                         "'; beside images no orientation is read, as images show how the arm is "
                         "turned: leave its columns out (a_deg,b_deg,c_deg or qw,qx,qy,qz, and "
                         "sigma_deg)");
    if (!has_others_than_pixels()) {
      for (const char* other : {"target", "anchor", "sigma_mm", "sigma_m"})
        if (table_.find(other))
          throw InputError(source_ + ": has u_px and the column '" + other +
                           "', but no other readings than images, whose rows state their noise as "
                           "sigma_px: leave the column out");
    } else if (!columns_.sigma_position || !columns_.sigma_pixel) {
      throw InputError(source_ +
                       ": images and other readings in one file also need the columns 'sigma_px', "
                       "of each image row, and 'sigma_mm', of each other one: their standard "
                       "deviations, by which they weigh against each other");
    }
  }

  void find_others() {
    columns_.repeat = use(table_.find("repeat"));
    columns_.target = use(table_.find("target"));
    if (columns_.distance) columns_.anchor = use(table_.find("anchor"));
    columns_.session = use(table_.find("session"));
    columns_.sigma_position = use(table_.find_length("sigma"));
    if (const auto sigma = columns_.corner ? use(table_.find("sigma_px")) : std::nullopt)
      columns_.sigma_pixel = CsvTable::Quantity{*sigma, 1.0};
    columns_.sigma_orientation = use(table_.find_angle("sigma"));
    columns_.abc =
        group("an orientation by angles",
              std::array{table_.find_angle("a"), table_.find_angle("b"), table_.find_angle("c")},
              {"a_deg", "b_deg", "c_deg"});
    columns_.quaternion = group(
        "an orientation by quaternion",
        std::array{table_.find("qw"), table_.find("qx"), table_.find("qy"), table_.find("qz")},
        {"qw", "qx", "qy", "qz"});
    if (columns_.abc[0] && columns_.quaternion[0])
      throw InputError(source_ + ": has both a_deg,b_deg,c_deg and qw,qx,qy,qz; keep one of them");
  }

  // One block of the covariance, rows from `row` and columns from `column` on.
  bool find_block(const std::string& what, int row, int column) {
    std::vector<std::optional<CsvTable::Quantity>> found;
    std::vector<std::string> names;
    std::vector<size_t> places;
    for (int i = row; i < row + 3; ++i)
      for (int k = std::max(i, column); k < column + 3; ++k) {
        names.push_back(covariance_column(i, k));
        places.push_back(place_of_covariance(i, k));
        found.push_back(
            table_.find_either(names.back(), covariance_unit(i, k), covariance_column(i, k, true)));
      }
    found = group(what, found, names);
    for (size_t k = 0; k < found.size(); ++k) columns_.covariance[places[k]] = found[k];
    return found.front().has_value();
  }

  void find_covariances() {
    const bool of_position = find_block("a covariance of the position", 0, 0);
    const bool of_rotation = find_block("a covariance of the rotation", 3, 3);
    const bool between = find_block("a covariance of position and rotation", 0, 3);
    const auto refuse = [&](bool wrong, const std::string& why) {
      if (wrong) throw InputError(source_ + ": " + why);
    };
    refuse(of_position && columns_.sigma_position,
           "has both sigma_mm and cov_xx_mm2; keep one of them");
    refuse(of_rotation && columns_.sigma_orientation,
           "has both sigma_deg and cov_rxrx_deg2; keep one of them");
    refuse(between && !(of_position && of_rotation),
           "cov_xrx_mm_deg and its like also need cov_xx_mm2 and cov_rxrx_deg2 and theirs");
    refuse(of_rotation && !columns_.abc[0] && !columns_.quaternion[0],
           "cov_rxrx_deg2 and its like are of an orientation; add a_deg,b_deg,c_deg or "
           "qw,qx,qy,qz");
    refuse(of_position && (columns_.distance || columns_.contact || columns_.corner),
           "cov_xx_mm2 and its like are of points and poses; give other readings sigma_mm or "
           "sigma_px in a file of their own");
  }

  template <typename Found>
  Found use(Found found) {
    if (found) {
      if constexpr (requires { found->column; })
        used_.insert(found->column);
      else
        used_.insert(*found);
    }
    return found;
  }

  // Columns of one quantity: all of them, or none.
  template <typename Columns>
  Columns group(const std::string& what, const Columns& columns,
                const std::vector<std::string>& names) {
    if (!has_all(table_, columns, names, what)) return columns;
    for (const auto& column : columns) use(column);
    return columns;
  }

  const CsvTable& table_;
  const std::vector<JointName>& joints_;
  const std::string& source_;
  CampaignColumns columns_;
  std::set<int> used_;
};

}  // namespace

CampaignColumns find_campaign_columns(const CsvTable& table, const std::vector<JointName>& joints,
                                      const std::string& source) {
  return ColumnFinder(table, joints, source).find();
}

}  // namespace armtrue
