#include "io/campaign_columns.h"

#include <set>
#include <utility>

#include "armtrue/campaign/campaign.h"
#include "armtrue/text/input_error.h"
#include "io/joint_columns.h"

namespace armtrue {
namespace {

class ColumnFinder {
 public:
  ColumnFinder(const CsvTable& table, const std::vector<JointName>& joints,
               const std::string& source)
      : table_(table), joints_(joints), source_(source) {}

  CampaignColumns find() {
    find_needed();
    find_others();
    find_temperatures();
    for (size_t c = 0; c < table_.columns().size(); ++c)
      if (!used_.contains(static_cast<int>(c))) columns_.unknown.push_back(table_.columns()[c]);
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
    columns_.distance = use(table_.find_length("l"));
    columns_.contact = use(table_.find("contact"));
    for (int i = 0; i < 3; ++i) columns_.position[i] = table_.find_length(std::string(1, "xyz"[i]));
    columns_.has_points = (!columns_.distance && !columns_.contact) || columns_.position[0] ||
                          columns_.position[1] || columns_.position[2];
    for (int i = 0; columns_.has_points && i < 3; ++i)
      need(columns_.position[i], std::string(1, "xyz"[i]) + "_mm");
    if (!missing.empty()) table_.fail_missing(missing);
  }

  void find_others() {
    columns_.repeat = use(table_.find("repeat"));
    columns_.time = use(table_.find("t_s"));
    columns_.target = use(table_.find("target"));
    if (columns_.distance) columns_.anchor = use(table_.find("anchor"));
    columns_.session = use(table_.find("session"));
    columns_.payload = use(table_.find("payload_kg"));
    columns_.sigma_position = use(table_.find_length("sigma"));
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
    columns_.force =
        group("a force", std::array{table_.find("fx_n"), table_.find("fy_n"), table_.find("fz_n")},
              {"fx_n", "fy_n", "fz_n"});
    const auto plain = [&](const std::vector<std::string>& names) {
      std::vector<std::optional<int>> found;
      for (const std::string& name : names) found.push_back(table_.find(name));
      return found;
    };
    const std::vector<std::string> directions = numbered_columns("dir", joints_);
    const std::vector<std::string> torques = numbered_columns("tau", joints_, "_nm");
    columns_.arrival = group("directions of arrival", plain(directions), directions);
    columns_.stroke = group("ways since the last reversal", find_strokes(table_, joints_),
                             stroke_columns(joints_));
    columns_.motor_torque = group("a set of motor torques", plain(torques), torques);
  }

  void find_temperatures() {
    for (size_t c = 0; c < table_.columns().size(); ++c) {
      const std::string& name = table_.columns()[c];
      if (!name.starts_with("temp_") || !name.ends_with("_c") || name.size() < 8) continue;
      if (columns_.temperatures.size() == kMaxTemperatures)
        table_.fail(static_cast<int>(c), "more than 8 temperatures; remove the least useful");
      columns_.temperatures.push_back(static_cast<int>(c));
      used_.insert(static_cast<int>(c));
      columns_.temperature_names.push_back(name.substr(5, name.size() - 7));
    }
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
    std::vector<std::string> missing;
    for (size_t i = 0; i < columns.size(); ++i)
      if (!columns[i]) missing.push_back(names[i]);
    if (missing.size() == columns.size()) return columns;
    if (!missing.empty())
      throw InputError(source_ + ": " + what + " also needs the column '" + missing.front() + "'");
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
