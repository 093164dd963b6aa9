#include "io/context_columns.h"

#include <cstdint>

#include "armtrue/campaign/heaviest_payload.h"
#include "io/joint_columns.h"

namespace armtrue {
namespace {

constexpr double kAbsoluteZero = -273.15;  // deg C
constexpr double kHottest = 1000;          // deg C: higher values are the code of a missing sensor

}  // namespace

ContextColumns::ContextColumns(const CsvTable& table, const std::vector<JointName>& joints)
    : time_(table.find("t_s")), payload_(table.find("payload_kg")) {
  if (time_) used_.insert(*time_);
  if (payload_) used_.insert(*payload_);
  const auto all_of = [&](const std::string& what, const std::vector<std::string>& names) {
    std::vector<std::optional<int>> found;
    for (const std::string& name : names) found.push_back(table.find(name));
    if (!has_all(table, found, names, what)) found.clear();
    for (const std::optional<int>& column : found) used_.insert(*column);
    return found;
  };
  force_ = all_of("a force", {"fx_n", "fy_n", "fz_n"});
  arrival_ = all_of("a direction of arrival", numbered_columns("dir", joints));
  motor_torque_ = all_of("a set of motor torques", numbered_columns("tau", joints, "_nm"));
  stroke_ = find_strokes(table, joints);
  if (!has_all(table, stroke_, stroke_columns(joints), "a way since the last reversal"))
    stroke_.clear();
  for (const auto& stroke : stroke_) used_.insert(stroke->column);
  for (int c = 0; c < std::ssize(table.columns()); ++c) {
    const std::string& name = table.columns()[c];
    if (!name.starts_with("temp_") || !name.ends_with("_c") || name.size() < 8) continue;
    if (temperatures_.size() == kMaxTemperatures)
      table.fail(c, "more than 8 temperatures; remove the least useful");
    temperatures_.push_back(c);
    used_.insert(c);
    temperature_names_.push_back(name.substr(5, name.size() - 7));
  }
}

void ContextColumns::read(const CsvTable& table, Campaign& campaign) const {
  if (time_) campaign.time_s.push_back(table.seconds(*time_));
  if (payload_) {
    campaign.payload_kg.push_back(table.number(*payload_));
    if (campaign.payload_kg.back() < 0)
      table.fail(*payload_, table.quoted(*payload_) + " is below zero; a payload is a mass");
    if (campaign.payload_kg.back() > kHeaviestPayload)
      table.fail(*payload_,
                 table.quoted(*payload_) + " is more than any arm carries; give it in kg");
  }
  if (!force_.empty())
    campaign.force_n.emplace_back(table.number(*force_[0]), table.number(*force_[1]),
                                  table.number(*force_[2]));
  if (!arrival_.empty()) {
    Direction& directions = campaign.arrival.emplace_back();
    for (size_t j = 0; j < arrival_.size(); ++j) {
      const int direction = table.integer(*arrival_[j]);
      if (direction < -1 || direction > 1)
        table.fail(*arrival_[j], table.quoted(*arrival_[j]) + " is not -1, 0 or 1");
      directions[j] = static_cast<std::int8_t>(direction);
    }
  }
  if (!stroke_.empty()) {
    JointVector strokes(std::ssize(stroke_));
    for (size_t j = 0; j < stroke_.size(); ++j) strokes[j] = table.number(*stroke_[j]);
    campaign.stroke.push_back(strokes);
  }
  if (!motor_torque_.empty()) {
    auto& torques = campaign.motor_torque_nm.emplace_back();
    for (size_t j = 0; j < motor_torque_.size(); ++j) torques[j] = table.number(*motor_torque_[j]);
  }
  if (temperatures_.empty()) return;
  auto& temperatures = campaign.temperature_c.emplace_back();
  for (size_t i = 0; i < temperatures_.size(); ++i) {
    temperatures[i] = table.number(temperatures_[i]);
    if (temperatures[i] < kAbsoluteZero)
      table.fail(temperatures_[i],
                 table.quoted(temperatures_[i]) + " lies below absolute zero; correct it");
    if (temperatures[i] > kHottest)
      table.fail(temperatures_[i], table.quoted(temperatures_[i]) +
                                       " is no temperature of an arm; correct it, or leave out the "
                                       "row or the column");
  }
}

}  // namespace armtrue
